import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.arrangement import arrange
from core.tape.bends import GAP, draw
from core.tape.smoothing import graph_smoothing, split_smoothing, waist_smoothing
from tests.core.tape.drawings import circle, drawn, eight, flat, keep_clear, rose, segment


def crossing_lines(angle):
    """Two lines through the origin, 80 long."""
    along = np.array((np.cos(angle / 2), np.sin(angle / 2)))
    return [segment(-40 * v, 40 * v, 161) for v in (along, along * (1.0, -1.0))]


def lines_of(smoothing, sigma, beside=()):
    drawing, clean = draw(*smoothing, sigma, beside)
    assert clean
    return [one.line for one in drawing]


def both_ways(curves, **distances):
    """The two ways to smooth one crossing."""
    arrangement = arrange(curves, **distances)
    arms = arrangement.nodes[0].arms
    for turned in (arms, arms[1:] + arms[:1]):
        yield arrangement, [[(turned[0], turned[1]), (turned[2], turned[3])]]


@pytest.mark.parametrize("degrees", [10, 30, 60, 90])
def test_bends_leave_a_gap_of_the_size_of_the_noise(degrees):
    curves = crossing_lines(np.radians(degrees))
    for smoothing in both_ways(curves):
        one, other = lines_of(smoothing, 0.2)
        gap = shapely.distance(drawn(one), drawn(other))
        assert 0.5 * GAP * 0.2 < gap < (1.5 * 0.2) / np.sin(np.radians(degrees / 2)) * 1.5


@settings(max_examples=20, deadline=None)
@given(st.floats(0.001, np.pi / 2), st.floats(1e-6, 1.0))
def test_bends_stay_as_near_as_the_noise_allows(angle, sigma):
    curves = crossing_lines(angle)
    together = shapely.union_all([drawn(curve) for curve in curves])
    for smoothing in both_ways(curves):
        lines = lines_of(smoothing, sigma)
        assert keep_clear(lines)
        for line in lines:
            apart = shapely.distance(shapely.points(line.vertices[:, :2]), together)
            assert apart.max() < 2.5 * sigma + 0.02


def test_without_noise_bends_are_small_but_there():
    curves = crossing_lines(1.0)
    for smoothing in both_ways(curves):
        lines = lines_of(smoothing, 0.0)
        assert keep_clear(lines)
        moved = shapely.hausdorff_distance(
            *(shapely.multilinestrings([drawn(c) for c in x]) for x in (lines, curves))
        )
        assert 0.0 < moved < 0.1


def test_what_is_cut_off_is_less_than_half_of_an_arc():
    curves = [eight()]
    drawing, clean = draw(*next(both_ways(curves)), 10.0)
    assert clean
    assert sum(one.line.length for one in drawing) > 0.2 * curves[0].length


def test_curves_say_which_arcs_they_follow():
    curves = [eight(), circle(9.0), circle(10.0)]
    arrangement = arrange(curves)
    drawing, _ = draw(arrangement, split_smoothing(arrangement), 0.01)
    assert sorted(k for one in drawing for k in one.arcs) == list(range(len(arrangement.arcs)))
    assert all(len({arrangement.connected[k] for k in one.arcs}) == 1 for one in drawing)


def test_a_bend_around_a_corner_keeps_to_its_sector():
    # Both strands turn in the crossing: three sectors are narrow, and the fourth is reflex.
    origin = np.zeros(2)
    arms = [10.0 * np.array((np.cos(a), np.sin(a))) for a in np.radians([0.0, 35.0, 70.0, 105.0])]
    curves = [flat([arms[0], origin, arms[2]]), flat([arms[1], origin, arms[3]])]
    for smoothing in both_ways(curves):
        assert keep_clear(lines_of(smoothing, 0.3))


def test_bends_shrink_where_something_is_in_the_way():
    curves = crossing_lines(np.pi / 2)
    smoothings = list(both_ways(curves))
    for place in [(0.12, 0.0), (0.0, 0.12), (-0.12, 0.0), (0.0, -0.12)]:
        beside = [circle(*place, 0.05)]
        for smoothing in smoothings:
            assert keep_clear([*lines_of(smoothing, 0.5, beside), *beside])


def test_a_node_where_a_curve_only_ends_is_passed_unbent():
    curves = [circle(), segment((1.0, 0.0), (3.0, 0.0))]
    arrangement = arrange(curves, touching=0.01)
    for smooth in (split_smoothing, waist_smoothing):
        stick, ring = lines_of((arrangement, smooth(arrangement)), 0.05)
        assert ring.length == pytest.approx(curves[0].length)
        assert shapely.distance(drawn(ring), shapely.points(stick.vertices[0, :2])) == 0.0
        assert np.array_equal(stick.vertices[1:], curves[1].vertices[1:])


def test_arcs_of_a_graph_end_in_their_nodes():
    curves = [rose(5)]
    arrangement = arrange(curves, merging=0.01)
    for line in lines_of((arrangement, graph_smoothing(arrangement)), 0.01):
        for end in line.vertices[[0, -1]]:
            assert np.array_equal(end, arrangement.nodes[0].place)
