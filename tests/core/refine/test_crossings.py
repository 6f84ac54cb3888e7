import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.refine.crossings import crossings
from core.refine.polyline import Polyline
from core.truth import point_set
from tests.core.shapes import in_space, rotation


def flat(rows, closed=False):
    return Polyline(in_space(np.array(rows, float)), closed)


def places(meetings):
    return np.array([m.place for m in meetings]).reshape(-1, 3)


def true_polylines(name, count=400):
    return [Polyline(in_space(c.exact.polyline(count)), c.closed) for c in point_set(name, n=10).curves]


@pytest.mark.parametrize("name", ["figure_8", "double_8", "lissajous", "circle", "star", "nested", "spiral"])
@pytest.mark.parametrize("count", [397, 400])
def test_the_exact_curves_cross_where_they_do(name, count):
    truth = point_set(name, n=10).crossings
    found = places(crossings(true_polylines(name, count)))[:, :2]
    assert len(found) == len(truth)
    for place in truth:
        assert np.linalg.norm(found - place, axis=1).min() < 0.02


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_two_random_lines_cross_where_shapely_says(seed):
    rng = np.random.default_rng(seed)
    a, b = (np.cumsum(rng.normal(size=(12, 2)), axis=0) for _ in range(2))
    met = shapely.get_coordinates(shapely.intersection(shapely.LineString(a), shapely.LineString(b)))
    between = [m for m in crossings([flat(a), flat(b)]) if m.curves == (0, 1)]
    found = places(between)[:, :2]
    assert len(found) == len(met)
    np.testing.assert_allclose(found[np.lexsort(found.T)], met[np.lexsort(met.T)], atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_a_line_is_simple_when_shapely_says_so(seed, closed):
    rng = np.random.default_rng(seed)
    line = flat(np.cumsum(rng.normal(size=(rng.integers(4, 9), 2)), axis=0), closed)
    simple = shapely.is_simple(shapely.LineString(line.ring[:, :2]))
    assert (len(crossings([line])) == 0) == simple


@settings(max_examples=30, deadline=None)
@given(st.floats(0.05, np.pi - 0.05), st.integers(0, 2**32 - 1))
def test_the_angle_is_that_between_the_lines(angle, seed):
    rng = np.random.default_rng(seed)
    turn, shift = rotation(rng, 2), rng.normal(size=2)
    one = np.array([(-1.0, 0.0), (1.5, 0.0)]) @ turn.T + shift
    two = np.array([(-1.0, -1.0), (2.0, 2.0)]) * (np.cos(angle), np.sin(angle)) @ turn.T + shift
    (meeting,) = crossings([flat(one), flat(two)])
    assert meeting.curves == (0, 1)
    assert meeting.angle == pytest.approx(np.degrees(min(angle, np.pi - angle)), abs=1e-6)
    np.testing.assert_allclose(meeting.place, [*shift, 0.0], atol=1e-9)


def test_curves_are_named_in_their_order():
    lines = [flat([(0, 9), (1, 9)]), flat([(0, 0), (1, 1)]), flat([(0, 1), (1, 0)])]
    (meeting,) = crossings(lines)
    assert meeting.curves == (1, 2)
    assert meeting.angle == pytest.approx(90.0)


def test_a_closing_edge_can_be_crossed():
    triangle, stick = [(0, 0), (4, 0), (2, 3)], [(0.0, 1.0), (2.0, 1.0)]
    assert len(crossings([flat(triangle, True), flat(stick)])) == 1
    assert len(crossings([flat(triangle, False), flat(stick)])) == 0


def test_a_crossing_in_a_common_vertex_counts_once():
    one, two = [(-1, -1), (0, 0), (1, 1)], [(-1, 1), (0, 0), (1, -1)]
    (meeting,) = crossings([flat(one), flat(two)])
    np.testing.assert_allclose(meeting.place, 0.0, atol=1e-12)


def test_a_curve_may_cross_itself_in_a_vertex():
    bow = flat([(-1, -1), (0, 0), (1, 1), (1, -1), (0, 0), (-1, 1)], True)
    (meeting,) = crossings([bow])
    assert meeting.curves == (0, 0)


def test_neighbouring_edges_do_not_cross():
    assert crossings([flat([(0, 0), (1, 0), (1, 1), (0, 1)], True)]) == []
    assert crossings([flat([(0, 0), (1, 0), (1, 1)], True)]) == []
    assert crossings([flat([(0, 0), (1, 0), (0.2, 0.1)])]) == []


def test_curves_on_top_of_each_other_do_not_cross():
    one = [(0, 0), (1, 0.0), (2, 0.0)]
    assert crossings([flat(one), flat(one)]) == []
    assert crossings([flat(one), flat([(0.5, 0.0), (3.0, 0.0)])]) == []


@pytest.mark.parametrize("x", [-1.0, -0.5, 0.0])
def test_a_repeated_vertex_is_no_obstacle(x):
    one, two = flat([(-1, 0), (x, 0), (x, 0), (1, 0)]), flat([(0, -1), (0, 1)])
    (meeting,) = crossings([one, two])
    assert meeting.angle == pytest.approx(90.0)
    np.testing.assert_allclose(meeting.place, 0.0, atol=1e-12)


def test_a_curve_shrunk_to_a_point_crosses_nothing():
    dot = flat([(0.3, 0.3)] * 5, True)
    assert crossings([dot, flat([(0, 0), (1, 1)])]) == []


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_the_direction_of_a_curve_does_not_matter(seed, closed):
    rng = np.random.default_rng(seed)
    one, two = (np.cumsum(rng.normal(size=(9, 2)), axis=0) for _ in range(2))
    there = places(crossings([flat(one, closed), flat(two)]))
    back = places(crossings([flat(one[::-1], closed), flat(two[::-1])]))
    assert len(there) == len(back)
    np.testing.assert_allclose(there[np.lexsort(there.T)], back[np.lexsort(back.T)], atol=1e-9)


def test_no_curves_no_crossings():
    assert crossings([]) == []


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_the_stations_lead_to_the_place_on_both_curves(seed, closed):
    rng = np.random.default_rng(seed)
    lines = [flat(np.cumsum(rng.normal(size=(9, 2)), axis=0), closed) for _ in range(2)]
    for meeting in crossings(lines):
        for k, station in zip(meeting.curves, meeting.stations, strict=True):
            np.testing.assert_allclose(lines[k].at(np.array([station]))[0], meeting.place, atol=1e-9)


def test_a_curve_that_touches_another_in_a_vertex_does_not_cross_it():
    line, wedge = flat([(-2, 0), (0, 0), (2, 0)]), [(-1, 1), (0, 0), (1, 1)]
    assert crossings([line, flat(wedge)]) == []
    assert crossings([flat([(-2, 0), (2, 0)]), flat(wedge)]) == []
    assert len(crossings([line, flat([(-1, 1), (0, 0), (1, -1)])])) == 1


def test_a_curve_that_ends_on_another_does_not_cross_it():
    line = flat([(-2, 0), (0, 0), (2, 0)])
    for end in [(0, 0), (1, 0)]:
        for stick in ([end, (0, 5)], [(0, 5), end]):
            assert crossings([line, flat(stick)]) == []
            assert crossings([flat(stick), line]) == []


def test_a_crossing_in_the_seam_of_a_closed_curve_counts_once():
    ways = np.array([(0, 0), (1, 1), (1, -1), (0, 0), (-1, 1), (-1, -1)], float)
    for shift in range(len(ways)):
        (meeting,) = crossings([flat(np.roll(ways, shift, axis=0), True)])
        np.testing.assert_allclose(meeting.place, 0.0, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_closed_curves_on_a_lattice_cross_each_other_an_even_number_of_times(seed):
    # Vertices on edges and common vertices abound; where edges coincide there is no even or odd.
    rng = np.random.default_rng(seed)
    one, two = (
        shapely.get_coordinates(shapely.convex_hull(shapely.MultiPoint(points)))[:-1]
        for points in rng.integers(0, 6, (2, 9, 2))
    )
    assume(shapely.intersection(shapely.LinearRing(one), shapely.LinearRing(two)).length == 0.0)
    assert len(crossings([flat(one, True), flat(two, True)])) % 2 == 0
