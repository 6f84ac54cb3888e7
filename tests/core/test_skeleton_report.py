import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree

from core.methods import pca, skeleton
from core.parameters import SkeletonParameters
from core.truth import point_set
from tests.core.shapes import arc, diagonal, in_a_tilted_plane

SETS = {
    # name: samples, holes of each part of the tape, degrees of the nodes
    "circle": (800, [1], [2]),
    "s_shape": (800, [0], [1, 1]),
    "figure_8": (1000, [2], [4]),
    "t_junction": (1000, [0], [1, 1, 1, 3]),
    "nested": (1200, [1, 1, 1], [2, 2, 2]),
    "tilted": (800, [1], [2]),
}


def with_repetitions(points):
    """The points, a tenth of them a second time."""
    return np.concatenate((points, points[::10]))


@pytest.fixture(scope="module", params=SETS)
def answered(request):
    size, holes, degrees = SETS[request.param]
    sample = point_set(request.param, n=size, sigma=0.01, seed=3)
    # Somewhere else, and in other units than those that the work is done in.
    points = with_repetitions(20.0 * sample.points + 300.0)
    return points, skeleton(points, stages=True), holes, degrees


def planar(answer, places):
    """Places in the plane of the only component, (M, 2); those in the plane already as they are."""
    places = np.asarray(places, np.float64)
    if places.shape[-1] == 2:
        return places
    frame = answer.frames[0]
    return (places - frame.origin) @ frame.axes[:2].T


def polygons(answer):
    return [
        shapely.Polygon(planar(answer, part.outer), [planar(answer, hole) for hole in part.holes])
        for part in answer.tape
    ]


# ---------------------------------------------------------------- tape


def test_each_part_of_the_tape_is_a_valid_polygon_with_its_holes(answered):
    _, answer, holes, _ = answered
    assert sorted(len(part.holes) for part in answer.tape) == holes
    for part, polygon in zip(answer.tape, polygons(answer), strict=True):
        assert polygon.is_valid
        assert np.any(part.outer[0] != part.outer[-1])
        assert shapely.LinearRing(planar(answer, part.outer)).is_ccw
        for hole in part.holes:
            assert np.any(hole[0] != hole[-1])
            assert not shapely.LinearRing(planar(answer, hole)).is_ccw
    assert not any(a.intersects(b) for k, a in enumerate(polygons(answer)) for b in polygons(answer)[:k])


def test_nearly_all_samples_lie_in_the_tape(answered):
    points, answer, _, _ = answered
    flat = planar(answer, points)
    inside = np.any([shapely.contains_xy(polygon, flat) for polygon in polygons(answer)], axis=0)
    assert answer.containment.samples_inside == pytest.approx(inside.mean(), abs=1.5 / len(points))
    assert answer.containment.samples_inside >= 0.93


def test_the_tape_covers_the_skeleton_and_the_curves(answered):
    points, answer, _, _ = answered
    tape = shapely.union_all(polygons(answer)).buffer(1e-9 * diagonal(points))
    assert answer.containment.covered
    assert answer.containment.passes >= 1
    for edge in answer.graph.edges:
        assert tape.covers(shapely.LineString(planar(answer, edge.vertices)))
    for curve in answer.curves:
        assert np.mean(shapely.contains_xy(tape, planar(answer, curve.vertices))) > 0.98


def test_the_tape_is_some_sigma_wide(answered):
    _, answer, _, _ = answered
    area = sum(polygon.area for polygon in polygons(answer))
    width = area / sum(curve.length for curve in answer.curves)
    assert 3.0 * answer.sampling.sigma < width < 10.0 * answer.sampling.sigma


# ---------------------------------------------------------------- graph


def test_edges_end_at_their_nodes(answered):
    _, answer, _, _ = answered
    graph = answer.graph
    for edge in graph.edges:
        for node, vertex in zip(edge.nodes, edge.vertices[[0, -1]], strict=True):
            np.testing.assert_allclose(graph.nodes[node].location, vertex, atol=1e-12 * 300.0)


def test_degrees_are_numbers_of_edge_ends(answered):
    _, answer, _, degrees = answered
    ends = [node for edge in answer.graph.edges for node in edge.nodes]
    assert [n.degree for n in answer.graph.nodes] == np.bincount(ends).tolist()
    assert sorted(n.degree for n in answer.graph.nodes) == degrees


def test_nodes_belong_to_components_of_the_tape(answered):
    _, answer, _, _ = answered
    labels = {frame.component for frame in answer.frames}
    assert {n.component for n in answer.graph.nodes} == {part.component for part in answer.tape} == labels
    for edge in answer.graph.edges:
        assert len({answer.graph.nodes[node].component for node in edge.nodes}) == 1


