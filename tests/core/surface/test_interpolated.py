import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.interpolated import Stratum, between, closest, resampled, signed_distances

TURN = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)


def circle(radius, centre=(0.0, 0.0)):
    return np.asarray(centre) + radius * np.stack((np.cos(TURN), np.sin(TURN)), axis=1)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.5, 3.0), st.floats(0.5, 3.0), st.floats(0.05, 0.95))
def test_between_two_circles_lies_a_circle_with_the_interpolated_radius(low, high, share):
    (loop,) = between([Stratum(0.0, [circle(low)]), Stratum(2.0, [circle(high)])], 2.0 * share, 0.05)
    wanted = (1 - share) * low + share * high
    assert np.linalg.norm(loop, axis=1) == pytest.approx(np.full(len(loop), wanted), abs=2e-3)


def test_a_cubic_through_four_levels_follows_a_ball_where_a_straight_line_cuts_it():
    heights = [-0.75, -0.25, 0.25, 0.75]
    strata = [Stratum(z, [circle(np.sqrt(4.0 - z * z))]) for z in heights]
    straight, cubic = (between(some, 0.0, 0.03)[0] for some in (strata[1:3], strata))
    errors = [np.abs(np.linalg.norm(loop, axis=1) - 2.0).max() for loop in (straight, cubic)]
    assert errors[1] < 2e-3 < 0.2 * errors[0]


def test_contours_join_between_two_and_one():
    apart, joined = [circle(1.0, (-2.0, 0.0)), circle(1.0, (2.0, 0.0))], [circle(3.5)]
    counts = [len(between([Stratum(0.0, apart), Stratum(1.0, joined)], z, 0.05)) for z in (0.1, 0.9)]
    assert counts == [2, 1]


def test_contours_with_few_vertices_are_as_good():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    (loop,) = between([Stratum(0.0, [square]), Stratum(1.0, [square])], 0.3, 0.05)
    assert np.abs(loop).max(axis=1) == pytest.approx(np.ones(len(loop)), abs=0.03)


def test_holes_stay_holes():
    ring = [circle(3.0), circle(1.0)]
    loops = between([Stratum(0.0, ring), Stratum(1.0, ring)], 0.5, 0.05)
    assert sorted(np.linalg.norm(loop, axis=1).mean() for loop in loops) == pytest.approx(
        [1.0, 3.0], abs=2e-3
    )


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_signed_distances_to_a_ring_are_exact_and_negative_in_it(seed):
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, size=(50, 2))
    radius = np.linalg.norm(points, axis=1)
    wanted = np.maximum(radius - 3.0, 1.0 - radius)
    assert signed_distances([circle(3.0), circle(1.0)], points) == pytest.approx(wanted, abs=1e-3)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_closest_places_are_those_on_the_nearest_segment(seed, closed):
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, size=(30, 2))
    line = circle(2.0) if closed else circle(2.0)[:150]
    shape = shapely.LinearRing(line) if closed else shapely.LineString(line)
    places, along = closest([line], points, closed)
    wanted = shapely.distance(shape, shapely.points(points))
    assert np.linalg.norm(points - places, axis=1) == pytest.approx(wanted, abs=1e-6)
    assert np.linalg.norm(along, axis=1) == pytest.approx(np.ones(30))


@settings(deadline=None)
@given(st.floats(0.01, 1.0), st.booleans())
def test_resampled_vertices_lie_on_the_line_and_equally_far_apart(spacing, closed):
    line = circle(2.0)[:120]
    result = resampled(line, spacing, closed)
    shape = shapely.LinearRing(line) if closed else shapely.LineString(line)
    assert shapely.distance(shape, shapely.points(result)).max() < 1e-12
    arc = np.sort(shapely.line_locate_point(shape, shapely.points(result)))[: -1 if closed else None]
    assert np.diff(arc) == pytest.approx(np.full(len(arc) - 1, np.diff(arc)[0]), rel=1e-6)
    assert np.diff(arc)[0] <= spacing * (1 + 1e-9)


def test_a_parabola_through_three_levels_follows_a_ball_on_either_side():
    heights = [-0.75, -0.25, 0.25, 0.75]
    strata = [Stratum(z, [circle(np.sqrt(4.0 - z * z))]) for z in heights]
    straight = between(strata[1:3], 0.0, 0.03)[0]
    for some in (strata[:3], strata[1:]):
        (loop,) = between(some, 0.0, 0.03)
        assert np.abs(np.linalg.norm(loop, axis=1) - 2.0).max() < 2e-3
    assert np.abs(np.linalg.norm(straight, axis=1) - 2.0).max() > 0.01
