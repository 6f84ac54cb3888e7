import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import InvalidParameter
from core.surface.levels import level_heights, sample_distance
from core.surface.parameters import MAX_LEVELS, SliceParameters
from core.surface.results import Mesh
from surface.meshes import box


def heights_of(meshes, **parameters):
    heights = [mesh.vertices[:, 2] for mesh in meshes]
    return level_heights(meshes, heights, SliceParameters(**parameters))


@settings(deadline=None)
@given(st.integers(1, 500), st.floats(-100, 100), st.floats(0.01, 100))
def test_levels_lie_in_the_middle_of_equal_layers(count, low, size):
    heights = heights_of([box((0, 0, low), (1, 1, low + size))], levels=count)
    edges = low + np.arange(count + 1) * size / count
    assert heights == pytest.approx((edges[1:] + edges[:-1]) / 2, abs=1e-9 * (abs(low) + size))


@settings(deadline=None)
@given(st.floats(0.05, 5.0), st.floats(-100, 100), st.floats(0.01, 100))
def test_planes_with_a_spacing_fit_in_the_extent_about_its_middle(spacing, low, size):
    heights = heights_of([box((0, 0, low), (1, 1, low + size))], spacing=spacing)
    assert np.diff(heights) == pytest.approx(np.full(len(heights) - 1, spacing))
    assert (heights[0] + heights[-1]) / 2 == pytest.approx(low + size / 2)
    assert len(heights) == max(1, int(size / spacing + 1e-9))


def test_several_meshes_have_one_extent():
    meshes = [
        box((0, 0, 0), (1, 1, 1)),
        Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)),
        box((0, 0, 5), (1, 1, 9)),
    ]
    assert heights_of(meshes, levels=3) == pytest.approx([1.5, 4.5, 7.5])


def test_more_planes_than_there_may_be_are_refused():
    with pytest.raises(InvalidParameter):
        heights_of([box()], spacing=0.9 / MAX_LEVELS)
    assert len(heights_of([box()], spacing=1.0 / MAX_LEVELS)) == MAX_LEVELS


def test_the_sample_distance_is_the_median_length_of_edges():
    assert sample_distance([box()]) == pytest.approx(1.0)
    assert sample_distance([]) == 0.0


@settings(deadline=None)
@given(st.floats(1e-6, 1e6))
def test_the_sample_distance_grows_with_the_mesh(scale):
    mesh = box((0, 0, 0), (1, 2, 5))
    assert sample_distance([Mesh(scale * mesh.vertices, mesh.faces)]) == pytest.approx(
        scale * sample_distance([mesh])
    )
