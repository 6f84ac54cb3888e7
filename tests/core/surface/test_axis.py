import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.axis import axis_frame

COORDINATES = st.floats(-1e3, 1e3)
AXES = st.tuples(COORDINATES, COORDINATES, COORDINATES).filter(lambda axis: max(map(abs, axis)) > 1e-3)


@settings(deadline=None)
@given(AXES)
def test_a_frame_is_a_rotation_whose_third_row_is_the_axis(axis):
    frame = axis_frame(axis)
    assert frame.axes @ frame.axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(frame.axes) == pytest.approx(1.0)
    assert frame.axes[2] * np.linalg.norm(axis) == pytest.approx(np.array(axis), rel=1e-9, abs=1e-9)


@settings(deadline=None)
@given(AXES, st.integers(0, 2**32 - 1))
def test_points_come_back_from_their_plane_and_height(axis, seed):
    points = np.random.default_rng(seed).normal(size=(5, 3))
    frame = axis_frame(axis)
    flat, heights = frame.to_plane(points), frame.heights(points)
    for k in range(5):
        assert frame.lift(flat[k : k + 1], heights[k])[0] == pytest.approx(points[k], abs=1e-12)


def test_the_plane_of_the_default_axis_has_the_coordinates_x_and_y():
    points = np.arange(12.0).reshape(4, 3) / 7
    frame = axis_frame((0.0, 0.0, 5.0))
    np.testing.assert_array_equal(frame.to_plane(points), points[:, :2])
    np.testing.assert_array_equal(frame.heights(points), points[:, 2])


@pytest.mark.parametrize("size", [1e-300, 1e300])
def test_the_length_of_an_axis_does_not_matter(size):
    np.testing.assert_array_equal(axis_frame((size, 2 * size, 0)).axes, axis_frame((1, 2, 0)).axes)
