import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.frame import Plane, is_quasi_planar, principal_frame, principal_frames
from core.truth import point_set
from tests.core.cloud import brute

SEEDS = st.integers(0, 2**32 - 1)
DIMENSIONS = st.sampled_from([2, 3])


def cloud(generator, dimension, count=200):
    """Skew points with three distinct variances: every axis and every sign is determined."""
    skew = generator.gamma(1.5, size=(count, dimension)) * ([5.0, 2.0, 0.7][:dimension])
    return skew @ brute.rotation(generator, dimension).T


@given(DIMENSIONS, SEEDS)
@settings(deadline=None)
def test_frames_are_right_handed_and_sorted_by_variance(dimension, seed):
    points = cloud(np.random.default_rng(seed), dimension)
    frame = principal_frame(points, component=7)
    assert frame.component == 7
    np.testing.assert_allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)
    np.testing.assert_allclose(frame.origin[:dimension], points.mean(axis=0), atol=1e-12)
    along = (points - points.mean(axis=0)) @ frame.axes[:dimension, :dimension].T
    np.testing.assert_allclose(np.cov(along.T, bias=True), np.diag(along.var(axis=0)), atol=1e-12)
    assert (np.diff(along.var(axis=0)) <= 0).all()
    if dimension == 2:
        np.testing.assert_array_equal(frame.axes[2], [0, 0, 1])
        assert frame.origin[2] == 0
        assert frame.planarity == 1
    else:
        assert frame.planarity == pytest.approx(1 - along.std(axis=0)[2] / along.std(axis=0)[1])


@given(DIMENSIONS, SEEDS, st.floats(1e-150, 1e150))
@settings(deadline=None)
def test_a_moved_point_set_has_the_moved_frame(dimension, seed, scale):
    generator = np.random.default_rng(seed)
    points = cloud(generator, dimension)
    turn, shift = brute.rotation(generator, dimension), generator.normal(size=dimension)
    order = generator.permutation(len(points))
    moved = principal_frame(scale * (points @ turn.T + shift)[order])
    still = principal_frame(points)
    # The sign of an axis is free where the distribution along it is symmetric, which random points are not.
    axes = still.axes[:dimension, :dimension] @ turn.T
    np.testing.assert_allclose(moved.axes[:dimension, :dimension], axes, atol=1e-8)
    origin = scale * (still.origin[:dimension] @ turn.T + shift)
    np.testing.assert_allclose(moved.origin[:dimension], origin, rtol=1e-10, atol=1e-10 * scale)
    assert moved.planarity == pytest.approx(still.planarity, abs=1e-9)


@given(SEEDS)
@settings(deadline=None)
def test_an_offset_leaves_the_axes(seed):
    generator = np.random.default_rng(seed)
    points = cloud(generator, 3)
    moved = principal_frame(points + 1e8)
    np.testing.assert_allclose(moved.axes, principal_frame(points).axes, atol=1e-5)


@given(SEEDS)
@settings(deadline=None)
def test_groups_have_the_frames_that_they_have_alone(seed):
    generator = np.random.default_rng(seed)
    sizes = generator.integers(1, 40, 6)
    groups = [
        10.0**power * cloud(generator, 3, n) for n, power in zip(sizes, range(-60, 60, 20), strict=True)
    ]
    together = principal_frames(np.concatenate(groups), np.concatenate(([0], np.cumsum(sizes))))
    for k, (frame, group) in enumerate(zip(together, groups, strict=True)):
        alone = principal_frame(group)
        assert frame.component == k
        np.testing.assert_array_equal(frame.axes, alone.axes)
        np.testing.assert_array_equal(frame.origin, alone.origin)


def test_no_groups_have_no_frames():
    assert principal_frames(np.zeros((0, 3)), np.array([0])) == ()


