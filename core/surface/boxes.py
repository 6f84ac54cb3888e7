"""Complete binary trees of boxes around many small things; those in one branch lie near each other.

Compiled searches walk them: node n has the children 2 n and 2 n + 1, the root is node 1, and the
leaves come last, in the order given.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["DEEP", "order_of", "tree_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DEEP = 128  # more than the nodes that wait in a search: a tree has at most 60 levels
FEW = 4  # things in any order


def order_of(places: Floats) -> Ints:
    """The order of (M, D) places in which each branch of a tree is halved across its longest side."""
    return _halved(places, _leaves(len(places)))


def tree_of(low: Floats, high: Floats) -> Floats:
    """The boxes (2 L, 2, D) of the nodes, lower corners and upper ones; L is a power of two.

    ``low`` and ``high``, both (M, D), are those of the leaves L, L + 1 ...; the others are empty.
    """
    leaves = _leaves(len(low))
    tree = np.empty((2 * leaves, 2, low.shape[1]))
    tree[:, 0], tree[:, 1] = np.inf, -np.inf
    tree[leaves : leaves + len(low), 0], tree[leaves : leaves + len(low), 1] = low, high
    first = leaves
    while first > 1:
        one, other = tree[first : 2 * first : 2], tree[first + 1 : 2 * first : 2]
        np.minimum(one[:, 0], other[:, 0], out=tree[first // 2 : first, 0])
        np.maximum(one[:, 1], other[:, 1], out=tree[first // 2 : first, 1])
        first //= 2
    return tree


def _leaves(count: int) -> int:
    return 1 << max(0, count - 1).bit_length()


@njit(cache=True)
def _halved(places: Floats, leaves: int) -> Ints:
    order, size = np.arange(len(places)), 1
    starts, stops, wide = np.empty(DEEP, np.int64), np.empty(DEEP, np.int64), np.empty(DEEP, np.int64)
    starts[0], stops[0], wide[0] = 0, len(places), leaves
    while size > 0:
        size -= 1
        start, stop, half = starts[size], stops[size], wide[size] // 2
        if stop - start <= FEW:
            continue
        middle = min(start + half, stop)
        if middle < stop:
            _part(places[:, _widest(places, order[start:stop])], order[start:stop], half)
        starts[size], stops[size], wide[size] = start, middle, half
        starts[size + 1], stops[size + 1], wide[size + 1] = middle, stop, half
        size += 2
    return order


@njit(cache=True)
def _widest(places: Floats, some: Ints) -> int:
    """The coordinate in which some places extend most."""
    axis, most = 0, -1.0
    for k in range(places.shape[1]):
        low, high = np.inf, -np.inf
        for i in some:
            low, high = min(low, places[i, k]), max(high, places[i, k])
        if high - low > most:
            axis, most = k, high - low
    return axis


@njit(cache=True)
def _part(value: Floats, order: Ints, count: int) -> None:
    """Put ``count`` of the lowest values first (Hoare 1961)."""
    low, high = 0, len(order) - 1
    while low < high:
        pivot, i, j = value[order[(low + high) // 2]], low, high
        while i <= j:
            while value[order[i]] < pivot:
                i += 1
            while value[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if count <= j:
            high = j
        elif count >= i:
            low = i
        else:
            return
