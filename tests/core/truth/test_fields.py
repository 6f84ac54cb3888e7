import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.truth.fields import ball, capsule, carved, ellipsoid, gradient, moved, ring, union

SEEDS = st.integers(0, 2**32 - 1)


def around(seed, size=3.0):
    return np.random.default_rng(seed).uniform(-size, size, size=(50, 3))


@settings(deadline=None)
@given(SEEDS)
def test_balls_rods_and_rings_tell_their_exact_distance(seed):
    p = around(seed)
    assert ball(1.0, (1, 0, 0))(p) == pytest.approx(np.linalg.norm(p - [1, 0, 0], axis=1) - 1)
    t = np.linspace(0, 1, 1001)[:, None] * [2.0, 1.0, 0.0]
    to_rod = np.linalg.norm(p[:, None] - t, axis=2).min(axis=1)
    assert capsule((0, 0, 0), (2, 1, 0), 0.5)(p) == pytest.approx(to_rod - 0.5, abs=5e-3)
    turn = np.linspace(0, 2 * np.pi, 2001)
    circle = 2.0 * np.stack((np.cos(turn), 0 * turn, np.sin(turn)), axis=1)
    to_ring = np.array([np.linalg.norm(circle - q, axis=1).min() for q in p])
    assert ring(2.0, 0.4, axis=1)(p) == pytest.approx(to_ring - 0.4, abs=5e-3)


@settings(deadline=None)
@given(SEEDS)
def test_an_ellipsoid_is_zero_where_its_equation_holds_and_its_slope_there_is_one(seed):
    radii = np.array([1.0, 2.0, 3.0])
    direction = around(seed)
    centre = np.array([0.5, 0.0, 0.0])
    surface = centre + radii * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    field = ellipsoid(radii, centre)
    assert field(surface) == pytest.approx(np.zeros(50), abs=1e-12)
    slope = gradient(field, surface, 1e-5)
    assert np.linalg.norm(slope, axis=1) == pytest.approx(np.ones(50), abs=1e-6)


@settings(deadline=None)
@given(SEEDS)
def test_a_ball_is_an_ellipsoid_with_equal_axes(seed):
    p = around(seed)
    outer = np.linalg.norm(p, axis=1) > 0.6
    assert ellipsoid((2.0, 2.0, 2.0))(p[outer]) == pytest.approx(ball(2.0)(p[outer]))


@settings(deadline=None)
@given(SEEDS, st.floats(0.01, 1.0))
def test_a_blend_adds_material_to_a_union_and_only_near_where_the_parts_meet(seed, blend):
    p = around(seed)
    one, other = ball(1.0), ball(1.0, (1.2, 0, 0))
    sharp, smooth = union(one, other)(p), union(one, other, blend=blend)(p)
    assert np.all(sharp == np.minimum(one(p), other(p)))
    assert np.all(smooth <= sharp)
    assert np.all(smooth >= sharp - blend / 6 - 1e-12)
    apart = np.abs(one(p) - other(p)) >= blend
    np.testing.assert_array_equal(smooth[apart], sharp[apart])


@settings(deadline=None)
@given(SEEDS)
def test_carving_takes_away(seed):
    p = around(seed)
    field = carved(ball(2.0), ball(1.0, (2, 0, 0)), blend=0.1)
    inside = field(p) < 0
    assert not np.any(inside & (ball(1.0, (2, 0, 0))(p) < 0))
    assert not np.any(inside & (ball(2.0)(p) > 0))


@settings(deadline=None)
@given(SEEDS)
def test_a_solid_moves_by_its_offset(seed):
    p = around(seed)
    assert moved(ball(1.0), (1, 2, 3))(p) == pytest.approx(ball(1.0, (1, 2, 3))(p))
