import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.range_image import triangulate
from core.surface.results import Pose, RangeImage
from surface.meshes import edges_of, normals


def plane(rows, columns, pitch=1.0, slope=0.0):
    """A grid of pixels that sees a plane, tilted about y by ``slope`` = tan of the angle."""
    y, x = np.mgrid[0:rows, 0:columns] * pitch
    return np.dstack((x, y, slope * x))


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


@settings(deadline=None)
@given(st.integers(2, 40), st.integers(2, 40))
def test_a_whole_grid_gives_two_triangles_a_quad(rows, columns):
    mesh = triangulate(RangeImage(plane(rows, columns)))
    assert mesh.vertices.shape == (rows * columns, 3)
    assert mesh.faces.shape == (2 * (rows - 1) * (columns - 1), 3)
    assert normals(mesh) == pytest.approx(np.tile([0.0, 0.0, 1.0], (len(mesh.faces), 1)))


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.9))
def test_every_complete_triangle_of_pixels_is_used_once_whatever_the_holes(seed, share):
    grid = plane(20, 30)
    hole = np.random.default_rng(seed).random((20, 30)) < share
    grid[hole] = np.nan
    mesh = triangulate(RangeImage(grid))
    seen = ~hole
    corners = seen[:-1, :-1].astype(int) + seen[:-1, 1:] + seen[1:, :-1] + seen[1:, 1:]
    assert len(mesh.faces) == np.sum(np.maximum(corners - 2, 0))
    assert np.isfinite(mesh.vertices).all()
    assert set(np.unique(mesh.faces)) == set(range(len(mesh.vertices)))
    assert edges_of(mesh)[1].max(initial=0) <= 2


@pytest.mark.parametrize("missing", range(4))
def test_three_pixels_make_a_triangle_that_faces_the_scanner(missing):
    grid = plane(2, 2)
    grid[missing // 2, missing % 2] = np.nan
    mesh = triangulate(RangeImage(grid))
    assert len(mesh.faces) == 1
    assert normals(mesh)[0] == pytest.approx([0.0, 0.0, 1.0])


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-4, 1e4))
def test_the_pose_moves_the_mesh_and_nothing_else(seed, scale):
    rng = np.random.default_rng(seed)
    grid = plane(12, 15) + 0.05 * rng.normal(size=(12, 15, 3))
    turn, shift = rotation(seed), rng.normal(size=3)
    here = triangulate(RangeImage(grid))
    there = triangulate(RangeImage(scale * grid, Pose(turn, shift)))
    np.testing.assert_array_equal(here.faces, there.faces)
    assert there.vertices == pytest.approx(scale * here.vertices @ turn.T + shift, abs=1e-9 * max(scale, 1))


@pytest.mark.parametrize("scale", [1e-200, 1e-100, 1e100, 1e200])
def test_the_size_of_coordinates_does_not_matter(scale):
    grid = plane(9, 9, slope=0.5)
    mesh = triangulate(RangeImage(scale * grid))
    np.testing.assert_array_equal(mesh.faces, triangulate(RangeImage(grid)).faces)


def test_a_depth_discontinuity_is_not_bridged():
    grid = plane(30, 40)
    grid[:, 25:, 2] -= 15.0
    mesh = triangulate(RangeImage(grid))
    heights = mesh.vertices[mesh.faces][:, :, 2]
    assert np.all(np.ptp(heights, axis=1) == 0.0)
    assert len(mesh.faces) == 2 * 29 * (24 + 14)


def test_a_jump_is_seen_where_the_pitch_grows_with_the_distance():
    # a near and a far surface of a scanner whose rays spread: the far pixels are ten times as far apart
    near, far = plane(40, 40, 1.0), plane(40, 40, 10.0) + np.array([45.0, 0.0, -300.0])
    mesh = triangulate(RangeImage(np.concatenate((near, far), axis=1)))
    assert np.all(np.ptp(mesh.vertices[mesh.faces][:, :, 2], axis=1) == 0.0)
    near_faces, far_faces = (np.count_nonzero(mesh.vertices[mesh.faces[:, 0], 2] == z) for z in (0.0, -300.0))
    assert near_faces == 2 * 39 * 39
    assert far_faces > 0.7 * 2 * 39 * 39


@pytest.mark.parametrize(("degrees", "kept"), [(60.0, True), (70.0, True), (80.0, False), (85.0, False)])
def test_what_is_seen_at_a_grazing_angle_is_left_out(degrees, kept):
    grid = plane(32, 64)
    grid[:, 32:, 2] = -(grid[:, 32:, 0] - 31.0) * np.tan(np.radians(degrees))
    mesh = triangulate(RangeImage(grid))
    steep = normals(mesh)[:, 2] < 0.9
    assert steep.any() == kept
    assert np.count_nonzero(~steep) == 2 * 31 * 31


def test_quads_are_cut_along_the_shorter_diagonal():
    grid = plane(2, 2)
    grid[0, 0, 2] = grid[1, 1, 2] = 1.0  # a saddle: the other diagonal is the shorter one
    edges, count = edges_of(triangulate(RangeImage(grid)))
    assert edges[count == 2].tolist() == [[1, 2]]


@pytest.mark.parametrize("shape", [(0, 0, 3), (1, 5, 3), (5, 1, 3), (6, 6, 3)])
def test_an_image_that_sees_nothing_gives_an_empty_mesh(shape):
    mesh = triangulate(RangeImage(np.full(shape, np.nan)))
    assert mesh.vertices.shape == (0, 3)
    assert mesh.faces.shape == (0, 3)


def test_pixels_at_infinity_are_holes():
    grid = plane(5, 5)
    grid[2, 2, 2] = np.inf
    assert len(triangulate(RangeImage(grid)).vertices) == 24
