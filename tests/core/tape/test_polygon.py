import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.tape.delaunay import Triangulation, areas, edge_lengths, triangulate
from core.tape.polygon import border_rings, edge_components, fill_holes, tape_polygon

SEEDS = st.integers(0, 2**32 - 1)


def clouds(generator):
    """Points of some kind: in general position, on a lattice straight or turned, repeated, in clusters."""
    count = generator.integers(3, 120)
    random = generator.normal(size=(count, 2))
    lattice = generator.integers(0, 8, (count, 2)).astype(float)
    angle = generator.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    clusters = np.exp(generator.uniform(-25, 0, (count, 1))) * random
    kinds = (random, lattice, 0.1 * lattice @ turn + random[0], np.repeat(random, 2, axis=0), clusters)
    return kinds[generator.integers(len(kinds))]


@st.composite
def tapes(draw):
    """A triangulation and some of its triangles, chosen one by one or by their size."""
    generator = np.random.default_rng(draw(SEEDS))
    mesh = triangulate(clouds(generator))
    share = draw(st.floats(0.0, 1.0))
    if draw(st.booleans()) or len(mesh.triangles) == 0:
        return mesh, generator.random(len(mesh.triangles)) < share
    longest = edge_lengths(mesh).max(axis=1)
    return mesh, longest <= np.quantile(longest, share)


def blocks(picture):
    """A triangulation of unit squares, and the triangles of those marked by a # in the picture.

    Its lines go from top to bottom. A frame of empty squares is put around them.
    """
    lines = [line.strip() for line in picture.split()][::-1]
    width, height = max(map(len, lines)) + 2, len(lines) + 2
    x, y = np.meshgrid(np.arange(width + 1), np.arange(height + 1))
    mesh = triangulate(np.column_stack((x.ravel(), y.ravel())).astype(float))
    column, row = np.floor(mesh.points[mesh.triangles].mean(axis=1)).astype(int).T
    marks = np.zeros((height, width), bool)
    for k, line in enumerate(lines):
        marks[k + 1, 1 : len(line) + 1] = [mark == "#" for mark in line]
    return mesh, marks[row, column]


def components(mesh, member):
    """Number of components of member triangles, by scipy."""
    t, k = np.nonzero((mesh.neighbours >= 0) & member[:, None])
    n = mesh.neighbours[t, k]
    both = member[n]
    graph = coo_array((np.ones(both.sum()), (t[both], n[both])), (len(member), len(member)))
    labels = connected_components(graph, directed=False)[1]
    return labels, len(np.unique(labels[member]))


def signed_area(points):
    x, y = (points - points[0]).T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


def holes(polygon):
    return [shapely.Polygon(ring) for part in polygon.geoms for ring in part.interiors]


@given(tapes())
@settings(max_examples=300, deadline=None)
def test_the_polygon_is_the_union_of_the_triangles(tape):
    mesh, accepted = tape
    polygon = tape_polygon(mesh, accepted)
    union = shapely.union_all(shapely.polygons(mesh.points[mesh.triangles[accepted]]))
    scale = np.ptp(mesh.points, axis=0).max() ** 2
    assert isinstance(polygon, shapely.MultiPolygon)
    assert polygon.is_valid
    assert polygon.area == pytest.approx(areas(mesh)[accepted].sum(), abs=1e-13 * scale)
    assert polygon.symmetric_difference(union).area <= 1e-13 * scale
    assert len(polygon.geoms) == components(mesh, accepted)[1]


@given(tapes())
@settings(max_examples=200, deadline=None)
def test_outer_rings_run_counter_clockwise_and_holes_clockwise(tape):
    mesh, accepted = tape
    polygon = tape_polygon(mesh, accepted)
    scale = np.ptp(mesh.points, axis=0).max() ** 2
    for part in polygon.geoms:
        assert signed_area(shapely.get_coordinates(part.exterior)[:-1]) > -1e-14 * scale
        for ring in part.interiors:
            assert signed_area(shapely.get_coordinates(ring)[:-1]) < 1e-14 * scale


@given(tapes())
@settings(max_examples=200, deadline=None)
def test_rings_are_simple_and_pass_every_border_edge_once(tape):
    mesh, accepted = tape
    rings = border_rings(mesh, accepted)
    edges = [edge for ring in rings for edge in zip(ring, np.roll(ring, -1), strict=True)]
    border = accepted[:, None] & ((mesh.neighbours < 0) | ~accepted[mesh.neighbours])
    t, k = np.nonzero(border)
    corners = mesh.triangles[t]
    row = np.arange(len(t))
    expected = set(zip(corners[row, (k + 1) % 3], corners[row, (k + 2) % 3], strict=True))
    assert all(len(set(ring)) == len(ring) >= 3 for ring in rings)
    assert len(edges) == len(expected)
    assert set(edges) == expected
    total = sum(signed_area(mesh.points[ring]) for ring in rings)
    assert total == pytest.approx(areas(mesh)[accepted].sum(), abs=1e-13 * np.ptp(mesh.points) ** 2)


@given(tapes(), st.integers(-300, 300))
@settings(deadline=None)
def test_rings_do_not_depend_on_coordinates(tape, exponent):
    mesh, accepted = tape
    moved = Triangulation(np.ldexp(mesh.points, exponent), mesh.triangles, mesh.neighbours)
    for ring, other in zip(border_rings(mesh, accepted), border_rings(moved, accepted), strict=True):
        np.testing.assert_array_equal(ring, other)


