import numpy as np
import pytest

from core.truth.junctions import apart, diagonal, joinings, junctions


def arm(angle, count=50):
    return np.linspace(0, 1, count)[:, None] * (np.cos(angle), np.sin(angle)), False


def star(arms):
    return [arm(2 * np.pi * k / arms) for k in range(arms)]


BAR = (np.column_stack((np.linspace(-1, 1, 101), np.zeros(101))), False)


def test_a_stem_ends_on_its_bar():
    stem = (np.array([(0.305, 0.0), (0.3, 1.0)]), False)
    np.testing.assert_allclose(junctions([BAR, stem]), [[0.305, 0.0]])
    np.testing.assert_allclose(junctions([(stem[0][::-1], False), BAR]), [[0.305, 0.0]])


def test_a_stem_that_crosses_or_stays_away_does_not_end_on_the_bar():
    assert len(junctions([BAR, (np.array([(0.3, -0.5), (0.3, 1.0)]), False)])) == 0
    assert len(junctions([BAR, (np.array([(0.3, 0.1), (0.3, 1.0)]), False)])) == 0


def test_a_place_where_many_ends_meet_is_one_junction():
    assert junctions(star(5)).shape == (1, 2)


def test_closed_curves_and_curves_in_space_end_nowhere():
    ring = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    assert junctions([(ring, True), (ring + 5, True)]).shape == (0, 2)
    assert junctions([(np.arange(6.0).reshape(2, 3), False)]).shape == (0, 3)


def test_the_curve_may_end_on_the_closing_edge_of_a_ring():
    ring = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    assert len(junctions([(ring, True), (np.array([(0.0, 0.5), (-1.0, 0.5)]), False)])) == 1


@pytest.mark.parametrize(("arms", "ways"), [(2, 1), (3, 4), (4, 10), (5, 26)])
def test_a_star_is_read_in_as_many_ways_as_its_arms_pair(arms, ways):
    # the involutions of so many elements; two ends that meet are no star
    found = list(joinings(star(arms)))
    assert len(found) == ways
    for reading in found:
        length = sum(np.linalg.norm(np.diff(v, axis=0), axis=1).sum() for v, _ in reading)
        assert length == pytest.approx(arms)
        assert not any(closed for _, closed in reading)


def test_the_first_reading_is_the_curves_as_they_are():
    curves = star(3)
    first = next(joinings(curves))
    for (vertices, closed), (true, flag) in zip(first, curves, strict=True):
        np.testing.assert_array_equal(vertices, true)
        assert closed == flag


def test_arms_between_two_stars_may_close():
    # three arcs from pole to pole: joined at both poles, two of them are a ring
    t = np.linspace(0, np.pi, 50)
    arcs = [(np.column_stack((b * np.sin(t), np.cos(t))), False) for b in (-1.0, 0.0, 1.0)]
    found = list(joinings(arcs))
    assert len(found) == 16
    rings = [reading for reading in found if any(closed for _, closed in reading)]
    assert len(rings) == 3
    for reading in rings:
        assert sorted(closed for _, closed in reading) == [False, True]
        (ring,) = [v for v, closed in reading if closed]
        assert len(np.unique(ring, axis=0)) == len(ring) == 98


def test_bars_and_rings_have_one_reading():
    stem = (np.array([(0.3, 0.0), (0.3, 1.0)]), False)
    assert len(list(joinings([BAR, stem]))) == 1


def test_apart_is_by_distance_to_the_nearest_place():
    where = np.array([(0.0, 0.0), (3.0, 4.0)])
    assert apart(where, np.array([(0.0, 0.0)]), 4.9).tolist() == [False, True]
    assert apart(where, np.zeros((0, 2)), 4.9).tolist() == [True, True]


def test_the_diagonal_is_of_the_box_of_all():
    assert diagonal([(np.zeros((1, 2)), False), (np.array([(3.0, 4.0)]), True)]) == 5.0
