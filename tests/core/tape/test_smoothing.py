import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.arrangement import FREE, arrange
from core.tape.smoothing import graph_smoothing, split_smoothing, waist_smoothing
from tests.core.tape.drawings import (
    circle,
    double_eight,
    eight,
    extent,
    limacon,
    lissajous,
    ribbon,
    rose,
    scribble,
    segment,
)

SEEDS = st.integers(0, 2**32 - 1)


def curves_of(arrangement, smoothing):
    """Numbers of closed and of open curves, by following the joins."""
    other = {x: y for joins in smoothing for join in joins for x, y in (join, join[::-1])}
    left = set(range(len(arrangement.arcs)))
    opened = 0
    for tip in set(range(2 * len(arrangement.arcs))) - set(other):
        arm, opened = tip, opened + 1
        while arm is not None:
            left.discard(arm // 2)
            arm = other.get(arm ^ 1)
    closed = 0
    while left:
        arm, closed = 2 * next(iter(left)), closed + 1
        while arm // 2 in left:
            left.remove(arm // 2)
            arm = other[arm ^ 1]
    assert opened % 2 == 0
    return closed, opened // 2


def read(curves, smooth, **distances):
    arrangement = arrange(curves, **distances)
    return curves_of(arrangement, smooth(arrangement))


@pytest.mark.parametrize(
    ("curves", "lobes"),
    [
        ([eight()], 2),
        ([double_eight()], 4),
        ([lissajous()], 6),
        ([circle(), circle(1.0)], 2),
        ([circle(), circle(1.0), circle(0.5, 0.8)], 4),
        ([limacon()], 2),
    ],
)
def test_closed_curves_split_into_the_outlines_of_black_faces(curves, lobes):
    assert read(curves, split_smoothing) == (lobes, 0)
    assert read(curves, waist_smoothing) == (1, 0)


@pytest.mark.parametrize("petals", [3, 5])
def test_petals_through_one_place_are_split_and_joined(petals):
    assert read([rose(petals)], split_smoothing, merging=0.01) == (petals, 0)
    assert read([rose(petals)], waist_smoothing, merging=0.01) == (1, 0)


def test_a_loop_of_an_open_curve_is_cut_off_or_kept():
    assert read([ribbon()], split_smoothing) == (1, 1)
    assert read([ribbon()], waist_smoothing) == (0, 1)


def test_a_line_across_a_circle_leaves_one_closed_curve():
    across = [circle(), segment((-2.0, 0.1), (2.0, 0.3))]
    assert read(across, split_smoothing) == (1, 1)
    assert read(across, waist_smoothing) == (0, 1)


def test_a_line_into_a_circle_leaves_none():
    assert read([circle(), segment((-2.0, 0.1), (0.0, 0.3))], split_smoothing) == (0, 1)


def test_curves_that_end_on_others_change_nothing():
    spoke, chord = segment((1.0, 0.0), (2.0, 0.0)), segment((-0.99, 0.1), (0.99, 0.1))
    for smooth in (split_smoothing, waist_smoothing):
        assert read([circle(), spoke, chord], smooth, touching=0.05) == (1, 2)


def test_a_graph_joins_nothing_where_curves_meet():
    assert read([eight()], graph_smoothing) == (0, 2)
    assert read([circle(), segment((1.0, 0.0), (2.0, 0.0))], graph_smoothing, touching=0.05) == (0, 2)


@settings(max_examples=25, deadline=None)
@given(SEEDS, st.floats(0.0, 0.05))
def test_joins_do_not_cross(seed, share):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, closed) for closed in (True, True, False, False)]
    arrangement = arrange(curves, merging=share * extent(curves))
    for smooth in (split_smoothing, waist_smoothing):
        for node, joins in zip(arrangement.nodes, smooth(arrangement), strict=True):
            assert sorted(arm for join in joins for arm in join) == sorted(node.arms)
            spans = [sorted(map(node.arms.index, join)) for join in joins]
            assert not any(a < c < b < d for a, b in spans for c, d in spans)


@settings(max_examples=25, deadline=None)
@given(SEEDS, st.integers(1, 4), st.floats(0.0, 0.03))
def test_waists_make_one_curve_of_each_connected_part(seed, count, share):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, waves=3) for _ in range(count)]
    arrangement = arrange(curves, merging=share * extent(curves))
    if arrangement.arcs:
        parts = arrangement.connected.max() + 1
        assert curves_of(arrangement, waist_smoothing(arrangement)) == (parts, 0)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_waists_leave_closed_only_what_no_open_curve_meets(seed):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, closed, waves=3) for closed in (True, False, True, False)]
    arrangement = arrange(curves)
    if not arrangement.arcs:
        return
    closed, opened = curves_of(arrangement, waist_smoothing(arrangement))
    free = [
        part for arc, part in zip(arrangement.arcs, arrangement.connected, strict=True) if FREE in arc.nodes
    ]
    assert closed == len(set(arrangement.connected) - set(free))
    assert opened == len(free) // 2


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_switching_no_crossing_would_give_more_closed_curves(seed):
    rng = np.random.default_rng(seed)
    arrangement = arrange([scribble(rng)])
    split = split_smoothing(arrangement)
    closed, _ = curves_of(arrangement, split)
    for k, joins in enumerate(split):
        (a, b), (c, d) = joins
        switched = [*split[:k], [(b, c), (d, a)], *split[k + 1 :]]
        assert curves_of(arrangement, switched)[0] < closed
