import numpy as np
import pytest

from core.surface.grazing import is_grazing
from core.surface.parameters import SliceParameters
from core.surface.range_image import triangulate
from core.surface.results import RangeImage, Slice
from core.surface.slicing import slices_of

COUNT = 60


def face(tilt: float, noise: float = 0.05) -> RangeImage:
    """A square of edge 10 around the origin, seen with noise, that rises along x."""
    y, x = np.mgrid[-5.0 : 5.0 : COUNT * 1j, -5.0 : 5.0 : COUNT * 1j]
    z = tilt * x + noise * np.random.default_rng(0).normal(size=x.shape)
    return RangeImage(np.dstack((x, y, z)))


def cut(tilt: float) -> Slice:
    meshes = [triangulate(face(tilt))]
    return slices_of(meshes, SliceParameters(heights=(0.0,)))[0]


def test_a_plane_through_the_noise_of_a_face_grazes_it():
    assert is_grazing(cut(0.0))


@pytest.mark.parametrize("tilt", [0.3, 1.0])
def test_a_plane_across_a_face_does_not(tilt):
    assert not is_grazing(cut(tilt))


def test_size_and_place_do_not_matter():
    one = cut(0.0)
    for scale, shift in ((1e-6, 0.0), (1e6, 1e8)):
        lines = tuple(scale * line + shift for line in one.polylines)
        assert is_grazing(Slice(0.0, scale * one.points + shift, lines, one.closed))


def test_without_polylines_nothing_is_known():
    assert not is_grazing(Slice(0.0, np.zeros((0, 3))))
    assert not is_grazing(Slice(0.0, np.random.default_rng(0).normal(size=(50, 3))))
