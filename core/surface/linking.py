"""Segments that share nodes, linked to polylines; compiled, in linear time."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["link"]

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def link(segments: Ints, nodes: int) -> tuple[Ints, Ints, Bools]:
    """Link directed segments to polylines.

    At a node ends are paired with starts, and where there are several of each, first with first; what
    is left over of one kind (faces that are not oriented alike) is paired too. A node that is left with one
    end is the end of an open polyline.

    Parameters
    ----------
    segments : (S, 2) array
        Nodes at which each one starts and ends.
    nodes : int
        How many there are.

    Returns
    -------
    chains : (M,) array
        Nodes of all polylines, one after another; a closed one does not repeat its first node.
    starts : (P + 1,) array
        Polyline p has the nodes ``chains[starts[p]:starts[p + 1]]``.
    closed : (P,) array of bool
    """
    segments = np.ascontiguousarray(segments)
    partner = _paired(*_sorted(segments, nodes))
    chains, starts, closed = _chained(segments, partner)
    return chains, starts, closed


@njit(cache=True)
def _sorted(segments, nodes):  # type: ignore[no-untyped-def]
    """Return the ends 2 s (start) and 2 s + 1 by node, and where the starts and the ends of each begin."""
    bounds = np.zeros(2 * nodes + 1, np.int64)
    for s in range(segments.shape[0]):
        for k in range(2):
            bounds[2 * segments[s, k] + k + 1] += 1
    for place in range(1, bounds.shape[0]):
        bounds[place] += bounds[place - 1]
    ends, filled = np.empty(2 * segments.shape[0], np.int64), bounds.copy()
    for s in range(segments.shape[0]):
        for k in range(2):
            place = 2 * segments[s, k] + k
            ends[filled[place]] = 2 * s + k
            filled[place] += 1
    return ends, bounds


@njit(cache=True)
def _paired(ends, bounds):  # type: ignore[no-untyped-def]
    """Return for the ends 2 s (start) and 2 s + 1 of each segment the ones that they are joined to, or -1."""
    partner = np.full(ends.shape[0], -1, np.int64)
    for node in range(bounds.shape[0] // 2):
        first, middle, last = bounds[2 * node], bounds[2 * node + 1], bounds[2 * node + 2]
        mixed = min(middle - first, last - middle)
        for k in range(mixed):
            one, other = ends[first + k], ends[middle + k]
            partner[one], partner[other] = other, one
        rest = first + mixed if middle - first > mixed else middle + mixed
        stop = middle if middle - first > mixed else last
        while rest + 1 < stop:
            one, other = ends[rest], ends[rest + 1]
            partner[one], partner[other] = other, one
            rest += 2
    return partner


@njit(cache=True)
def _chained(segments, partner):  # type: ignore[no-untyped-def]
    """Follow the partners: first from loose starts, then from loose ends, then around what is closed."""
    size = segments.shape[0]
    done = np.zeros(size, np.bool_)
    chains = np.empty(2 * size, np.int64)
    starts = np.zeros(size + 1, np.int64)
    closed = np.zeros(size, np.bool_)
    count, used = 0, 0
    for turn in range(3):
        for first in range(size):
            entry = 2 * first + (1 if turn == 1 else 0)
            if done[first] or (turn < 2 and partner[entry] >= 0):
                continue
            while True:
                segment = entry // 2
                done[segment] = True
                chains[used] = segments[segment, entry % 2]
                used += 1
                leaving = entry ^ 1
                entry = partner[leaving]
                if entry < 0:
                    chains[used] = segments[segment, leaving % 2]
                    used += 1
                    break
                if done[entry // 2]:
                    closed[count] = True
                    break
            count += 1
            starts[count] = used
    return chains[:used], starts[: count + 1], closed[:count]
