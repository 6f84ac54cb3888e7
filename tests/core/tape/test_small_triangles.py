from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.tape.delaunay import areas, edge_lengths, triangulate
from core.tape.polygon import tape_polygon
from core.tape.small_triangles import GAP, SLENDER, Local, Smallness, small_triangles
from tests.core.shapes import arc, line
from tests.core.tape.samples import measured, thinning

LENGTH = 4.0
CASES = {
    "line": (line(800, 0.02, LENGTH), shapely.LineString([(-LENGTH / 2, 0), (LENGTH / 2, 0)])),
    "circle": (arc(1200, 0.03), shapely.Point(0.0, 0.0).buffer(1.0, quad_segs=100).exterior),
}
SIGMA = {"line": 0.02, "circle": 0.03}


def chosen(points, **smallness):
    _, scale, _ = measured(points)
    mesh = triangulate(points)
    return mesh, small_triangles(mesh, scale.balls, thinning(points), Smallness(**smallness))


def longest(mesh):
    return edge_lengths(mesh).max(axis=1)


def without(points, half):
    """A line of samples without those about the origin."""
    return points[np.abs(points[:, 0]) > half]


def pieces(mesh, small):
    """What triangles and bridges connect, per sample."""
    t = mesh.triangles[small.accepted]
    edges = np.concatenate([t[:, :2], t[:, 1:], small.bridges])
    size = len(mesh.points)
    links = coo_array((np.ones(len(edges)), edges.T), shape=(size, size))
    return connected_components(links, directed=False)[1]


def holes(mesh, small):
    parts = shapely.get_parts(tape_polygon(mesh, small.accepted))
    return [shapely.Polygon(hole) for part in parts for hole in part.interiors]


@pytest.mark.parametrize("name", CASES)
def test_the_core_of_a_tape_is_kept(name):
    points, truth = CASES[name]
    mesh, small = chosen(points)
    places = shapely.line_interpolate_point(truth, np.linspace(0.02, 0.98, 300), normalized=True)
    covered = shapely.covers(tape_polygon(mesh, small.accepted), places)
    assert covered.mean() > 0.95


@pytest.mark.parametrize("name", CASES)
def test_long_triangles_are_dropped(name):
    points, truth = CASES[name]
    mesh, small = chosen(points)
    far = longest(mesh) > 0.5
    assert far.any()
    assert not small.accepted[far].any()
    # Nothing that is accepted leaves the noise about the curve.
    middles = shapely.points(mesh.points[mesh.triangles[small.accepted]].mean(axis=1))
    assert shapely.distance(truth, middles).max() < 4.0 * SIGMA[name]


def test_scale_is_local():
    points = np.concatenate([arc(1200, 0.03), arc(1200, 0.03, radius=3.0)])
    _, scale, _ = measured(points)
    inner, outer = Local.near(scale.balls, thinning(points), np.array([(1.0, 0.0), (0.0, 3.0)])).density
    assert inner == pytest.approx(1200 / (2.0 * np.pi), rel=0.25)
    assert outer == pytest.approx(1200 / (6.0 * np.pi), rel=0.25)


@pytest.mark.parametrize("seed", range(4))
def test_a_gap_of_chance_is_bridged_and_a_true_one_is_not(seed):
    points = line(600, 0.02, LENGTH, seed)
    mean, log_n = LENGTH / 600, np.log(600)
    for half, joined in ((0.5 * log_n * mean, True), (2.0 * (log_n + GAP) * mean, False)):
        rest = without(points, half)
        label = pieces(*chosen(rest))
        core = np.abs(rest[:, 1]) < 0.01
        left, right = (np.bincount(label[core & side]).argmax() for side in (rest[:, 0] < 0, rest[:, 0] > 0))
        assert (left == right) == joined


