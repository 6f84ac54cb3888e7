import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from core.truth.stacks import closed_curve, random_stack

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS)
def test_levels_rise_and_hold_closed_contours(seed):
    levels = random_stack(seed)
    assert 2 <= len(levels) <= 7
    assert np.all(np.diff([level.height for level in levels]) > 0.0)
    assert levels[0].curves
    for level in levels:
        for curve in level.curves:
            assert curve.closed
            assert curve.vertices.shape[0] >= 3
            assert curve.vertices.shape[1] == 2


@given(SEEDS)
def test_the_same_seed_gives_the_same_stack(seed):
    for one, other in zip(random_stack(seed), random_stack(seed), strict=True):
        assert one.height == other.height
        for a, b in zip(one.curves, other.curves, strict=True):
            assert np.array_equal(a.vertices, b.vertices)


def test_every_hardship_occurs():
    stacks = [random_stack(seed) for seed in range(100)]
    assert any(not level.curves for levels in stacks for level in levels)
    edges = [
        {
            frozenset(map(tuple, edge))
            for c in level.curves
            for edge in zip(c.vertices, np.roll(c.vertices, -1, 0), strict=True)
        }
        for levels in stacks
        for level in levels
    ]
    assert any(one & other for one, other in zip(edges[1:], edges[:-1], strict=True))


def test_the_length_of_a_closed_curve_counts_its_last_edge():
    assert closed_curve(np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)])).length == 12.0
