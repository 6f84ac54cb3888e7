import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.delaunay import triangulate
from core.tape.graph import skeleton_graph
from core.tape.medial_axis import Border, MedialAxis

SEEDS = st.integers(0, 2**32 - 1)
NO_BORDER = Border(np.zeros((0, 2)), np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


def axis_of(places, edges, radius=1.0):
    """An axis without hair."""
    places = np.asarray(places, float)
    radii = np.broadcast_to(np.asarray(radius, float), len(places)).copy()
    edges = np.array(edges, np.int64).reshape(-1, 2)
    return MedialAxis(places, radii, edges, np.ones(len(edges), np.bool_), NO_BORDER)


def spider(*lengths, radius=1.0):
    """Legs of some lengths, of five steps each, from the origin in all directions."""
    places, edges = [(0.0, 0.0)], []
    for k, length in enumerate(lengths):
        angle = 2.0 * np.pi * k / len(lengths)
        first = len(places)
        places += [(s * length * np.cos(angle), s * length * np.sin(angle)) for s in np.arange(1, 6) / 5]
        edges += [(0, first), *((first + j, first + j + 1) for j in range(4))]
    return axis_of(places, edges, radius)


def ring(count):
    u = 2.0 * np.pi * np.arange(count) / count
    return axis_of(np.column_stack((np.cos(u), np.sin(u))), [(k, (k + 1) % count) for k in range(count)])


def net(seed):
    """A random connected axis."""
    rng = np.random.default_rng(seed)
    mesh = triangulate(rng.normal(size=(int(rng.integers(4, 40)), 2)))
    pairs = np.unique(np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    return axis_of(mesh.points, pairs[rng.uniform(size=len(pairs)) < rng.uniform(0.3, 1.0)], 0.01)


def way(axis):
    return np.hypot(*(axis.places[axis.edges[:, 0]] - axis.places[axis.edges[:, 1]]).T).sum()


def lengths(graph):
    return sorted(edge.length for edge in graph.edges)


def test_a_chain_is_one_edge_between_two_ends():
    places = np.column_stack((np.arange(7.0), np.zeros(7)))
    order = np.random.default_rng(0).permutation(7)
    edges = [(order[k], order[k + 1]) for k in range(6)]
    scattered = np.empty_like(places)
    scattered[order] = places
    graph = skeleton_graph(axis_of(scattered, edges), 2.0)
    (edge,) = graph.edges
    assert edge.length == 6.0
    assert graph.degree.tolist() == [1, 1]
    course = edge.places if edge.places[0, 0] == 0.0 else edge.places[::-1]
    np.testing.assert_array_equal(course, places)


@pytest.mark.parametrize("count", [3, 4, 50])
def test_a_loop_without_forks_has_one_node_of_degree_two(count):
    graph = skeleton_graph(ring(count), 2.0)
    (edge,) = graph.edges
    assert edge.ends == (0, 0)
    assert graph.degree.tolist() == [2]
    assert len(edge.places) == count + 1
    np.testing.assert_array_equal(edge.places[0], edge.places[-1])
    assert edge.length == pytest.approx(2.0 * count * np.sin(np.pi / count))


def test_legs_meet_in_a_fork():
    graph = skeleton_graph(spider(4.0, 5.0, 6.0), 2.0)
    assert sorted(graph.degree) == [1, 1, 1, 3]
    np.testing.assert_allclose(lengths(graph), (4.0, 5.0, 6.0))
    (fork,) = np.flatnonzero(graph.degree == 3)
    np.testing.assert_array_equal(graph.places[fork], (0.0, 0.0))
    assert all(fork in edge.ends for edge in graph.edges)


def test_a_loop_with_a_tail_keeps_its_loop():
    loop = ring(20)
    tail = [(1.0 + k, 0.0) for k in range(1, 6)]
    edges = [*loop.edges.tolist(), (0, 20), *((k, k + 1) for k in range(20, 24))]
    graph = skeleton_graph(axis_of([*loop.places, *tail], edges), 2.0)
    assert sorted(graph.degree) == [1, 3]
    assert sum(edge.ends[0] == edge.ends[1] for edge in graph.edges) == 1
    np.testing.assert_allclose(lengths(graph)[0], 5.0)
    # As a hair the tail goes, and its fork with it.
    assert skeleton_graph(axis_of([*loop.places, *tail], edges), 6.0).degree.tolist() == [2]


def test_of_short_leaves_the_shortest_goes_first_and_the_other_goes_on():
    graph = skeleton_graph(spider(1.2, 1.5, 20.0), 2.0)
    (edge,) = graph.edges
    assert edge.length == pytest.approx(21.5)
    assert graph.degree.tolist() == [1, 1]


def test_leaves_of_several_forks_go_together():
    x = np.arange(21.0)
    back = np.column_stack((x, np.zeros(21)))
    thorns = [(5.0, 1.0), (10.0, -1.2), (15.0, 0.8)]
    edges = [*((k, k + 1) for k in range(20)), (5, 21), (10, 22), (15, 23)]
    (edge,) = skeleton_graph(axis_of([*back, *thorns], edges), 2.0).edges
    assert edge.length == 20.0


@pytest.mark.parametrize(("reach", "legs"), [(0.0, 4), (1.1, 3), (2.1, 2), (50.0, 2)])
def test_the_more_is_pruned_the_fewer_legs_stay(reach, legs):
    graph = skeleton_graph(spider(1.0, 9.0, 2.0, 8.0), reach)
    assert np.count_nonzero(graph.degree == 1) == legs


def test_what_is_short_is_told_by_the_discs():
    assert len(skeleton_graph(spider(3.0, 9.0, 9.0), 2.0).edges) == 3
    assert len(skeleton_graph(spider(3.0, 9.0, 9.0, radius=2.0), 2.0).edges) == 1
    # A leaf whose tip's disc sticks out is longer by that.
    axis = spider(1.5, 9.0, 9.0)
    axis.radius[5] = 2.0
    assert len(skeleton_graph(axis, 2.0).edges) == 3


def test_a_lone_leaf_is_no_hair():
    graph = skeleton_graph(axis_of([(0, 0), (0.1, 0)], [(0, 1)]), 2.0)
    assert lengths(graph) == [0.1]


def test_radii_come_along():
    radius = np.arange(1.0, 17.0)
    axis = spider(40.0, 50.0, 60.0, radius=radius)
    graph = skeleton_graph(axis, 0.0)
    for edge in graph.edges:
        for place, r in zip(edge.places, edge.radius, strict=True):
            np.testing.assert_array_equal(axis.places[axis.radius == r][0], place)
    for place, r in zip(graph.places, graph.radius, strict=True):
        np.testing.assert_array_equal(axis.places[axis.radius == r][0], place)


def test_an_axis_of_nothing_is_a_graph_of_nothing():
    graph = skeleton_graph(axis_of([(0, 0), (1, 0)], []), 2.0)
    assert graph.edges == ()
    assert len(graph.degree) == len(graph.places) == 0


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_every_edge_of_the_axis_lies_on_one_edge_of_the_graph(seed):
    axis = net(seed)
    graph = skeleton_graph(axis, 0.0)
    assert sum(lengths(graph)) == pytest.approx(way(axis))
    assert sum(len(edge.places) - 1 for edge in graph.edges) == len(axis.edges)
    assert graph.degree.sum() == 2 * len(graph.edges)
    for edge in graph.edges:
        np.testing.assert_array_equal(edge.places[[0, -1]], graph.places[list(edge.ends)])
        assert len(edge.radius) == len(edge.places)
    loops = {edge.ends[0] for edge in graph.edges if edge.ends[0] == edge.ends[1]}
    assert set(np.flatnonzero(graph.degree == 2).tolist()) <= loops


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.floats(0.0, 100.0))
def test_pruning_takes_leaves_and_keeps_loops(seed, reach):
    axis = net(seed)
    before, after = skeleton_graph(axis, 0.0), skeleton_graph(axis, reach)
    assert sum(lengths(after)) <= sum(lengths(before)) * (1.0 + 1e-12)

    def excess(graph):
        return len(graph.edges) - len(graph.places)

    # A loop without forks has a node of its own; a leaf goes with its tip.
    assert excess(after) == excess(before)
    assert np.count_nonzero(after.degree == 1) <= np.count_nonzero(before.degree == 1)
