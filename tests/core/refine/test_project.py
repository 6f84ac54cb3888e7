import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.polyline import Polyline
from core.refine.project import project
from tests.core.shapes import distances, in_space

SEEDS = st.integers(0, 2**32 - 1)


def scene(seed, dimension, count=None):
    """Random polylines, and points around them."""
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(count or rng.integers(1, 4)):
        steps = rng.normal(size=(rng.integers(2, 15), dimension))
        vertices = in_space(np.cumsum(steps, axis=0) + 2 * rng.normal(size=dimension))
        lines.append(Polyline(vertices, bool(rng.integers(2)) and len(vertices) > 2))
    return lines, in_space(3 * rng.normal(size=(rng.integers(1, 120), dimension)))


def brute_force(points, lines):
    return np.array([distances(points, line.vertices, line.closed) for line in lines])


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from([2, 3]), st.floats(0.05, 5.0), st.booleans())
def test_feet_are_those_of_brute_force(seed, dimension, reach, rivals):
    lines, points = scene(seed, dimension)
    feet = project(points, lines, reach, rivals)
    each = brute_force(points, lines)
    nearest = each.min(axis=0)
    near = nearest < reach
    np.testing.assert_array_equal(feet.curve >= 0, near)
    np.testing.assert_array_equal(np.isfinite(feet.distance), near)
    np.testing.assert_allclose(feet.distance[near], nearest[near], atol=1e-9)
    # Of curves equally near either may be named.
    np.testing.assert_allclose(each[feet.curve[near], np.flatnonzero(near)], nearest[near], atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.sampled_from([2, 3]), st.booleans())
def test_the_station_leads_to_the_foot(seed, dimension, rivals):
    lines, points = scene(seed, dimension)
    feet = project(points, lines, 4.0, rivals)
    for k, line in enumerate(lines):
        mine = feet.curve == k
        assert np.all(feet.station[mine] >= 0.0)
        assert np.all(feet.station[mine] <= line.length + 1e-9)
        gap = np.linalg.norm(line.at(feet.station[mine]) - points[mine], axis=1)
        np.testing.assert_allclose(gap, feet.distance[mine], atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_in_the_plane_shapely_agrees(seed):
    lines, points = scene(seed, 2, 1)
    feet = project(points, lines, 100.0)
    there = shapely.LineString(lines[0].ring[:, :2])
    here = shapely.points(points[:, :2])
    np.testing.assert_allclose(feet.distance, shapely.distance(here, there), atol=1e-9)
    foot = shapely.line_interpolate_point(there, feet.station)
    np.testing.assert_allclose(shapely.distance(here, foot), feet.distance, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.sampled_from([2, 3]), st.floats(0.3, 5.0))
def test_rivals_are_the_nearest_other_curves(seed, dimension, reach):
    lines, points = scene(seed, dimension, 3)
    feet = project(points, lines, reach, rivals=True)
    each = np.sort(brute_force(points, lines), axis=0)
    second = np.where(each[1] < reach, each[1], np.inf)
    near = each[0] < reach
    np.testing.assert_allclose(feet.other[near], second[near], atol=1e-9)


def test_one_curve_is_no_rival_to_itself():
    lines, points = scene(0, 2, 1)
    assert np.isinf(project(points, lines, 10.0, rivals=True).other).all()


def test_without_any_segment_in_reach_there_is_no_foot():
    line = Polyline(in_space(np.array([(0.0, 0.0), (1.0, 0.0)])), False)
    points = in_space(np.array([(0.5, 0.0), (0.5, 0.1), (0.5, 0.3), (900.0, 0.0), (0.5, -1e12)]))
    feet = project(points, [line], 0.2)
    assert feet.curve.tolist() == [0, 0, -1, -1, -1]
    np.testing.assert_allclose(feet.distance, [0.0, 0.1, np.inf, np.inf, np.inf])


@pytest.mark.parametrize("reach", [1e-9, 1e-3, 1e3])
def test_reach_may_be_tiny_or_huge_beside_the_curve(reach):
    angle = np.linspace(0.0, 6.0, 200)
    circle = in_space(np.column_stack((np.cos(angle), np.sin(angle))))
    feet = project(circle * (1.0 + 0.5 * reach), [Polyline(circle, False)], reach)
    assert np.all(feet.curve == 0)
    np.testing.assert_allclose(feet.distance, 0.5 * reach, rtol=0.01 if reach < 1 else 0.5, atol=1e-14)


def test_a_curve_of_one_place_is_a_point():
    dot = Polyline(np.zeros((2, 3)), False)
    feet = project(np.array([[0.3, 0.4, 0.0]]), [dot], 1.0)
    assert feet.distance[0] == pytest.approx(0.5)
    assert feet.station[0] == 0.0


def test_points_out_of_the_curves_plane_are_measured_in_space():
    line = Polyline(np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]), False)
    points = np.array([(0.5, 0.0, 0.0), (0.5, 0.0, 0.3), (0.2, 0.4, 0.3)])
    np.testing.assert_allclose(project(points, [line], 1.0).distance, [0.0, 0.3, 0.5], atol=1e-12)
