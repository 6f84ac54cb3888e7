"""Edges that meet only at shared ends: crossings and contacts become nodes on the grid.

Edges of the same level are noded among themselves and with those of neighbouring levels, all
levels together: so neighbouring slabs cut the contour between them at the same places, and their
faces fit without T-junctions. Crossings are rounded to the grid, and an edge that runs through the
unit square around a node is led through the node; what the bent edges then meet is noded again, until
nothing is left (iterated snap rounding: Halperin and Packer 2002).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.surface.boxes import DEEP
from core.surface.linework import Linework, boxes_of, node_keys, without_doubles
from core.surface.pinches import cut_apart

__all__ = ["Unsettled", "noded"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

CROSS = 2  # neither end of an edge
MOST_ROUNDS = 100
GROWTH = 8  # times the edges noded: more come of cutting regions apart in vain
MOST_NODES = 8  # times the edges, or
FEW = 300_000  # edges at least: more come of nodes that pass from level to level along upright walls


class Unsettled(Exception):
    """Rounding crossings to the grid went on making new ones, or regions went on touching themselves."""


def noded(lines: Linework, reach: int = 1) -> Linework:
    """The same borders, split where they meet; no border touches itself.

    Parameters
    ----------
    lines : Linework
    reach : int
        Levels that are at most so far apart are noded with each other.

    Raises
    ------
    Unsettled
        After many rounds something is still left.
    """
    lines = lines.taken(without_doubles(lines))
    new, attempt, most = np.ones(len(lines), np.bool_), 0, 0
    largest = max(MOST_NODES * len(lines), FEW)
    for _ in range(MOST_ROUNDS):
        if not new.any():
            most = most or GROWTH * len(lines)
            lines, new = cut_apart(lines, attempt)
            attempt += 1
            if not new.any():
                return lines
        one, other, kind = _meetings(lines.ends, lines.level, new, *boxes_of(lines), reach).T
        near, cross = kind != CROSS, kind == CROSS
        waiting = np.zeros(len(lines), np.bool_)
        if near.any():
            # Edges led through nodes may cross no more: two that chase each other never would settle.
            waiting[one[cross]] = True
            edge, point = one[near], lines.ends[other[near], kind[near]]
        else:
            edge, point = _crossings(lines.ends, one, other)
        lines, new = _split(lines, edge, point, waiting)
        kept = without_doubles(lines)
        lines, new = lines.taken(kept), new[kept]
        if len(lines) > (most or largest):
            break
    raise Unsettled


@njit(cache=True)
def _meetings(ends: Ints, level: Ints, new: Bools, tree: Floats, order: Ints, reach: int) -> Ints:
    """Rows of two edges, of which one is new, and how they meet.

    0 or 1: the first one runs through that end of the other, strictly within; CROSS: they cross at a
    point that is no end, the first one being of the lower level or, of the same, the one listed first.
    """
    rows, count = np.empty((1024, 3), np.int64), 0
    leaves, stack = len(tree) // 2, np.empty(DEEP, np.int64)
    all_new = np.all(new)
    for leaf in range(leaves, leaves + len(order)):
        i, here = order[leaf - leaves], leaf
        while here > 1 and new[i]:
            # What lies beside the way from the leaf to the root; to the left of it, new ones have
            # been there.
            stack[0], size = here ^ 1, 1 - (here % 2 if all_new else 0)
            here //= 2
            while size > 0:
                size -= 1
                node = stack[size]
                if _apart(tree, leaf, node, reach):
                    continue
                if node < leaves:
                    stack[size], stack[size + 1] = 2 * node, 2 * node + 1
                    size += 2
                    continue
                j = order[node - leaves]
                if node > leaf or not new[j]:
                    if count + 5 > len(rows):
                        rows = np.concatenate((rows, np.empty_like(rows)))
                    count = _listed(ends, i, j, (level[i], i) < (level[j], j), rows, count)
    return rows[:count]


@njit(cache=True)
def _listed(ends: Ints, i: int, j: int, ordered: bool, rows: Ints, count: int) -> int:
    """Add how two edges meet to the rows; returns their number."""
    for one, other in ((i, j), (j, i)):
        for end in range(2):
            if _is_near(ends, other, end, one):
                rows[count, 0], rows[count, 1], rows[count, 2] = one, other, end
                count += 1
    if _parted(ends, i, j) and _parted(ends, j, i):
        first, second = (i, j) if ordered else (j, i)
        rows[count, 0], rows[count, 1], rows[count, 2] = first, second, CROSS
        count += 1
    return count


@njit(cache=True)
def _apart(tree: Floats, a: int, b: int, reach: int) -> bool:
    """Whether boxes are more than a grid unit apart, or more than ``reach`` levels."""
    return bool(
        tree[a, 0, 0] > tree[b, 1, 0] + 1
        or tree[b, 0, 0] > tree[a, 1, 0] + 1
        or tree[a, 0, 1] > tree[b, 1, 1] + 1
        or tree[b, 0, 1] > tree[a, 1, 1] + 1
        or tree[a, 0, 2] > tree[b, 1, 2] + reach
        or tree[b, 0, 2] > tree[a, 1, 2] + reach
    )


@njit(cache=True)
def _is_near(ends: Ints, other: int, end: int, edge: int) -> bool:
    """Whether an edge runs through the unit square around an end of another, between its own ends."""
    ax, ay = ends[edge, 0, 0], ends[edge, 0, 1]
    dx, dy = ends[edge, 1, 0] - ax, ends[edge, 1, 1] - ay
    px, py = ends[other, end, 0] - ax, ends[other, end, 1] - ay
    if (px == 0 and py == 0) or (px == dx and py == dy):
        return False
    along = px * dx + py * dy
    return bool(2 * abs(dx * py - dy * px) < abs(dx) + abs(dy) and 0 < along < dx * dx + dy * dy)


@njit(cache=True)
def _parted(ends: Ints, edge: int, other: int) -> bool:
    """Whether an edge's line has the other's ends on different sides."""
    ax, ay = ends[edge, 0, 0], ends[edge, 0, 1]
    dx, dy = ends[edge, 1, 0] - ax, ends[edge, 1, 1] - ay
    first = dx * (ends[other, 0, 1] - ay) - dy * (ends[other, 0, 0] - ax)
    second = dx * (ends[other, 1, 1] - ay) - dy * (ends[other, 1, 0] - ax)
    return bool((first > 0 and second < 0) or (first < 0 and second > 0))


def _crossings(ends: Ints, i: Ints, j: Ints) -> tuple[Ints, Ints]:
    """Crossing edges, and the (M, 2) grid points next to the crossings."""
    a, b, c, d = ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]
    before, after = _turn(c, d, a), _turn(c, d, b)
    point = a + np.rint((before / (before - after))[:, None] * (b - a)).astype(np.int64)
    edge, point = np.concatenate((i, j)), np.concatenate((point, point))
    inner = np.any(point != ends[edge, 0], axis=1) & np.any(point != ends[edge, 1], axis=1)
    return edge[inner], point[inner]


def _turn(a: Ints, b: Ints, c: Ints) -> Ints:
    """Twice the signed area of triangles a b c."""
    u, v = b - a, c - a
    area: Ints = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return area


def _split(lines: Linework, edge: Ints, point: Ints, waiting: Bools) -> tuple[Linework, Bools]:
    """The edges with those split that have nodes, and which to look at next: new and waiting ones."""
    if not len(edge):
        return lines, waiting
    _, once = np.unique(np.column_stack((edge, node_keys(point))), axis=0, return_index=True)
    edge, point = edge[once], point[once]
    whole = np.ones(len(lines), np.bool_)
    whole[edge] = False
    cut = np.flatnonzero(~whole)
    start, stop = lines.ends[edge, 0], lines.ends[edge, 1]
    along = ((point - start) * (stop - start)).sum(axis=1)
    # The ends come first and last, wherever rounding has moved a node beyond them.
    owner = np.concatenate((cut, edge, cut))
    rank = np.concatenate((np.zeros(len(cut)), np.ones(len(edge)), np.full(len(cut), 2.0)))
    order = np.lexsort((np.concatenate((0 * cut, along, 0 * cut)), rank, owner))
    chain = np.concatenate((lines.ends[cut, 0], point, lines.ends[cut, 1]))[order]
    owner = owner[order]
    step = np.flatnonzero(owner[1:] == owner[:-1])
    pieces = lines.taken(owner[step])
    pieces = Linework(np.stack((chain[step], chain[step + 1]), axis=1), pieces.level, pieces.gated)
    kept = lines.taken(whole)
    return kept.joined(pieces), np.append(waiting[whole], np.ones(len(pieces), np.bool_))
