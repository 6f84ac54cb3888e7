"""Edges that meet only at shared ends: crossings and contacts become nodes on the grid.

Edges of the same level are noded among themselves and with those of neighbouring levels, all
levels together: so neighbouring slabs cut the contour between them at the same places, and their
faces fit without T-junctions. Crossings are rounded to the grid, and an edge that runs through the
unit square around a node is led through the node; what the bent edges then meet is noded again, until
nothing is left (iterated snap rounding: Halperin and Packer 2002).
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from core.surface.linework import Linework, node_keys, without_doubles
from core.surface.pinches import cut_apart

__all__ = ["Unsettled", "noded"]

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

APART = 2**24  # grid units between the copies of neighbouring levels, for one search over all of them
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
        i, j = _neighbours(lines, new, reach)
        edge, point = _near_misses(lines.ends, i, j)
        cross = _cross(lines.ends, i, j)
        waiting = np.zeros(len(lines), np.bool_)
        if len(edge):
            # Edges led through nodes may cross no more: two that chase each other never would settle.
            waiting[i[cross]] = True
        else:
            edge, point = _crossings(lines.ends, i[cross], j[cross])
        lines, new = _split(lines, edge, point, waiting)
        kept = without_doubles(lines)
        lines, new = lines.taken(kept), new[kept]
        if len(lines) > (most or largest):
            break
    raise Unsettled


def _neighbours(lines: Linework, new: Bools, reach: int) -> tuple[Ints, Ints]:
    """Pairs of edges whose boxes meet, at least one of them new."""
    low, high = lines.ends.min(axis=1), lines.ends.max(axis=1) + 1
    shift = lines.level * APART
    boxes = shapely.box(low[:, 0] + shift, low[:, 1], high[:, 0] + shift, high[:, 1])
    tree = shapely.STRtree(boxes)
    asked = np.flatnonzero(new)
    low, high, shift = low[asked], high[asked], shift[asked]
    first, second = [], []
    for step in range(0 if new.all() else -reach, reach + 1):
        left, right = low[:, 0] + shift + step * APART, high[:, 0] + shift + step * APART
        i, j = tree.query(boxes[asked] if step == 0 else shapely.box(left, low[:, 1], right, high[:, 1]))
        i = asked[i]
        once = (i < j) | ~new[j] if step == 0 else (step > 0) | ~new[j]
        first.append(i[once])
        second.append(j[once])
    return np.concatenate(first), np.concatenate(second)


def _near_misses(ends: Ints, i: Ints, j: Ints) -> tuple[Ints, Ints]:
    """Edges of pairs, and the (M, 2) ends of the other that they run through strictly within."""
    edges, points = [], []
    for one, other in ((i, j), (j, i)):
        start, stop = ends[one, 0], ends[one, 1]
        for end in range(2):
            point = ends[other, end]
            near = _is_near(point, start, stop)
            near &= np.any(point != start, axis=1) & np.any(point != stop, axis=1)
            edges.append(one[near])
            points.append(point[near])
    return np.concatenate(edges), np.concatenate(points)


def _is_near(p: Ints, a: Ints, b: Ints) -> Bools:
    """Whether edges a b run through the unit squares around points, between their ends."""
    step = b - a
    along = ((p - a) * step).sum(axis=1)
    across: Bools = 2 * np.abs(_turn(a, b, p)) < np.abs(step).sum(axis=1)
    between: Bools = (along > 0) & (along < (step**2).sum(axis=1))
    return across & between


def _cross(ends: Ints, i: Ints, j: Ints) -> Bools:
    """Whether pairs of edges cross at a point that is no end."""
    a, b, c, d = ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]
    parts = np.sign(_turn(a, b, c)) * np.sign(_turn(a, b, d)) < 0
    parted: Bools = np.sign(_turn(c, d, a)) * np.sign(_turn(c, d, b)) < 0
    return parts & parted


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
