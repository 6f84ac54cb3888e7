from importlib.util import find_spec

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from core.tape.delaunay import areas, edge_lengths, triangulate
from core.tape.polygon import tape_polygon
from tests.core.shapes import rotation

BACKENDS = [name for name in ("scipy", "pythoncdt") if find_spec(name)]
SEEDS = st.integers(0, 2**32 - 1)

each_backend = pytest.mark.parametrize("backend", BACKENDS)


def lattice(generator, extent=8, count=60):
    """Points with small integer coordinates: repeated, collinear and cocircular ones in plenty."""
    return generator.integers(0, extent, (count, 2)).astype(float)


def grid(columns, rows):
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2).astype(float)


def general(generator, count=60):
    return generator.normal(size=(count, 2))


def as_set(mesh):
    """Triangles as a set, whatever their order and their first vertex."""
    return {frozenset(map(int, triangle)) for triangle in mesh.triangles}


def hull_area(points):
    return shapely.convex_hull(shapely.multipoints(points)).area


def in_circle(points, mesh):
    """For each inner edge, Shewchuk's incircle determinant of a triangle and the vertex across."""
    t, k = np.nonzero(mesh.neighbours >= 0)
    other = mesh.neighbours[t, k]
    across = mesh.triangles[other][mesh.neighbours[other] == t[:, None]]
    corners = points[mesh.triangles[t]] - points[across][:, None]
    lifted = np.concatenate((corners, (corners**2).sum(axis=-1, keepdims=True)), axis=-1)
    a, b, c = lifted.transpose(1, 0, 2)
    return np.einsum("ij,ij->i", a, np.cross(b, c))


def assert_sound(mesh):
    """Triangles are counter-clockwise, and neighbours are those that share an edge."""
    assert (areas(mesh) > 0).all()
    assert_joined(mesh)


def assert_joined(mesh):
    """Neighbours are the triangles that share an edge, no others, and lie on its other side."""
    start, stop = np.roll(mesh.triangles, -1, axis=1), np.roll(mesh.triangles, -2, axis=1)
    triangle = np.broadcast_to(np.arange(len(start))[:, None], start.shape)
    owner = dict(zip(zip(start.flat, stop.flat, strict=True), triangle.flat, strict=True))
    assert len(owner) == start.size  # no edge is passed twice in one direction
    across = [owner.get(edge, -1) for edge in zip(stop.flat, start.flat, strict=True)]
    np.testing.assert_array_equal(mesh.neighbours.ravel(), across)


@each_backend
@given(SEEDS, st.integers(3, 120))
@settings(deadline=None)
def test_a_triangulation_of_points_in_general_position_is_delaunays(backend, seed, count):
    points = general(np.random.default_rng(seed), count)
    mesh = triangulate(points, backend)
    assert_sound(mesh)
    np.testing.assert_array_equal(np.unique(mesh.triangles), np.arange(count))
    assert areas(mesh).sum() == pytest.approx(hull_area(points))
    assert in_circle(points, mesh).max(initial=0.0) < 1e-6


@each_backend
@given(SEEDS, st.integers(2, 12), st.integers(3, 150))
@settings(deadline=None)
def test_ties_and_repeated_points_are_no_obstacle(backend, seed, extent, count):
    points = lattice(np.random.default_rng(seed), extent, count)
    mesh = triangulate(points, backend)
    assert_sound(mesh)
    assert areas(mesh).sum() == pytest.approx(hull_area(points), abs=1e-12)
    # Of small integers, the determinant is exact.
    assert in_circle(points, mesh).max(initial=0.0) <= 0.0
    _, first = np.unique(points, axis=0, return_index=True)
    assert set(mesh.triangles.flat) == (set(first) if len(mesh.triangles) else set())


@given(SEEDS, st.integers(3, 300))
@settings(deadline=None)
def test_all_backends_find_the_same_triangles(seed, count):
    points = general(np.random.default_rng(seed), count)
    expected = {frozenset(map(int, triangle)) for triangle in Delaunay(points).simplices}
    for backend in [*BACKENDS, "auto"]:
        assert as_set(triangulate(points, backend)) == expected


@each_backend
@given(SEEDS)
@settings(deadline=None)
def test_the_order_of_the_points_decides_nothing(backend, seed):
    generator = np.random.default_rng(seed)
    points = np.unique(lattice(generator), axis=0)
    order = generator.permutation(len(points))
    shuffled = {frozenset(int(order[v]) for v in t) for t in as_set(triangulate(points[order], backend))}
    assert shuffled == as_set(triangulate(points, backend))


@each_backend
@given(SEEDS, st.integers(-1000, 900))
@settings(deadline=None)
def test_a_power_of_two_in_scale_decides_nothing(backend, seed, exponent):
    points = lattice(np.random.default_rng(seed))
    scaled = triangulate(np.ldexp(points, exponent), backend)
    np.testing.assert_array_equal(scaled.triangles, triangulate(points, backend).triangles)
    np.testing.assert_array_equal(scaled.neighbours, triangulate(points, backend).neighbours)


@each_backend
@given(SEEDS, st.floats(1.0, 1e9))
@settings(deadline=None)
def test_an_offset_decides_nothing(backend, seed, offset):
    shift = np.array([offset, -offset])
    points = general(np.random.default_rng(seed)) + shift
    near = points - shift  # exact where it matters: the rounding is that of the sum above
    assert as_set(triangulate(points, backend)) == as_set(triangulate(near, backend))