def test_bridges_run_along_the_curve_and_have_no_triangle():
    points = without(line(600, 0.02, LENGTH), 0.03)
    mesh, small = chosen(points)
    across = small.bridges[np.prod(np.sign(points[small.bridges, 0]), axis=1) < 0]
    way = np.abs(points[across[:, 0]] - points[across[:, 1]])
    assert np.all(way[:, 0] > way[:, 1])
    t = np.sort(mesh.triangles[small.accepted], axis=1)
    used = {tuple(pair) for k in ([0, 1], [1, 2], [0, 2]) for pair in t[:, k].tolist()}
    assert used.isdisjoint(map(tuple, small.bridges.tolist()))


@settings(max_examples=15, deadline=None)
@given(st.floats(0.3, 4.0), st.floats(1.0, 3.0), st.integers(0, 3))
def test_larger_factors_call_more_triangles_small(least, factor, seed):
    points = arc(300, 0.04, seed=seed)
    for name in ("f_l", "f_a"):
        _, few = chosen(points, **{name: least})
        _, more = chosen(points, **{name: factor * least})
        assert np.all(more.short_edges >= few.short_edges)
        assert np.all(more.small_area >= few.small_area)
        assert np.all(more.accepted >= few.accepted)


@pytest.mark.parametrize("f_l", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("f_a", [0.5, 1.0, 2.0])
def test_factors_count_in_typical_triangles(f_l, f_a):
    # In balls this large every triangle is typical.
    mesh, small = chosen(arc(300, 0.04), f_d=100.0, f_l=f_l, f_a=f_a)
    most_edge, most_area = f_l * edge_lengths(mesh).mean(), f_a * areas(mesh).mean()
    np.testing.assert_array_equal(small.short_edges, longest(mesh) <= most_edge)
    np.testing.assert_array_equal(
        small.small_area, (areas(mesh) <= most_area) & (longest(mesh) <= SLENDER * most_edge)
    )


@pytest.mark.parametrize("name", CASES)
def test_each_criterion_is_told_and_few_triangles_go_by_none(name):
    mesh, small = chosen(CASES[name][0])
    criteria = np.array([small.enclosed, small.small_area, small.short_edges])
    assert criteria.shape == (3, len(mesh.triangles))
    assert np.all(criteria.any(axis=1))
    # Filled holes are accepted by none, islands dropped in spite of one.
    assert np.mean(criteria.any(axis=0) != small.accepted) < 0.05


@settings(max_examples=10, deadline=None)
@given(st.integers(-60, 60), st.integers(0, 3))
def test_the_unit_of_length_changes_nothing(exponent, seed):
    points, factor = arc(300, 0.04, seed=seed), 2.0**exponent
    balls = measured(points)[1].balls
    larger = replace(
        balls,
        seed=factor * balls.seed,
        centre=factor * balls.centre,
        radius=factor * balls.radius,
        variance=factor**2 * balls.variance,
    )
    one = small_triangles(triangulate(points), balls, 1.0, Smallness())
    other = small_triangles(triangulate(factor * points), larger, 1.0, Smallness())
    for name in ("enclosed", "small_area", "short_edges", "accepted", "bridges"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert other.spacing == pytest.approx(factor * one.spacing)


@pytest.mark.parametrize("seed", range(3))
def test_holes_of_chance_are_filled_and_true_holes_are_kept(seed):
    sigma, place = 0.05, np.array((-1.0, 0.0))
    points = arc(5000, sigma, seed=seed)
    spacing = chosen(points)[1].spacing

    def emptied(radius):
        return chosen(points[np.hypot(*(points - place).T) > radius])

    mesh, small = emptied(1.9 * spacing)
    rejected = ~(small.enclosed | small.small_area | small.short_edges)
    near = np.hypot(*(mesh.points[mesh.triangles].mean(axis=1) - place).T) < 2.0 * spacing
    assert np.any(near & rejected & small.accepted)
    (ring,) = holes(mesh, small)
    assert ring.contains(shapely.Point(0, 0))
    inner, outer = sorted(holes(*emptied(0.8 * sigma)), key=lambda hole: hole.area)
    assert inner.contains(shapely.Point(place))
    assert outer.contains(shapely.Point(0, 0))