def test_an_edge_has_the_length_of_its_course_and_the_width_of_the_tape(answered):
    _, answer, _, _ = answered
    border = shapely.union_all([polygon.boundary for polygon in polygons(answer)])
    samples = cKDTree(planar(answer, np.concatenate(answer.stages.border)))
    for edge in answer.graph.edges:
        steps = np.linalg.norm(np.diff(edge.vertices, axis=0), axis=1)
        assert edge.length == pytest.approx(steps.sum())
        assert edge.widths.shape == (len(edge.vertices),)
        assert np.all(edge.widths > 0.0)
        # A junction's node is not on the axis, but between the axes that meet there.
        places, widths = planar(answer, edge.vertices)[1:-1], edge.widths[1:-1]
        np.testing.assert_allclose(widths, 2.0 * samples.query(places)[0], rtol=5e-3)
        away = shapely.distance(border, shapely.points(places))
        assert np.all(widths > 1.999 * away)
        assert np.median(widths / away) < 2.3
    for node in answer.graph.nodes:
        assert node.radius > 0.0


def test_the_node_of_a_crossing_is_where_curves_cross():
    sample = point_set("figure_8", n=1000, sigma=0.008, seed=4)
    answer = skeleton(sample.points)
    (node,) = answer.graph.nodes
    assert node.degree == 4
    assert len(answer.graph.edges) == 2
    assert np.linalg.norm(node.location - sample.crossings[0]) < 4.0 * sample.sigma
    assert node.radius > 2.0 * sample.sigma


# ---------------------------------------------------------------- stages


def corners(answer, points):
    """Corners of the Delaunay triangles, (T, 3, 2)."""
    return planar(answer, points[answer.stages.delaunay.triangles])


def edges_of(triangles):
    """The three edges of each triangle, (T, 3, 2), lower index first."""
    return np.sort(triangles[:, [(0, 1), (1, 2), (2, 0)]], axis=2)


def test_triangles_index_the_input_points(answered):
    points, answer, _, _ = answered
    triangles = answer.stages.delaunay.triangles
    assert triangles.shape[1] == 3
    assert 0 <= triangles.min() <= triangles.max() < len(points)
    a, b, c = np.moveaxis(corners(answer, points), 1, 0)
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert np.all(doubled != 0.0)
    # An edge has a triangle on each side at most, and together they fill the hulls of the components.
    _, count = np.unique(edges_of(triangles).reshape(-1, 2), axis=0, return_counts=True)
    assert count.max() <= 2
    hull = sum(
        shapely.MultiPoint(planar(answer, points[np.unique(triangles[own])])).convex_hull.area
        for own in triangles_by_component(triangles, len(points))
    )
    assert 0.5 * np.abs(doubled).sum() == pytest.approx(hull, rel=1e-3)


def triangles_by_component(triangles, size):
    """Which triangles hang together through points."""
    label = np.arange(size)
    while True:
        least = label[triangles].min(axis=1)
        lower = label.copy()
        np.minimum.at(lower, triangles.ravel(), np.repeat(least, 3))
        if np.array_equal(lower, label):
            break
        label = lower
    own = label[triangles[:, 0]]
    return [own == k for k in np.unique(own)]


def test_every_flag_has_a_value_for_each_triangle(answered):
    _, answer, _, _ = answered
    mesh = answer.stages.delaunay
    for flags in (mesh.enclosed, mesh.small_area, mesh.short_edges, mesh.accepted):
        assert flags.shape == (len(mesh.triangles),)
        assert flags.dtype == np.bool_
        assert flags.any()
        assert not flags.all()


def test_accepted_are_those_of_a_criterion_but_for_islands_and_false_holes(answered):
    _, answer, _, _ = answered
    mesh = answer.stages.delaunay
    small = mesh.enclosed | mesh.small_area | mesh.short_edges
    pairs, number = np.unique(edges_of(mesh.triangles).reshape(-1, 2), axis=0, return_inverse=True)
    sides = np.bincount(number.ravel()[np.repeat(mesh.accepted, 3)], minlength=len(pairs))
    beside = sides[number.reshape(-1, 3)]
    # An island shares no edge with the tape; a false hole is in the middle of it.
    assert np.all(beside[small & ~mesh.accepted] == 0)
    assert np.all(beside[mesh.accepted & ~small] == 2)
    assert np.mean(small[mesh.accepted]) > 0.8


def test_the_tape_holds_the_accepted_triangles_and_the_bridges(answered):
    points, answer, _, _ = answered
    mesh = answer.stages.delaunay
    tape = shapely.union_all(polygons(answer)).buffer(1e-9 * diagonal(points))
    triangles = shapely.polygons(corners(answer, points)[mesh.accepted])
    area = shapely.area(triangles)
    assert area[shapely.covers(tape, triangles)].sum() > 0.98 * area.sum()
    assert mesh.bridges.shape[1] == 2
    known = {tuple(edge) for edge in edges_of(mesh.triangles).reshape(-1, 2).tolist()}
    assert {tuple(sorted(edge)) for edge in mesh.bridges.tolist()} <= known