@each_backend
@pytest.mark.parametrize("extent", [1e308, 1.7e308])
def test_the_largest_doubles_are_points_too(backend, extent):
    corners = extent * np.array([[-1.0, -1.0], [1.0, -1.0], [0.9, 1.0], [-1.0, 1.0]])
    assert len(triangulate(corners, backend).triangles) == 2


@each_backend
@pytest.mark.parametrize("tilt", [0.0, 0.37, -1e3])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 200])
def test_points_on_a_line_have_no_triangles(backend, count, tilt):
    x = np.random.default_rng(0).uniform(-1, 1, count)
    for points in (np.column_stack((x, tilt * x)), np.column_stack((np.full(count, 1e6), x))):
        mesh = triangulate(points, backend)
        assert mesh.triangles.shape == mesh.neighbours.shape == (0, 3)


@each_backend
def test_points_that_coincide_have_no_triangles(backend):
    assert len(triangulate(np.full((50, 2), 3.7), backend).triangles) == 0
    assert len(triangulate(np.repeat(np.eye(2), 50, axis=0), backend).triangles) == 0


@each_backend
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, 2.0])
def test_a_turned_grid_has_no_flat_triangles(backend, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    points = grid(9, 12) @ turn.T
    mesh = triangulate(points, backend)
    assert_sound(mesh)
    np.testing.assert_allclose(areas(mesh), 0.5, rtol=1e-9)
    assert len(mesh.triangles) == 2 * 8 * 11


@each_backend
def test_a_circle_without_noise_is_cut_into_triangles(backend):
    """So many exactly cocircular points take Qhull alone minutes."""
    angle = 2 * np.pi * np.arange(20_000) / 20_000
    points = np.column_stack((np.cos(angle), np.sin(angle)))
    mesh = triangulate(points, backend)
    assert len(mesh.triangles) == len(points) - 2
    assert areas(mesh).sum() == pytest.approx(hull_area(points))


@each_backend
def test_a_line_without_noise_and_a_point_beside_it_make_a_fan(backend):
    x = np.linspace(-1, 1, 20_000)
    points = np.append(np.column_stack((x, 0.37 * x)), [[0.0, 1.0]], axis=0)
    mesh = triangulate(points, backend)
    assert len(mesh.triangles) == len(x) - 1
    assert (mesh.triangles == len(x)).any(axis=1).all()


@each_backend
@given(SEEDS, st.floats(-16, -5))
@settings(deadline=None)
def test_points_that_nearly_coincide_do_no_harm(backend, seed, exponent):
    generator = np.random.default_rng(seed)
    points = general(generator, 40)
    pairs = np.concatenate((points, points + 10.0**exponent * general(generator, 40)))
    mesh = triangulate(pairs, backend)
    assert_joined(mesh)
    assert (areas(mesh) > -1e-15).all()  # not turned over beyond rounding
    assert areas(mesh).sum() == pytest.approx(hull_area(pairs), rel=1e-6)
    # At least one of each pair is a vertex.
    assert set(mesh.triangles.ravel() % 40) == set(range(40))


@each_backend
@given(SEEDS, st.floats(-13, -5))
@settings(deadline=None)
def test_a_strip_of_a_width_near_rounding_does_no_harm(backend, seed, exponent):
    generator = np.random.default_rng(seed)
    strip = np.column_stack((generator.uniform(-1, 1, 100), 10.0**exponent * generator.normal(size=100)))
    mesh = triangulate(strip @ rotation(generator, 2).T, backend)
    assert_joined(mesh)
    for share in (0.3, 0.7, 1.0):
        assert tape_polygon(mesh, generator.random(len(mesh.triangles)) < share).is_valid


@each_backend
@given(SEEDS, st.floats(-9, -3))
@settings(deadline=None)
def test_a_crowd_and_a_point_far_from_it_do_no_harm(backend, seed, exponent):
    generator = np.random.default_rng(seed)
    points = np.append(10.0**exponent * general(generator, 400), [[1.0, 1.0]], axis=0)
    mesh = triangulate(points, backend)
    assert_joined(mesh)
    for share in (0.3, 0.7, 1.0):
        assert tape_polygon(mesh, generator.random(len(mesh.triangles)) < share).is_valid


@each_backend
@given(SEEDS)
@settings(deadline=None)
def test_scales_that_differ_wildly_do_no_harm(backend, seed):
    generator = np.random.default_rng(seed)
    points = np.exp(generator.uniform(-600, 0, (60, 1))) * general(generator)
    mesh = triangulate(points, backend)
    # The areas of some are beyond rounding.
    assert_joined(mesh)


def test_areas_and_lengths_are_those_of_the_triangles():
    points = general(np.random.default_rng(0)) @ rotation(np.random.default_rng(1), 2).T
    mesh = triangulate(points)
    polygons = shapely.polygons(points[mesh.triangles])
    np.testing.assert_allclose(areas(mesh), shapely.area(polygons))
    np.testing.assert_allclose(edge_lengths(mesh).sum(axis=1), shapely.length(polygons))
    t, k = 7, 2
    a, b = points[np.delete(mesh.triangles[t], k)]
    assert edge_lengths(mesh)[t, k] == pytest.approx(np.linalg.norm(a - b))
