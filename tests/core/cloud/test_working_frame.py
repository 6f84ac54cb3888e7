import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from core.cloud.frame import principal_frame
from core.cloud.working_frame import working_frame
from tests.core.shapes import diagonal, rotation


def cloud(seed, dimension, offset=0.0, scale=1.0):
    rng = np.random.default_rng(seed)
    shape = np.array([3.0, 1.0, 0.05])[:dimension]
    points = (rng.normal(size=(30, dimension)) * shape) @ rotation(rng, dimension).T
    return scale * (points + offset * rng.normal(size=dimension))


def to_work(points, flat):
    return working_frame(points, principal_frame(points).axes, flat)


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([2, 3]),
    st.sampled_from([0.0, 1e7]),
    st.sampled_from([1e-9, 1.0, 1e9]),
)
def test_there_and_back_is_the_same_place(seed, dimension, offset, scale):
    points = cloud(seed, dimension, offset, scale)
    work, frame = to_work(points, flat=False)
    assert work.shape == (30, 3)
    rounding = 1e-12 * diagonal(points) + 4 * np.spacing(np.abs(points).max())
    np.testing.assert_allclose(frame.restore(work), points, rtol=0, atol=rounding)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from([1e-6, 1.0, 1e6]))
def test_the_way_is_a_similarity_with_the_stated_scale(seed, dimension, scale):
    points = cloud(seed, dimension, 2.0, scale)
    work, frame = to_work(points, flat=False)
    np.testing.assert_allclose(pdist(work) * frame.scale, pdist(points), rtol=1e-9)
    np.testing.assert_allclose(work.mean(axis=0), 0.0, atol=1e-12)
    assert np.sum(work**2) / points.size == pytest.approx(1.0)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_flat_frame_projects_on_the_best_plane(seed):
    points = cloud(seed, 3, 2.0)
    work, frame = to_work(points, flat=True)
    assert frame.flat
    np.testing.assert_array_equal(work[:, 2], 0.0)
    plane = principal_frame(points)
    normal = plane.axes[2]
    height = (points - points.mean(axis=0)) @ normal
    np.testing.assert_allclose(frame.restore(work), points - np.outer(height, normal), atol=1e-9)


def test_planar_input_stays_in_its_own_axes():
    points = cloud(0, 2)
    work, frame = working_frame(points, np.eye(3)[[1, 2, 0]], False)
    assert frame.flat
    assert frame.dimension == 2
    np.testing.assert_array_equal(work[:, 2], 0.0)
    np.testing.assert_allclose(work[:, :2] * frame.scale, points - points.mean(axis=0), atol=1e-12)
    assert frame.restore(work).shape == (30, 2)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_a_rotated_or_mirrored_planar_cloud_that_is_turned_works_in_the_same_coordinates(seed, mirrored):
    points = cloud(seed, 2)
    turn = rotation(np.random.default_rng(seed), 2)
    if mirrored:
        turn[:, 0] *= -1.0
    one, _ = working_frame(points, principal_frame(points).axes, True, turned=True)
    moved = points @ turn.T
    other, frame = working_frame(moved, principal_frame(moved).axes, True, turned=True)
    np.testing.assert_allclose(one, other, atol=1e-9)
    np.testing.assert_array_equal(other[:, 2], 0.0)
    np.testing.assert_allclose(frame.restore(other), moved, atol=1e-12)
    corners = [np.cross(p[1] - p[0], p[2] - p[0]) for p in (np.pad(moved[:3], ((0, 0), (0, 1))), other[:3])]
    assert frame.mirrored == bool(corners[0][2] * corners[1][2] < 0.0)


def test_any_place_can_be_brought_back_not_only_the_points():
    points = cloud(1, 3)
    work, frame = to_work(points, flat=False)
    middle = 0.5 * (work[:10] + work[10:20])
    np.testing.assert_allclose(frame.restore(middle), 0.5 * (points[:10] + points[10:20]), atol=1e-12)


def test_coincident_points_have_the_scale_one():
    work, frame = working_frame(np.full((12, 2), 3.0), np.eye(3), True)
    assert frame.scale == 1.0
    np.testing.assert_array_equal(work, 0.0)
    np.testing.assert_array_equal(frame.restore(work), 3.0)
