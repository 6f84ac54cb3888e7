"""Distances of points to meshes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.residual import distances_to, rms_residual
from core.surface.results import Mesh
from core.truth.objects import reference_mesh, solid

SQUARE = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int64)
)


@settings(deadline=None)
@given(st.lists(st.tuples(*[st.floats(-3.0, 4.0)] * 3), min_size=1, max_size=30))
def test_distances_to_a_square_are_those_of_a_box_without_height(places):
    points = np.array(places)
    beyond = np.stack((points[:, 0], points[:, 0] - 1, points[:, 1], points[:, 1] - 1), axis=1)
    x = np.maximum(np.maximum(-beyond[:, 0], beyond[:, 1]), 0.0)
    y = np.maximum(np.maximum(-beyond[:, 2], beyond[:, 3]), 0.0)
    expected = np.sqrt(x**2 + y**2 + points[:, 2] ** 2)
    assert np.allclose(distances_to(points, SQUARE), expected, rtol=1e-12, atol=1e-12)


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_no_point_of_the_mesh_is_nearer_and_one_is_as_near(seed):
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-3, 1, (40, 1, 1))  # triangles of very different sizes, slivers among them
    corners = rng.normal(size=(40, 1, 3)) + scale * rng.normal(size=(40, 3, 3))
    mesh = Mesh(corners.reshape(-1, 3), np.arange(120).reshape(40, 3))
    points = 2.0 * rng.normal(size=(20, 3))
    found = distances_to(points, mesh)
    shares = rng.dirichlet((0.4, 0.4, 0.4), 4000)  # most of them near edges and corners
    places = np.einsum("sk,fkd->fsd", shares, corners).reshape(-1, 3)
    sampled = np.linalg.norm(points[:, None] - places, axis=2).min(axis=1)
    assert np.all(found <= sampled * (1 + 1e-12))
    assert np.all(found >= sampled - 0.15 * scale.max())


def test_points_on_triangles_are_at_no_distance():
    mesh = reference_mesh(solid("torus"), 40)
    rng = np.random.default_rng(0)
    shares = rng.dirichlet((1, 1, 1), len(mesh.faces))
    points = np.einsum("fk,fkd->fd", shares, mesh.vertices[mesh.faces])
    assert distances_to(points, mesh).max() < 1e-12 * 100
    assert rms_residual(points, mesh) < 1e-12 * 100


def test_degenerate_triangles_are_segments_and_points():
    mesh = Mesh(np.array([[0.0, 0, 0], [2, 0, 0], [1, 0, 0]]), np.array([[0, 1, 2], [0, 0, 0]], np.int64))
    points = np.array([[1.0, 1.0, 0.0], [-3.0, 4.0, 0.0], [2.0, 0.0, 0.0]])
    assert distances_to(points, mesh).tolist() == [1.0, 5.0, 0.0]


def test_the_rms_of_many_points_is_that_of_a_part_of_them():
    rng = np.random.default_rng(1)
    points = np.column_stack((rng.uniform(size=(90_000, 2)), rng.normal(size=90_000)))
    assert rms_residual(points, SQUARE) == pytest.approx(1.0, rel=0.03)


def test_nothing_has_no_distance():
    assert rms_residual(np.zeros((0, 3)), SQUARE) is None
    assert rms_residual(SQUARE.vertices, Mesh(SQUARE.vertices, np.zeros((0, 3), np.int64))) is None
