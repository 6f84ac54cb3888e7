import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.tape.graph import Graph, GraphEdge
from core.tape.junction import junctions, merged, paired
from tests.core.tape.drawings import ARM, crossed, graph_of, lengths, net, star, unit

SEEDS = st.integers(0, 2**32 - 1)


def in_a_row(*bars):
    """Forks in a row with bars of these lengths between them, which are the first edges."""
    x = np.concatenate([[0.0], np.cumsum(bars)])
    forks = np.column_stack((x, np.zeros(len(x))))
    sides = np.where(np.arange(len(x)) % 2, 1.0, -1.0)
    tips = forks + ARM * np.column_stack((np.zeros(len(x)), sides))
    ends = [(k, k + 1) for k in range(len(bars))] + [(k, len(x) + k) for k in range(len(x))]
    first, last = len(x) + len(tips), len(x) + len(tips) + 1
    places = [*forks, *tips, forks[0] - (ARM, 0.0), forks[-1] + (ARM, 0.0)]
    return graph_of(places, [*ends, (0, first), (len(x) - 1, last)])


def bars_of(graph, samples=None):
    return np.flatnonzero(junctions(graph, lengths(graph) if samples is None else samples)[1]).tolist()


def pairs_at(graph, samples=None):
    """The pairs of edges at every junction of three arms or more."""
    found, _ = junctions(graph, lengths(graph) if samples is None else samples)
    return [
        {frozenset(key[0] for key in pair) for pair in paired(junction)}
        for junction in found
        if len(junction.arms) >= 3
    ]


def moved(graph, factor, degrees, shift):
    turn = np.column_stack((unit(degrees), unit(degrees + 90.0)))
    edges = [GraphEdge(e.ends, factor * e.places @ turn.T + shift, factor * e.radius) for e in graph.edges]
    return Graph(factor * graph.places @ turn.T + shift, factor * graph.radius, tuple(edges))


def test_a_short_edge_between_forks_is_a_bar_and_a_long_one_is_not():
    assert bars_of(crossed(60.0, 1.0)) == [0]
    assert bars_of(crossed(60.0, 5.0)) == []


def test_how_short_a_bar_is_depends_on_the_discs():
    graph = crossed(60.0, 5.0)
    assert bars_of(Graph(graph.places, 3.0 * graph.radius, graph.edges)) == [0]


def test_a_long_edge_with_the_samples_of_two_branches_is_a_bar():
    graph = crossed(20.0, 10.0)
    once, twice = 10.0 * lengths(graph), 10.0 * lengths(graph)
    twice[0] *= 2.0
    assert bars_of(graph, once) == []
    assert bars_of(graph, twice) == [0]
    # A few samples more are chance.
    assert bars_of(graph, 0.02 * twice) == []


def test_even_a_shared_bar_is_only_so_long():
    graph = crossed(20.0, 100.0)
    samples = 10.0 * lengths(graph)
    samples[0] *= 2.0
    assert bars_of(graph, samples) == []


def test_a_short_leaf_is_no_bar():
    graph = graph_of([(0, 0), (ARM, 0), (-ARM, 0), (0, 1)], [(0, 1), (0, 2), (0, 3)])
    assert bars_of(graph) == []


def test_of_several_bars_at_a_fork_the_shortest_belongs_to_its_crossing():
    assert bars_of(in_a_row(2.4, 2.0, 2.4)) == [1]
    assert bars_of(in_a_row(2.0, 2.4, 2.1)) == [0, 2]


def test_forks_nearly_in_one_place_are_one_however_many():
    graph = in_a_row(0.4, 0.5, 0.6)
    found, bars = junctions(graph, lengths(graph))
    assert np.flatnonzero(bars).tolist() == [0, 1, 2]
    assert max(len(junction.arms) for junction in found) == 6


def test_arms_point_into_their_junction():
    found, _ = junctions(star(10.0, 100.0, 220.0), np.ones(3))
    for arm, degrees in zip(found[0].arms, (10.0, 100.0, 220.0), strict=True):
        np.testing.assert_allclose(arm.inward, -unit(degrees), atol=1e-12)
        np.testing.assert_allclose(arm.place, arm.trimmed * unit(degrees), atol=1e-12)
        assert 0.0 < arm.trimmed < ARM


def test_a_crossing_becomes_one_node_of_four_arms():
    graph = crossed(60.0, 1.0)
    graph.radius[1] = 1.2
    one = merged(graph, lengths(graph))
    (node,) = np.flatnonzero(one.degree == 4)
    np.testing.assert_allclose(one.places[node], (0.0, 0.0), atol=1e-12)
    assert one.radius[node] == 1.2
    assert len(one.edges) == 4
    assert len(one.places) == 5
    # Each arm goes on from its fork to the middle of the bar.
    np.testing.assert_allclose(lengths(one), ARM + 0.5)


def test_a_graph_without_bars_stays_as_it_is():
    graph = crossed(60.0, 5.0)
    one = merged(graph, lengths(graph))
    np.testing.assert_array_equal(one.places, graph.places)
    np.testing.assert_array_equal(one.radius, graph.radius)
    for edge, before in zip(one.edges, graph.edges, strict=True):
        assert edge.ends == before.ends
        np.testing.assert_array_equal(edge.places, before.places)


