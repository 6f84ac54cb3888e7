import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.surface.boxes import FEW, order_of, tree_of

PLACES = arrays(
    np.float64, st.tuples(st.integers(1, 200), st.integers(2, 3)), elements=st.integers(-9, 9).map(float)
)


def branches(count, leaves):
    """The ranges of leaves below each inner node: start, middle, stop."""
    width = leaves
    while width > 1:
        for start in range(0, min(count, leaves), width):
            yield start, start + width // 2, min(start + width, count)
        width //= 2


@settings(max_examples=60, deadline=None)
@given(PLACES)
def test_branches_are_halved_across_their_longest_side(places):
    order = order_of(places)
    assert np.array_equal(np.sort(order), np.arange(len(places)))
    leaves = len(tree_of(places, places)) // 2
    for start, middle, stop in branches(len(places), leaves):
        if stop - start > FEW and middle < stop:
            some = places[order[start:stop]]
            longest = np.ptp(some, axis=0) == np.ptp(some, axis=0).max()
            halved = places[order[start:middle]].max(axis=0) <= places[order[middle:stop]].min(axis=0)
            assert np.any(longest & halved)


@settings(max_examples=30, deadline=None)
@given(PLACES, st.integers(0, 2**32 - 1))
def test_boxes_of_nodes_are_just_as_large_as_those_of_their_leaves(places, seed):
    size = np.random.default_rng(seed).uniform(0.0, 2.0, places.shape)
    tree = tree_of(places - size, places + size)
    leaves = len(tree) // 2
    assert len(places) <= leaves < 2 * len(places)
    for node in range(1, leaves):
        assert np.array_equal(tree[node, 0], tree[2 * node : 2 * node + 2, 0].min(axis=0))
        assert np.array_equal(tree[node, 1], tree[2 * node : 2 * node + 2, 1].max(axis=0))
    assert np.array_equal(tree[leaves : leaves + len(places), 0], places - size)
    assert np.all(tree[leaves + len(places) :, 0] > tree[leaves + len(places) :, 1])


def test_lines_of_equal_places_are_ordered_too():
    places = np.zeros((1000, 2))
    places[::2, 0] = 1.0
    order = order_of(places)
    assert np.array_equal(np.sort(order), np.arange(1000))
    assert set(places[order[:500], 0]) == {0.0}
