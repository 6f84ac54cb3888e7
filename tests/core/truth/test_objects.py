import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.errors import InvalidParameter
from core.truth.objects import distances, normals, on_surface, reference_mesh, solid, solid_names

NAMES = st.sampled_from(solid_names())


def sides(mesh):
    return mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


@pytest.mark.parametrize("name", solid_names())
def test_reference_meshes_are_closed_and_oriented_outward(name):
    mesh = reference_mesh(solid(name), 64)
    directed = sides(mesh)
    assert len(np.unique(directed, axis=0)) == len(directed)
    there, back = np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0)
    np.testing.assert_array_equal(there, back)
    corners = mesh.vertices[mesh.faces]
    assert np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() > 0.0


@pytest.mark.parametrize("name", solid_names())
def test_components_and_genera_are_those_of_the_mesh(name):
    one = solid(name)
    mesh = reference_mesh(one, 64)
    edges = np.unique(np.sort(sides(mesh), axis=1), axis=0)
    size = len(mesh.vertices)
    count, label = connected_components(
        coo_array((np.ones(len(edges)), edges.T), (size, size)), directed=False
    )
    assert count == one.components
    genera = []
    for k in range(count):
        euler = (
            np.count_nonzero(label == k)
            - np.count_nonzero(label[edges[:, 0]] == k)
            + np.count_nonzero(label[mesh.faces[:, 0]] == k)
        )
        genera.append((2 - euler) // 2)
    assert sorted(genera) == sorted(one.genera)
    assert sum(genera) == one.genus


@pytest.mark.parametrize("name", solid_names())
def test_vertices_of_the_reference_lie_on_the_surface_and_in_the_box(name):
    one = solid(name)
    vertices = reference_mesh(one, 64).vertices
    assert np.abs(one.field(vertices)).max() < 1e-9 * one.extent
    assert np.all(vertices > one.box[0])
    assert np.all(vertices < one.box[1])


@pytest.mark.parametrize("name", solid_names())
def test_normals_point_outward(name):
    one = solid(name)
    vertices = reference_mesh(one, 48).vertices
    normal = normals(one, vertices)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(len(normal)))
    assert np.all(one.field(vertices + 0.05 * normal) > 0.0)
    assert np.all(one.field(vertices - 0.05 * normal) < 0.0)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 3.0))
def test_distances_to_a_ball_and_a_torus_are_exact(seed, away):
    rng = np.random.default_rng(seed)
    for name in ("ball", "torus"):
        one = solid(name)
        points = reference_mesh(one).vertices[rng.integers(0, 40_000, size=40)] + away * rng.normal(
            size=(40, 3)
        )
        assert distances(one, points) == pytest.approx(np.abs(one.field(points)), abs=1e-7)


@settings(max_examples=8, deadline=None)
@given(NAMES, st.integers(0, 2**32 - 1), st.floats(-0.5, 0.5))
def test_no_distance_exceeds_the_way_along_the_normal_nor_that_to_any_vertex(name, seed, offset):
    one = solid(name)
    vertices = reference_mesh(one).vertices
    some = vertices[np.random.default_rng(seed).integers(0, len(vertices), size=60)]
    points = some + offset * normals(one, some)
    found = distances(one, points)
    assert np.all(found <= abs(offset) + 1e-7)
    assert np.median(np.abs(found - abs(offset))) < 1e-7
    assert np.all(found <= np.linalg.norm(points[:, None] - vertices[::50], axis=2).min(axis=1) + 1e-12)


@settings(max_examples=8, deadline=None)
@given(NAMES, st.integers(0, 2**32 - 1))
def test_points_near_the_surface_are_taken_onto_it(name, seed):
    rng = np.random.default_rng(seed)
    one = solid(name)
    vertices = reference_mesh(one, 48).vertices
    points = vertices[rng.integers(0, len(vertices), size=50)] + 0.3 * rng.normal(size=(50, 3))
    assert np.abs(one.field(on_surface(one, points, 20))).max() < 1e-6


def test_a_finer_reference_is_nearer_to_the_surface():
    one = solid("bust")
    sag = []
    for resolution in (32, 64):
        mesh = reference_mesh(one, resolution)
        sag.append(np.abs(one.field(mesh.vertices[mesh.faces].mean(axis=1))).mean())
    assert sag[1] < 0.4 * sag[0]


def test_an_unknown_solid_is_refused():
    with pytest.raises(InvalidParameter, match="bust") as caught:
        solid("teapot")
    assert caught.value.loc == ("name",)