@given(SEEDS, st.floats(0.01, 100))
@settings(deadline=None)
def test_a_tilted_plane_is_exactly_planar(seed, stretch):
    generator = np.random.default_rng(seed)
    flat = generator.normal(size=(100, 3)) * [stretch, 1, 0]
    turn = brute.rotation(generator, 3)
    frame = principal_frame(flat @ turn.T + 5.0)
    assert frame.planarity == pytest.approx(1.0, abs=1e-9)
    assert abs(frame.axes[2] @ turn[:, 2]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("points", [
    np.zeros((1, 3)),
    np.full((9, 3), 1e9),
    np.outer(np.arange(10.0), [1.0, 2.0, -1.0]) + 100.0,
    np.outer(np.random.default_rng(6).normal(size=500), [0.3, 0.1, 0.7]) + 1e6,
])  # fmt: skip
def test_points_and_lines_are_planar(points):
    frame = principal_frame(points)
    assert frame.planarity == 1.0
    np.testing.assert_allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)
    assert is_quasi_planar(points)


@pytest.mark.parametrize("size", [1.7e308, 1e-308, 5e-324])
def test_frames_of_extreme_coordinates_are_finite(size):
    corners = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1.0]])
    frame = principal_frame(corners * size)
    np.testing.assert_allclose(frame.origin, [0, 0, size], atol=size * 1e-9)
    assert abs(frame.axes[2, 2]) == pytest.approx(1.0)


@given(DIMENSIONS, SEEDS)
@settings(deadline=None)
def test_lifting_undoes_projecting(dimension, seed):
    generator = np.random.default_rng(seed)
    points = cloud(generator, dimension)
    plane = Plane.of(points)
    flat = generator.normal(size=(50, 2))
    lifted = plane.lift(flat)
    assert lifted.shape == (50, dimension)
    np.testing.assert_allclose(plane.project(lifted), flat, atol=1e-12)
    np.testing.assert_allclose(plane.distances(lifted), 0.0, atol=1e-12)
    foot = plane.lift(plane.project(points))
    np.testing.assert_allclose(points - foot, np.outer(plane.distances(points), plane.normal), atol=1e-12)
    # Rigid: distances in the plane are distances in space.
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(flat, axis=0), axis=1), np.linalg.norm(np.diff(lifted, axis=0), axis=1)
    )


def test_the_best_plane_leaves_the_least_squared_distances():
    generator = np.random.default_rng(8)
    points = cloud(generator, 3)
    best = np.sum(Plane.of(points).distances(points) ** 2)
    for _ in range(50):
        normal = generator.normal(size=3)
        normal /= np.linalg.norm(normal)
        assert np.sum(((points - points.mean(axis=0)) @ normal) ** 2) >= best


@pytest.mark.parametrize("n", [300, 3000, 30_000])
@pytest.mark.parametrize("sigma", [0.0025, 0.01, 0.03])
@pytest.mark.parametrize(
    ("name", "planar"), [("tilted", True), ("helix", False), ("trefoil", False), ("saddle", False)]
)
def test_curves_are_quasi_planar_when_only_the_noise_leaves_the_plane(name, planar, n, sigma):
    sample = point_set(name, n=n, sigma=sigma, seed=n)
    assert is_quasi_planar(sample.points) is planar
    assert is_quasi_planar(1e6 * sample.points + 1e9) is planar
    assert is_quasi_planar(sample.points, sample.sigma) is planar


@pytest.mark.parametrize("name", ["circle", "spiral", "figure_8", "square"])
def test_noise_within_the_plane_alone_keeps_a_curve_planar(name):
    generator = np.random.default_rng(9)
    flat = point_set(name, n=2000, sigma=0.02).points
    tilted = np.column_stack((flat, np.zeros(len(flat)))) @ brute.rotation(generator, 3).T
    assert is_quasi_planar(tilted)
    assert is_quasi_planar(flat)
    bent = tilted + 0.2 * np.ptp(flat) * np.outer(
        np.sin(5 * flat[:, 0] / np.ptp(flat[:, 0])), Plane.of(tilted).normal
    )
    assert not is_quasi_planar(bent)