def test_a_graph_without_edges_has_no_junctions():
    empty = Graph(np.zeros((0, 2)), np.zeros(0), ())
    found, bars = junctions(empty, np.zeros(0))
    assert (found, len(bars)) == ([], 0)
    assert merged(empty, np.zeros(0)).edges == ()


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_merging_keeps_all_but_the_bars(seed):
    graph, samples = net(seed)
    found, bars = junctions(graph, samples)
    one = merged(graph, samples)
    assert len(one.edges) == np.count_nonzero(~bars)
    assert len(one.places) == len(found)
    np.testing.assert_array_equal(one.degree, [len(junction.arms) for junction in found])
    np.testing.assert_array_equal(one.radius, [junction.radius for junction in found])
    for edge in one.edges:
        np.testing.assert_allclose(edge.places[[0, -1]], one.places[list(edge.ends)], atol=1e-12)
        assert len(edge.radius) == len(edge.places)
    keys = sorted(arm.key for junction in found for arm in junction.arms)
    assert keys == [(int(k), end) for k in np.flatnonzero(~bars) for end in (0, 1)]


@pytest.mark.parametrize("degrees", [20.0, 40.0, 60.0, 90.0])
def test_crossing_lines_go_straight_on(degrees):
    bar = min(1.0 / np.sin(np.radians(degrees)), 3.0)
    assert pairs_at(crossed(degrees, bar)) == [{frozenset((1, 3)), frozenset((2, 4))}]


def test_a_t_junction_goes_on_along_its_bar():
    assert pairs_at(star(0.0, 90.0, 180.0)) == [{frozenset((0, 2))}]


def test_a_y_junction_goes_on_where_it_bends_least():
    assert pairs_at(star(0.0, 150.0, 240.0)) == [{frozenset((0, 1))}]


def test_of_parallel_lines_the_one_without_an_offset_is_continued():
    left = [(-0.8, 0.0), (-ARM, 0.0)]
    right = [(0.8, -0.8), (ARM, -0.8), (0.8, 0.1), (ARM, 0.1)]
    ends = [(0, 1), (2, 3), (4, 5), (0, 2), (0, 4), (2, 4)]
    graph = graph_of([*left, *right], ends, 2.0)
    assert bars_of(graph) == [3, 4, 5]
    assert pairs_at(graph) == [{frozenset((0, 2))}]


def test_a_figure_eight_crosses_itself():
    u = np.linspace(0.0, np.pi, 101)
    lobe = 10.0 * np.column_stack((np.sin(u), 0.5 * np.sin(2.0 * u)))
    loops = tuple(GraphEdge((0, 0), side * lobe, np.ones(101)) for side in (1.0, -1.0))
    found, _ = junctions(Graph(np.zeros((1, 2)), np.ones(1), loops), np.ones(2))
    pairs = {frozenset(pair) for pair in paired(found[0])}
    # A lobe starts upwards and comes back from below; the other is its image in the point.
    assert pairs == {frozenset(((0, 0), (1, 0))), frozenset(((0, 1), (1, 1)))}


@pytest.mark.parametrize("lines", [2, 3, 4, 5, 7])
@pytest.mark.parametrize("stray", [False, True])
def test_many_lines_through_a_point_all_go_straight_on(lines, stray):
    degrees = 7.0 + 180.0 * np.arange(lines) / lines
    # A stray arm between two of the others is left alone.
    more = [7.0 + 90.0 / lines] if stray else []
    graph = star(*degrees, *(degrees + 180.0), *more)
    assert pairs_at(graph) == [{frozenset((k, k + lines)) for k in range(lines)}]


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_every_arm_has_one_partner_but_an_odd_one(seed):
    for junction in junctions(*net(seed))[0]:
        keys = [key for pair in paired(junction) for key in pair]
        assert len(keys) == len(set(keys)) == 2 * (len(junction.arms) // 2)
        assert set(keys) <= {arm.key for arm in junction.arms}


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(-6.0, 6.0), st.floats(0.0, 360.0), st.floats(-3.0, 3.0))
def test_rotation_translation_and_scaling_change_nothing(seed, power, degrees, shift):
    graph, samples = net(seed)
    other = moved(graph, 10.0**power, degrees, 10.0**power * shift)
    np.testing.assert_array_equal(junctions(graph, samples)[1], junctions(other, samples)[1])
    assert pairs_at(graph, samples) == pairs_at(other, samples)
    there = moved(merged(graph, samples), 10.0**power, degrees, 10.0**power * shift)
    np.testing.assert_allclose(merged(other, samples).places, there.places, atol=1e-9 * 10.0**power)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(3, 10))
def test_the_order_of_the_arms_does_not_matter(seed, count):
    rng = np.random.default_rng(seed)
    degrees = rng.uniform(0.0, 360.0, count)
    assume(np.diff(np.sort(degrees)).min() > 1.0)
    order = rng.permutation(count)
    (pairs,), (shuffled,) = pairs_at(star(*degrees)), pairs_at(star(*degrees[order]))
    assert {frozenset(int(order[k]) for k in pair) for pair in shuffled} == pairs