def test_voronoi_edges_lie_in_the_tape(answered):
    points, answer, _, _ = answered
    voronoi = answer.stages.voronoi
    assert voronoi.shape[1:] == (2, points.shape[1])
    tape = shapely.union_all(polygons(answer)).buffer(1e-9 * diagonal(points))
    assert shapely.covers(tape, shapely.linestrings(planar(answer, voronoi))).all()
    # Without hair there is less.
    length = np.linalg.norm(voronoi[:, 1] - voronoi[:, 0], axis=1).sum()
    assert sum(edge.length for edge in answer.graph.edges) < 1.1 * length


def test_border_samples_lie_on_the_border(answered):
    points, answer, _, _ = answered
    rings = answer.stages.border
    assert len(rings) == sum(1 + len(part.holes) for part in answer.tape)
    border = shapely.union_all([polygon.boundary for polygon in polygons(answer)])
    for ring in rings:
        away = shapely.distance(border, shapely.points(planar(answer, ring)))
        assert away.max() < 1e-6 * diagonal(points)


def test_balls_have_unit_directions_and_lie_among_the_samples(answered):
    points, answer, _, _ = answered
    balls = answer.stages.balls
    assert balls
    low, high = points.min(axis=0), points.max(axis=0)
    for ball in balls:
        assert np.linalg.norm(ball.direction) == pytest.approx(1.0, abs=1e-6)
        assert 0.0 < ball.radius < diagonal(points)
        assert np.all((low - 1e-9 * high <= ball.centre) & (ball.centre <= high + 1e-9 * high))


def test_stages_are_given_when_asked_for_only():
    points = arc(400, 0.02)
    assert skeleton(points).stages is None
    assert skeleton(points, stages=True).stages is not None


# ---------------------------------------------------------------- space, several components, other methods


def test_the_plane_of_a_tilted_cloud_holds_tape_and_graph():
    flat = point_set("figure_8", n=800, sigma=0.01, seed=5).points
    points, turn = in_a_tilted_plane(flat, 7, 0.01)
    answer = skeleton(points, stages=True)
    (part,), (node,), (frame,) = answer.tape, answer.graph.nodes, answer.frames
    assert abs(frame.axes[2] @ turn[:, 2]) > np.cos(np.radians(2.0))
    rings = [part.outer, *part.holes, *answer.stages.border, answer.stages.voronoi.reshape(-1, 3)]
    courses = [edge.vertices for edge in answer.graph.edges]
    for places in (*rings, *courses, node.location[None], *[c.vertices for c in answer.curves]):
        assert places.shape[1] == 3
        assert np.abs((places - frame.origin) @ frame.axes[2]).max() < 1e-9


def test_components_have_tapes_of_their_own():
    rings = [arc(500, 0.02, seed=k) + np.array([6.0 * k, 0.0]) for k in range(2)]
    answer = skeleton(np.concatenate(rings), stages=True)
    assert sorted(part.component for part in answer.tape) == [0, 1]
    assert sorted(node.component for node in answer.graph.nodes) == [0, 1]
    for edge in answer.graph.edges:
        assert edge.nodes[0] == edge.nodes[1]
        centre = 6.0 * answer.graph.nodes[edge.nodes[0]].component
        centre = min(0.0, 6.0, key=lambda x: abs(x - edge.vertices[:, 0].mean()))
        assert np.linalg.norm(edge.vertices - [centre, 0.0], axis=1) == pytest.approx(1.0, abs=0.1)
    triangles = answer.stages.delaunay.triangles
    assert set(np.unique((triangles >= 500).sum(axis=1))) == {0, 3}


def test_a_straight_line_has_empty_stages():
    points = np.outer(np.random.default_rng(0).uniform(0.0, 5.0, 300), [0.6, 0.8])
    answer = skeleton(points, stages=True)
    assert answer.tape == ()
    assert answer.graph is None
    assert answer.containment is None
    assert answer.stages.delaunay.triangles.shape == (0, 3)
    assert answer.stages.delaunay.bridges.shape == (0, 2)
    assert answer.stages.voronoi.shape == (0, 2, 2)
    assert answer.stages.border == ()


@pytest.mark.parametrize("reading", ["split", "waist", "graph"])
def test_tape_and_graph_do_not_depend_on_the_reading(reading):
    points = point_set("figure_8", n=800, sigma=0.008, seed=5).points
    one, two = skeleton(points), skeleton(points, SkeletonParameters(crossings=reading))
    for a, b in zip(one.tape, two.tape, strict=True):
        np.testing.assert_array_equal(a.outer, b.outer)
    for a, b in zip(one.graph.edges, two.graph.edges, strict=True):
        np.testing.assert_array_equal(a.vertices, b.vertices)


def test_the_march_has_no_tape():
    answer = pca(arc(400, 0.02))
    assert answer.tape is None
    assert answer.containment is None
    assert answer.graph is None
