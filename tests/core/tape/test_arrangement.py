import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.crossings import crossings
from core.refine.polyline import Polyline
from core.tape.arrangement import FREE, arrange
from tests.core.tape.drawings import circle, eight, extent, flat, ribbon, rose, scribble, segment

SEEDS = st.integers(0, 2**32 - 1)


def leaving(arrangement, arm):
    v = arrangement.arcs[arm // 2].vertices
    step = v[1] - v[0] if arm % 2 == 0 else v[-2] - v[-1]
    return np.arctan2(step[1], step[0])


def star(*angles, shift=0.0):
    """Lines through the origin, or past it at a distance."""
    out = []
    for angle in angles:
        along = np.array((np.cos(angle), np.sin(angle)))
        out.append(segment(*(shift * np.array((-along[1], along[0])) + s * along for s in (-1.0, 1.0))))
    return out


def test_an_eight_is_one_node_and_two_lobes():
    arrangement = arrange([eight()])
    (node,) = arrangement.nodes
    np.testing.assert_allclose(node.place, 0.0, atol=1e-4)
    assert node.degree == 4
    assert sorted(node.arcs) == [0, 0, 1, 1]
    assert [arc.nodes for arc in arrangement.arcs] == [(0, 0), (0, 0)]
    assert all(arc.closed and arc.curve == 0 for arc in arrangement.arcs)
    assert arrangement.uncut == ()


def test_curves_without_crossings_are_not_cut():
    arrangement = arrange([circle(5.0), ribbon(), circle(9.0)])
    assert arrangement.uncut == (0, 2)
    assert {arc.curve for arc in arrangement.arcs} == {1}
    assert arrange([]).arcs == ()


@settings(max_examples=20, deadline=None)
@given(SEEDS, st.integers(1, 3))
def test_scribbles_keep_their_length_and_their_crossings(seed, count):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng) for _ in range(count)]
    arrangement = arrange(curves)
    met = crossings(curves)
    assert len(arrangement.nodes) == len(met)
    assert len(arrangement.arcs) == 2 * len(met)
    for k in set(range(count)) - set(arrangement.uncut):
        parts = sum(arc.line.length for arc in arrangement.arcs if arc.curve == k)
        assert parts == pytest.approx(curves[k].length, abs=1e-5 * extent(curves))


@settings(max_examples=20, deadline=None)
@given(SEEDS, st.floats(0.0, 0.05))
def test_arcs_meet_exactly_in_nodes_with_arms_counter_clockwise(seed, share):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, closed) for closed in (True, False, False)]
    arrangement = arrange(curves, touching=share, merging=share * extent(curves))
    seen = []
    for k, node in enumerate(arrangement.nodes):
        assert len(node.arms) % 2 == 0
        seen += [*node.arms, *node.ending]
        for arm in node.arms + node.ending:
            arc = arrangement.arcs[arm // 2]
            assert arc.nodes[arm % 2] == k
            assert np.array_equal(arc.vertices[-(arm % 2)], node.place)
        turns = np.diff([leaving(arrangement, arm) for arm in (*node.arms, *node.arms[:1])]) % (2.0 * np.pi)
        assert len(turns) == 0 or turns.sum() == pytest.approx(2.0 * np.pi)
    free = [
        2 * k + side for k, arc in enumerate(arrangement.arcs) for side in (0, 1) if arc.nodes[side] == FREE
    ]
    assert sorted(seen + free) == list(range(2 * len(arrangement.arcs)))


def test_connected_parts_are_told_apart():
    arrangement = arrange([eight(), circle(9.0), circle(9.5), circle(0.0, 9.0), circle(1.0, 9.0)])
    part = {arc.curve: int(k) for arc, k in zip(arrangement.arcs, arrangement.connected, strict=True)}
    assert part[1] == part[2]
    assert part[3] == part[4]
    assert len({part[0], part[1], part[3]}) == 3


def test_where_a_curve_ends_on_another_is_a_node_of_three():
    arrangement = arrange([circle(), segment((1.02, 0.0), (3.0, 0.0))], touching=0.05)
    (node,) = arrangement.nodes
    assert node.degree == 3
    (arm,) = node.ending
    assert arrangement.arcs[arm // 2].curve == 1
    assert np.array_equal(arrangement.arcs[arm // 2].vertices[0], node.place)


def test_what_reaches_beyond_a_curve_by_less_than_the_distance_is_cut_off():
    stick = segment((0.98, 0.0), (3.0, 0.0))
    arrangement = arrange([circle(), stick], touching=0.05)
    assert [node.degree for node in arrangement.nodes] == [3]
    (arc,) = (arc for arc in arrangement.arcs if arc.curve == 1)
    assert arc.line.length == pytest.approx(2.0, abs=1e-3)
    assert [node.degree for node in arrange([circle(), stick]).nodes] == [4]


def test_a_curve_may_end_on_others_with_both_ends():
    chord = segment((-0.99, 0.0), (0.99, 0.0))
    arrangement = arrange([circle(), chord], touching=0.05)
    assert [node.degree for node in arrangement.nodes] == [3, 3]
    assert len(arrangement.arcs) == 3


def test_branches_through_one_place_share_a_node():
    assert [node.degree for node in arrange(star(0.1, 1.2, 2.3)).nodes] == [6]
    assert [node.degree for node in arrange([rose(3)], merging=0.01).nodes] == [6]
    assert [node.degree for node in arrange([rose(5)], merging=0.01).nodes] == [10]


def test_crossings_near_each_other_are_merged_on_request():
    lines = star(0.1, 1.2, 2.3, shift=0.003)
    assert [node.degree for node in arrange(lines).nodes] == [4, 4, 4]
    (node,) = arrange(lines, merging=0.02).nodes
    assert node.degree == 6
    np.testing.assert_allclose(node.place, 0.0, atol=0.01)


def test_a_crowd_of_crossings_is_not_merged():
    lines = [segment((-1.0, y), (1.0, y)) for y in np.arange(6) * 0.01]
    lines += [segment((x, -1.0), (x, 1.0)) for x in np.arange(6) * 0.01]
    assert len(arrange(lines, merging=0.012).nodes) == 36


def test_a_loop_that_is_too_small_is_lost_in_its_node():
    # At 0.01 of its size the loop of this ribbon is about 0.03 long.
    small = Polyline(ribbon().vertices * 0.01, False)
    arms = small.vertices[[0, -1], :2]
    long = flat([arms[0] * 60.0, *small.vertices[:, :2], arms[1] * 60.0])
    assert [node.degree for node in arrange([long]).nodes] == [4]
    (node,) = arrange([long], merging=0.02).nodes
    assert node.degree == 2


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_the_order_of_the_curves_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, closed) for closed in (True, False, True)]
    there = arrange(curves, 0.01, 0.01)
    back = arrange([Polyline(c.vertices[::-1], c.closed) for c in curves[::-1]], 0.01, 0.01)
    assert sorted(n.degree for n in there.nodes) == sorted(n.degree for n in back.nodes)
    lengths = [np.sort([arc.line.length for arc in a.arcs]) for a in (there, back)]
    np.testing.assert_allclose(*lengths, atol=1e-9)
