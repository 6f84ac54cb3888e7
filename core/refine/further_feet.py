"""Feet of samples on a second and a third branch, where branches are near each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.refine.branches import APART, DETOUR, Branches
from core.refine.project import distance_to_segment

__all__ = ["Further", "further_feet"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FADE = 1.5  # a foot counts in full where the way to it is so much longer than the least way
MOST = 2  # further feet that a sample keeps: three branches meet in a triple point
_TRIED = 8


@dataclass(frozen=True, slots=True, eq=False)
class Further:
    """The R samples that have feet on further branches, and these E feet.

    Attributes
    ----------
    sample, node : (R,) array of int
        Which sample, and the node next to its first foot.
    row : (E,) array of int
        Whose foot it is, as a place in ``sample``; in ascending order.
    curve, station, distance : (E,) arrays
    branch : (E,) array
        How far it is on another branch than the sample's nearer feet, between 0 and 1.
    at : (E,) array of int
        The node near it.
    """

    sample: Ints
    node: Ints
    row: Ints
    curve: Ints
    station: Floats
    distance: Floats
    branch: Floats
    at: Ints


def further_feet(
    points: Floats, curve: Ints, station: Floats, distance: Floats, branches: Branches
) -> tuple[Further, Floats]:
    """Find the feet of samples on branches other than that of their first foot.

    Where a sample lies between two near branches, it has a foot on either: the nearest place
    around. The two are on different branches when the way between them along their curve is more than
    eight sigma and twice their chord.

    Parameters
    ----------
    points : (N, 3) array
    curve, station, distance : (N,) array
        First feet; curve -1 where there is none.
    branches : Branches

    Returns
    -------
    further : Further
    mass : (K,) array
        Number of first feet next to each node, within the cut.
    """
    b = branches
    reach = b.cut * b.sigmas + 0.5 * b.step
    sample, node, mass = _asked(
        curve, station, distance, b.closed, b.first_node, b.step, b.nearest, b.cut * b.sigmas, reach.max()
    )
    found = _search(
        points, sample, node, station, distance,
        b.heads, b.tails, b.spans, b.first_segment, b.first_node, b.closed,
        b.place, b.curve, b.segment, b.step, b.starts, b.partners, b.sigmas, b.cut,
    )  # fmt: skip
    kept, *feet = found
    return Further(sample[kept], node[kept], *feet), mass


@njit(cache=True)
def _asked(curve, station, distance, closed, first, step, nearest, cut, reach):  # type: ignore[no-untyped-def]
    """The samples that may have a further foot, the nodes next to their first, and all feet next to nodes."""
    n = curve.shape[0]
    index, node = np.empty(n, np.int64), np.empty(n, np.int64)
    mass = np.zeros(nearest.shape[0])
    count = 0
    for i in range(n):
        k = curve[i]
        if k < 0:
            continue
        size = first[k + 1] - first[k]
        m = int(station[i] / step[k] + 0.5) if step[k] > 0.0 else 0
        if m >= size:
            m = 0 if closed[k] else size - 1
        m += first[k]
        if distance[i] < cut[k]:
            mass[m] += 1.0
        if nearest[m] <= distance[i] + reach:
            index[count], node[count] = i, m
            count += 1
    return index[:count], node[:count], mass


@njit(cache=True, inline="always")
def _square_to(x, y, z, place, n):  # type: ignore[no-untyped-def]
    """Squared distance to row ``n`` of ``place``."""
    return (x - place[n, 0]) ** 2 + (y - place[n, 1]) ** 2 + (z - place[n, 2]) ** 2


@njit(cache=True, inline="always")
def _is_lowest(x, y, z, place, n, low, high, ring, square):  # type: ignore[no-untyped-def]
    """Whether neither neighbour of node ``n`` among ``low`` to ``high`` is nearer."""
    before, after = n - 1, n + 1
    if before < low:
        before = high - 1 if ring else n
    if after >= high:
        after = low if ring else n
    if _square_to(x, y, z, place, after) < square:
        return False
    return _square_to(x, y, z, place, before) >= square


@njit(cache=True)
def _descend(x, y, z, heads, tails, s, low, high, ring):  # type: ignore[no-untyped-def]
    """Walk from segment ``s`` among ``low`` to ``high`` while it comes nearer: segment, fraction, square."""
    best, t = distance_to_segment(x, y, z, heads, tails, s)
    start = s
    for way in (1, -1):
        if way == -1 and s != start:
            break
        at = start
        for _ in range(high - low):
            at += way
            if at < low or at >= high:
                if not ring:
                    break
                at = low if way == 1 else high - 1
            square, u = distance_to_segment(x, y, z, heads, tails, at)
            if square > best:
                break
            best, t, s = square, u, at
    return s, t, best


@njit(cache=True, inline="always")
def _near_feet(  # type: ignore[no-untyped-def]
    x, y, z, n, heads, tails, first_segment, first_node, closed,
    place, node_curve, segment, step, starts, partners, reach, node, on, along, square,
):  # fmt: skip
    """Write the feet on the branches near node ``n``, nearest first, from 1 on; one more than the last."""
    found, last, before = 1, -2, 0.0
    for j in range(starts[n], starts[n + 1]):
        p = partners[j]
        k = node_curve[p]
        away = _square_to(x, y, z, place, p)
        rising = last == p - 1 and before < away and node_curve[last] == k
        last, before = p, away
        if rising or away > reach[k] ** 2 + step[k] ** 2 or found == _TRIED:
            continue
        if not _is_lowest(x, y, z, place, p, first_node[k], first_node[k + 1], closed[k], away):
            continue
        s, t, away = _descend(
            x, y, z, heads, tails, segment[p], first_segment[k], first_segment[k + 1], closed[k]
        )
        if away >= reach[k] ** 2:
            continue
        r = found
        while r > 1 and square[r - 1] > away:
            node[r], on[r], along[r], square[r] = node[r - 1], on[r - 1], along[r - 1], square[r - 1]
            r -= 1
        node[r], on[r], along[r], square[r] = p, s, t, away
        found += 1
    return found


@njit(cache=True)
def _separation(heads, tails, on, along, i, j, way, least):  # type: ignore[no-untyped-def]
    """How far two feet on one curve, ``way`` apart along it, lie on different branches: from 0 to 1."""
    square = 0.0
    for e in range(3):
        a = heads[on[i], e] + along[i] * (tails[on[i], e] - heads[on[i], e])
        b = heads[on[j], e] + along[j] * (tails[on[j], e] - heads[on[j], e])
        square += (a - b) ** 2
    ratio = way / max(least, DETOUR * np.sqrt(square))
    return min(max((ratio - 1.0) / (FADE - 1.0), 0.0), 1.0)


@njit(cache=True)
def _segment_at(station, spans, low, high):  # type: ignore[no-untyped-def]
    """The segment among ``low`` to ``high`` on which a station lies, and the fraction along it."""
    s = low + max(np.searchsorted(spans[low:high, 0], station, "right") - 1, 0)
    return s, (station - spans[s, 0]) / max(spans[s, 1] - spans[s, 0], 1e-300)


@njit(cache=True)
def _search(  # type: ignore[no-untyped-def]
    points, sample, near, station, distance, heads, tails, spans, first_segment, first_node, closed,
    place, node_curve, segment, step, starts, partners, sigmas, cut,
):  # fmt: skip
    """Rows that have further feet, and the feet: row, curve, station, distance, branch, node."""
    most = MOST * sample.shape[0]
    rows, row = np.empty(sample.shape[0], np.int64), np.empty(most, np.int64)
    where, at = np.empty(most, np.int64), np.empty(most, np.int64)
    stations, away, branch = np.empty(most), np.empty(most), np.empty(most)
    node, on, along, square = (
        np.empty(_TRIED, np.int64), np.empty(_TRIED, np.int64), np.empty(_TRIED), np.empty(_TRIED)
    )  # fmt: skip
    s, apart = np.empty(_TRIED), np.empty(_TRIED)
    reach = cut * sigmas
    count, kept = 0, 0
    for a in range(sample.shape[0]):
        i = sample[a]
        found = _near_feet(
            points[i, 0], points[i, 1], points[i, 2], near[a], heads, tails, first_segment, first_node,
            closed, place, node_curve, segment, step, starts, partners, reach, node, on, along, square,
        )  # fmt: skip
        node[0], on[0], s[0], square[0], apart[0] = near[a], -1, station[i], distance[i] ** 2, 1.0
        used = 0
        for j in range(1, found):
            k = node_curve[node[j]]
            s[j] = spans[on[j], 0] + along[j] * (spans[on[j], 1] - spans[on[j], 0])
            apart[j] = 1.0
            for r in range(j):
                if apart[r] == 0.0 or node_curve[node[r]] != k:
                    continue
                way = abs(s[r] - s[j])
                if closed[k]:
                    way = min(way, spans[first_segment[k + 1] - 1, 1] - way)
                least = APART * sigmas[k]
                # The chord between two feet is no longer than the way over the sample.
                if way < FADE * max(least, DETOUR * (np.sqrt(square[r]) + np.sqrt(square[j]))):
                    if on[r] < 0:
                        on[r], along[r] = _segment_at(s[r], spans, first_segment[k], first_segment[k + 1])
                    apart[j] *= _separation(heads, tails, on, along, r, j, way, least)
            if apart[j] > 0.0 and used < MOST:
                row[kept], where[kept], stations[kept] = count, k, s[j]
                away[kept], branch[kept], at[kept] = np.sqrt(square[j]), apart[j], node[j]
                kept += 1
                used += 1
        if used > 0:
            rows[count] = a
            count += 1
    return rows[:count], row[:kept], where[:kept], stations[:kept], away[:kept], branch[:kept], at[:kept]
