import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.graph import Graph, GraphEdge
from core.tape.junction import junctions, paired
from core.tape.trace import straight_through
from tests.core.tape.drawings import ARM, crossed, graph_of, lengths, net, star, unit

SEEDS = st.integers(0, 2**32 - 1)


def traced(graph, samples=None):
    return straight_through(graph, lengths(graph) if samples is None else samples)


def ends(line):
    return {tuple(np.round(place[:2], 9)) for place in line.vertices[[0, -1]]}


def off(line, degrees):
    """Distance of its vertices from a line through the origin."""
    return np.abs(line.vertices[:, :2] @ unit(degrees + 90.0))


def ring(count=100, start=0.0):
    u = start + 2.0 * np.pi * np.arange(count + 1) / count
    places = 10.0 * np.column_stack((np.cos(u), np.sin(u)))
    places[-1] = places[0]
    return places


@pytest.mark.parametrize("degrees", [30.0, 60.0, 90.0])
def test_two_lines_go_straight_through_an_x(degrees):
    lines = traced(star(0.0, degrees, 180.0, 180.0 + degrees))
    assert [line.closed for line in lines] == [False, False]
    for line, angle in zip(sorted(lines, key=lambda line: off(line, 0.0).max()), (0.0, degrees), strict=True):
        assert ends(line) == {tuple(np.round(side * ARM * unit(angle), 9)) for side in (1, -1)}
        assert off(line, angle).max() < 1e-9
        assert line.length == pytest.approx(2.0 * ARM)


@pytest.mark.parametrize("degrees", [40.0, 60.0])
def test_the_bar_of_a_crossing_is_on_no_curve(degrees):
    graph = crossed(degrees, 1.0)
    lines = traced(graph)
    assert {frozenset(ends(line)) for line in lines} == {
        frozenset(tuple(np.round(graph.places[k], 9)) for k in pair) for pair in ((2, 4), (3, 5))
    }
    for line in lines:
        assert not np.any(np.all(line.vertices[:, :2] == graph.places[0], axis=1))
        # From arm to arm, with hardly a bend.
        steps = np.diff(line.vertices[:, :2], axis=0)
        turn = np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
        assert turn.max() < np.radians(30.0)


def test_a_t_leaves_one_end_at_its_junction():
    lines = traced(star(0.0, 270.0, 180.0))
    assert [line.closed for line in lines] == [False, False]
    stem, bar = sorted(lines, key=lambda line: line.length)
    assert bar.length == pytest.approx(2.0 * ARM)
    assert np.abs(bar.vertices[:, 1]).max() < 1e-9
    tip, foot = stem.vertices[np.argsort(stem.vertices[:, 1])[[0, -1]], :2]
    np.testing.assert_allclose(tip, (0.0, -ARM), atol=1e-9)
    # Within the disc of the node, of radius 1.
    assert np.hypot(*foot) <= 1.0 + 1e-9


def test_a_loop_without_forks_is_a_closed_curve():
    places = ring()
    (line,) = traced(Graph(places[:1], np.ones(1), (GraphEdge((0, 0), places, np.ones(101)),)))
    assert line.closed
    np.testing.assert_array_equal(line.vertices[:, :2], places[:-1])


def test_an_eight_is_one_closed_curve():
    u = np.linspace(0.0, np.pi, 101)
    lobe = 10.0 * np.column_stack((np.sin(u), 0.5 * np.sin(2.0 * u)))
    loops = tuple(GraphEdge((0, 0), side * lobe, np.ones(101)) for side in (1.0, -1.0))
    graph = Graph(np.zeros((1, 2)), np.ones(1), loops)
    (line,) = traced(graph)
    assert line.closed
    assert line.length == pytest.approx(lengths(graph).sum(), rel=0.01)


def test_a_ring_crossed_by_a_line_stays_closed():
    arcs = ring()[:51], ring()[50:]
    places = np.array([(10.0, 0.0), (-10.0, 0.0), (40.0, 0.0), (-40.0, 0.0)])
    edges = [GraphEdge((0, 1), arcs[0], np.ones(51)), GraphEdge((1, 0), arcs[1], np.ones(51))]
    edges += graph_of(places, [(2, 0), (0, 1), (1, 3)]).edges
    lines = traced(Graph(places, np.ones(4), tuple(edges)))
    assert sorted(line.closed for line in lines) == [False, True]
    bar, loop = sorted(lines, key=lambda line: line.closed)
    assert bar.length == pytest.approx(80.0)
    assert loop.length == pytest.approx(20.0 * np.pi, rel=0.01)


def test_an_edge_alone_stays_as_it_is():
    graph = graph_of([(0, 0), (3, 4)], [(0, 1)])
    (line,) = traced(graph)
    assert not line.closed
    np.testing.assert_allclose(line.vertices[:, :2], graph.edges[0].places)


def test_separate_edges_are_separate_curves():
    graph = graph_of([(0, 0), (9, 0), (0, 1), (9, 1)], [(0, 1), (2, 3)])
    assert [line.length for line in traced(graph)] == [9.0, 9.0]


def test_no_graph_has_no_curves():
    assert straight_through(Graph(np.zeros((0, 2)), np.zeros(0), ()), np.zeros(0)) == []


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_curves_end_where_an_arm_has_no_partner(seed):
    graph, samples = net(seed)
    found, bars = junctions(graph, samples)
    pairs = sum(len(paired(junction)) for junction in found if len(junction.arms) > 1)
    lines = straight_through(graph, samples)
    free = 2 * np.count_nonzero(~bars) - 2 * pairs
    assert 2 * sum(not line.closed for line in lines) == free
    for line in lines:
        assert np.all(line.vertices[:, 2] == 0.0)
        assert np.all(np.any(np.diff(line.vertices, axis=0) != 0.0, axis=1))
