import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.branches import near_branches
from core.refine.further_feet import further_feet
from core.refine.polyline import Polyline
from core.refine.project import project
from tests.core.refine.test_branches import CUT, SIGMA, figure_8, hairpin, ring, straight
from tests.core.shapes import arc, distances, in_space, rotation


def feet_on(points, *lines):
    branches = near_branches(lines, np.full(len(lines), SIGMA), CUT)
    first = project(points, lines, CUT * SIGMA)
    further, mass = further_feet(points, first.curve, first.station, first.distance, branches)
    return first, further, mass


def cloud(rng, n=800, half=0.08):
    """Places about the origin, in a plane."""
    return in_space(rng.uniform(-half, half, size=(n, 2)))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.15, np.pi / 2))
def test_about_a_crossing_samples_have_a_foot_on_either_curve(seed, angle):
    rng = np.random.default_rng(seed)
    turn = rotation(rng, 3).T
    one, two = (Polyline(line.vertices @ turn, False) for line in (straight(), straight(angle=angle)))
    points = cloud(rng) @ turn
    first, further, _ = feet_on(points, one, two)
    away = np.stack([distances(points, line.vertices, False) for line in (one, two)])
    both = np.all(away < 0.999 * CUT * SIGMA, axis=0)
    assert np.all(np.isin(np.flatnonzero(both), further.sample))
    mine = further.sample[further.row]
    np.testing.assert_array_equal(further.curve, 1 - first.curve[mine])
    np.testing.assert_allclose(further.distance, away[further.curve, mine], atol=1e-12)
    np.testing.assert_array_equal(further.branch, 1.0)
    places = np.where((further.curve == 0)[:, None], one.at(further.station), two.at(further.station))
    np.testing.assert_allclose(np.linalg.norm(places - points[mine], axis=1), further.distance, atol=1e-12)


def test_about_a_crossing_with_itself_a_curve_has_two_feet():
    curve, points = figure_8(), cloud(np.random.default_rng(0), 2000)
    first, further, _ = feet_on(points, curve)
    mine = further.sample[further.row]
    way = np.abs(first.station[mine] - further.station)
    assert np.all(np.minimum(way, curve.length - way) > 1.0)
    # Either foot lies on its own strand, which crosses the origin rising or falling.
    strands = [Polyline(curve.vertices[part], False) for part in (slice(100, 300), slice(500, 700))]
    away = np.sort([distances(points, line.vertices, False) for line in strands], axis=0)
    assert np.count_nonzero(away[1] < 0.999 * CUT * SIGMA) > 300
    assert np.all(np.isin(np.flatnonzero(away[1] < 0.999 * CUT * SIGMA), further.sample))
    np.testing.assert_allclose(first.distance[mine], away[0, mine], atol=1e-9)
    np.testing.assert_allclose(further.distance, away[1, mine], atol=1e-9)


def test_at_a_triple_point_there_are_two_further_feet():
    lines = [straight(angle=angle) for angle in (0.0, np.pi / 3, 2 * np.pi / 3)]
    points = cloud(np.random.default_rng(1), half=0.02)
    first, further, _ = feet_on(points, *lines)
    assert np.all(np.bincount(further.row) == 2)
    curves = np.column_stack((first.curve[further.sample], further.curve.reshape(-1, 2)))
    np.testing.assert_array_equal(np.sort(curves, axis=1), np.tile([0, 1, 2], (len(curves), 1)))
    assert np.all(np.diff(further.distance.reshape(-1, 2), axis=1) >= 0.0)


def test_clear_of_the_other_curve_there_is_one_foot():
    points = cloud(np.random.default_rng(2), 5000, 0.4)
    one, two = straight(), straight(angle=1.0)
    _, further, _ = feet_on(points, one, two)
    away = np.max([distances(points, line.vertices, False) for line in (one, two)], axis=0)
    assert np.all(away[further.sample] < CUT * SIGMA)


def test_the_two_sides_of_a_hairpin_part_gradually():
    gap = 5.0 * SIGMA
    curve = hairpin(gap)
    # Places on the middle line, from the bend's middle to far between the legs.
    along = np.linspace(0.0, -0.3, 400)
    points = in_space(np.column_stack((along, np.full(400, 1e-4))))
    _, further, _ = feet_on(points, curve)
    x = along[further.sample[further.row]]
    assert np.all(further.branch[x < -10.0 * SIGMA] == 1.0)
    assert not np.any(x > -1.0 * SIGMA)
    order = np.argsort(-x)
    assert np.all(np.diff(further.branch[order]) > -1e-9)
    assert np.abs(np.diff(further.branch[order])).max() < 0.05


def test_a_bend_is_no_second_branch():
    # The bend of the hairpin, and samples all over the place between its legs and round it.
    rng = np.random.default_rng(3)
    curve = hairpin(6.0 * SIGMA)
    points = in_space(np.column_stack((rng.uniform(0.0, 0.06, 500), rng.uniform(-0.06, 0.06, 500))))
    _, further, _ = feet_on(points, curve)
    assert len(further.sample) == 0


@pytest.mark.parametrize("n", [1, 3000])
def test_first_feet_are_counted_by_node(n):
    points = in_space(np.concatenate((arc(n, SIGMA, 1.0), arc(n, SIGMA, 1.05, seed=1))))
    first, further, mass = feet_on(points, ring(1.0), ring(1.05))
    assert mass.sum() == np.count_nonzero(first.curve >= 0)
    if n > 1:
        assert mass.std() < 3.0 * np.sqrt(mass.mean())
        assert np.all(mass[further.node] > 0)