@given(tapes())
@settings(deadline=None)
def test_components_are_those_of_the_graph_of_neighbours(tape):
    mesh, accepted = tape
    labels, count = edge_components(mesh, accepted)
    expected, expected_count = components(mesh, accepted)
    assert count == expected_count
    assert (labels[~accepted] == -1).all()
    inside = labels[accepted]
    # Each label goes with one of scipy's, and they are numbered as they first appear.
    assert len(set(zip(inside, expected[accepted], strict=True))) == count
    _, first = np.unique(inside, return_index=True)
    np.testing.assert_array_equal(inside[np.sort(first)], np.arange(count))


PICTURES = {
    "square": ("#", [0]),
    "two squares that touch in a corner": ("#. .#", [0, 0]),
    "ring": ("### #.# ###", [1]),
    "ring whose hole touches the outer ring in a corner": (".### ##.# #### ####", [1]),
    "ring that meets itself in a corner": ("### #.# ##.", [1]),
    "two holes that touch in a corner": ("#### #.## ##.# ####", [2]),
    "three holes in a row, corner to corner": ("##### #.### ##.## ###.# #####", [3]),
    "island in a hole": ("##### #...# #.#.# #...# #####", [0, 1]),
    "island that touches the hole's border in a corner": ("##### #...# #..## #.#.# #...# #####", [0, 1]),
    "island that touches in two corners": ("##### #..## #.#.# ##..# #####", [0, 1]),
    "islands in holes of islands": (
        "######### #.......# #.#####.# #.#...#.# #.#.#.#.# #.#...#.# #.#####.# #.......# #########",
        [0, 1, 1],
    ),
    "chessboard": ("#.#.# .#.#. #.#.# .#.#. #.#.#", [0] * 13),
    "diamond of corners only": (".#. #.# .#.", [0, 0, 0, 0]),
}


@pytest.mark.parametrize("name", PICTURES)
def test_corners_that_touch_leave_polygons_valid(name):
    picture, expected = PICTURES[name]
    polygon = tape_polygon(*blocks(picture))
    assert polygon.is_valid
    assert polygon.area == picture.count("#")
    assert sorted(len(part.interiors) for part in polygon.geoms) == expected


def test_nothing_accepted_is_empty():
    mesh = triangulate(np.random.default_rng(0).normal(size=(20, 2)))
    none = np.zeros(len(mesh.triangles), bool)
    assert tape_polygon(mesh, none).is_empty
    assert border_rings(mesh, none) == []
    assert tape_polygon(triangulate(np.zeros((5, 2))), np.zeros(0, bool)).is_empty


def test_everything_accepted_is_the_hull():
    points = np.random.default_rng(0).normal(size=(200, 2))
    mesh = triangulate(points)
    polygon = tape_polygon(mesh, np.ones(len(mesh.triangles), bool))
    assert polygon.equals(shapely.convex_hull(shapely.multipoints(points)))


@given(tapes(), st.floats(1e-4, 1.0))
@settings(max_examples=200, deadline=None)
def test_holes_are_filled_up_to_the_area_given(tape, share):
    mesh, accepted = tape
    area = areas(mesh)
    most_area = share * area.sum()
    filled = fill_holes(mesh, accepted, most_area)
    labels, count = edge_components(mesh, ~accepted)
    for k in range(count):
        group = labels == k
        outside = (mesh.neighbours[group] < 0).any()
        assert filled[group].all() == filled[group].any() == (not outside and area[group].sum() < most_area)
    assert filled[accepted].all()
    np.testing.assert_array_equal(fill_holes(mesh, filled, most_area), filled)


@given(tapes())
@settings(deadline=None)
def test_without_a_limit_no_hole_is_left_and_with_none_all_are(tape):
    mesh, accepted = tape
    assert holes(tape_polygon(mesh, fill_holes(mesh, accepted, np.inf))) == []
    np.testing.assert_array_equal(fill_holes(mesh, accepted, 0.0), accepted)


def test_a_limit_may_differ_from_place_to_place():
    mesh, accepted = blocks("####### #.###.# #######")
    left = mesh.points[mesh.triangles].mean(axis=1)[:, 0] < 4.5
    polygon = tape_polygon(mesh, fill_holes(mesh, accepted, np.where(left, 1.5, 0.5)))
    assert [hole.centroid.x for hole in holes(polygon)] == [6.5]


def test_a_hole_is_measured_by_its_mean_limit():
    mesh, accepted = blocks("###### #....# ######")  # a hole of area 4
    x = mesh.points[mesh.triangles].mean(axis=1)[:, 0]
    for right, filled in ((6.9, False), (7.1, True)):
        limits = np.where(x < 4, 1.0, right)
        assert (fill_holes(mesh, accepted, limits) != accepted).any() == filled


def test_a_bay_is_no_hole_but_one_behind_a_corner_is():
    mesh, accepted = blocks("### #.. ###")
    np.testing.assert_array_equal(fill_holes(mesh, accepted, np.inf), accepted)
    mesh, accepted = blocks("### #.# ##.")
    assert tape_polygon(mesh, fill_holes(mesh, accepted, 1.1)).area == 8
