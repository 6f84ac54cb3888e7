from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.linking import link


def chains_of(segments, nodes):
    chains, starts, closed = link(np.asarray(segments, np.int64).reshape(-1, 2), nodes)
    return [chains[a:b].tolist() for a, b in pairwise(starts)], closed.tolist()


@settings(deadline=None)
@given(st.permutations(range(6)))
def test_a_ring_is_closed_whatever_the_order_of_its_segments(order):
    (chain,), (closed,) = chains_of([(k, (k + 1) % 6) for k in order], 6)
    assert closed
    start = chain.index(0)
    assert chain[start:] + chain[:start] == [0, 1, 2, 3, 4, 5]


@settings(deadline=None)
@given(st.permutations(range(5)))
def test_a_path_is_open_and_keeps_its_direction(order):
    chains, closed = chains_of([(k, k + 1) for k in order], 6)
    assert chains == [[0, 1, 2, 3, 4, 5]]
    assert closed == [False]


@settings(deadline=None)
@given(st.lists(st.booleans(), min_size=6, max_size=6))
def test_segments_of_either_direction_link(turned):
    segments = [((k + 1) % 6, k) if back else (k, (k + 1) % 6) for k, back in enumerate(turned)]
    (chain,), (closed,) = chains_of(segments, 6)
    assert closed
    assert sorted(chain) == [0, 1, 2, 3, 4, 5]
    steps = {(a - b) % 6 for a, b in zip(chain, chain[1:] + chain[:1], strict=True)}
    assert steps in ({1}, {5})


def test_two_rings_that_share_a_node_use_every_segment_once():
    chains, closed = chains_of([(0, 1), (1, 2), (2, 0), (0, 3), (3, 4), (4, 0)], 5)
    assert all(closed)
    assert sum(len(chain) for chain in chains) == 6


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(2, 12))
def test_any_segments_are_all_used_once_and_chains_end_only_where_ends_are_left(seed, count, nodes):
    rng = np.random.default_rng(seed)
    segments = rng.integers(0, nodes, size=(count, 2))
    chains, closed = chains_of(segments, nodes)
    sides = [
        tuple(sorted(pair))
        for chain, ring in zip(chains, closed, strict=True)
        for pair in zip(chain, chain[1:] + (chain[:1] if ring else []), strict=False)
    ]
    assert sorted(sides) == sorted(tuple(sorted(pair)) for pair in segments.tolist())
    ends = [
        node for chain, ring in zip(chains, closed, strict=True) if not ring for node in (chain[0], chain[-1])
    ]
    odd = np.bincount(segments.ravel(), minlength=nodes) % 2
    assert sorted(ends) == np.flatnonzero(odd).tolist()


def test_nothing_links_to_nothing():
    assert chains_of(np.zeros((0, 2)), 0) == ([], [])


@pytest.mark.parametrize("size", [1, 2])
def test_short_rings_are_rings(size):
    (chain,), (closed,) = chains_of([(k, (k + 1) % size) for k in range(size)], size)
    assert closed
    assert len(chain) == size
