"""Signed distances from the borders of levels' regions, compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.surface.boxes import DEEP
from core.surface.linework import Linework, boxes_of

__all__ = ["Borders", "signed_distances"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """The borders of all levels, made for measuring distances from them.

    Attributes
    ----------
    ends : (E, 2, 2) array
        Edges, in the order of the tree's leaves.
    tree : (2 L, 2, 3) array
        Boxes around them (`core.surface.boxes`), each at the height of its level's number.
    """

    ends: Floats
    tree: Floats

    @classmethod
    def of(cls, lines: Linework) -> Borders:
        """Those of linework that is not empty."""
        tree, order = boxes_of(lines)
        return cls(lines.ends[order].astype(np.float64), tree)


def signed_distances(xy: Floats, level: Ints, borders: Borders) -> Floats:
    """Distances (M,) of (M, 2) places from the borders of levels, positive inside.

    ``level`` is that of each place, -1 for none. Minus infinity where there is no level or no border.
    """
    return _signed_distances(
        np.ascontiguousarray(xy), np.ascontiguousarray(level), borders.ends, borders.tree
    )


@njit(cache=True)
def _signed_distances(xy: Floats, level: Ints, ends: Floats, tree: Floats) -> Floats:
    out, leaves = np.full(len(xy), -np.inf), len(tree) // 2
    nodes, far = np.empty(DEEP, np.int64), np.empty(DEEP)
    for i in range(len(xy)):
        if level[i] < 0:
            continue
        x, y, best = xy[i, 0], xy[i, 1], np.inf
        nodes[0], far[0], size = 1, 0.0, 1
        while size > 0:
            size -= 1
            node = nodes[size]
            if far[size] >= best:
                continue
            if node >= leaves:
                best = min(best, _to_edge(x, y, ends[node - leaves]))
                continue
            one, other = _to_box(x, y, level[i], tree, 2 * node), _to_box(x, y, level[i], tree, 2 * node + 1)
            # The nearer child is looked at first: it is the last one in.
            first = 1 if one < other else 0
            nodes[size], far[size] = 2 * node + first, max(one, other)
            nodes[size + 1], far[size + 1] = 2 * node + 1 - first, min(one, other)
            size += 2
        out[i] = np.sqrt(best) if _is_inside(x, y, level[i], ends, tree, nodes) else -np.sqrt(best)
    return out


@njit(cache=True)
def _to_box(x: float, y: float, level: int, tree: Floats, node: int) -> float:
    """Square of the distance to a node's box; infinite where it has no edge of the level."""
    if not tree[node, 0, 2] <= level <= tree[node, 1, 2]:
        return np.inf
    dx = max(tree[node, 0, 0] - x, x - tree[node, 1, 0], 0.0)
    dy = max(tree[node, 0, 1] - y, y - tree[node, 1, 1], 0.0)
    return float(dx * dx + dy * dy)


@njit(cache=True)
def _to_edge(x: float, y: float, edge: Floats) -> float:
    """Square of the distance to an edge."""
    ax, ay = edge[0, 0] - x, edge[0, 1] - y
    ux, uy = edge[1, 0] - edge[0, 0], edge[1, 1] - edge[0, 1]
    t = min(1.0, max(0.0, -(ax * ux + ay * uy) / (ux * ux + uy * uy)))
    px, py = ax + t * ux, ay + t * uy
    return float(px * px + py * py)


@njit(cache=True)
def _is_inside(x: float, y: float, level: int, ends: Floats, tree: Floats, nodes: Ints) -> bool:
    """Whether a ray along x crosses a level's border an odd number of times."""
    inside, leaves = False, len(tree) // 2
    nodes[0], size = 1, 1
    while size > 0:
        size -= 1
        node = nodes[size]
        level_is_there = tree[node, 0, 2] <= level <= tree[node, 1, 2]
        if not level_is_there or tree[node, 1, 0] < x or not tree[node, 0, 1] <= y < tree[node, 1, 1]:
            continue
        if node < leaves:
            nodes[size], nodes[size + 1] = 2 * node, 2 * node + 1
            size += 2
            continue
        edge = ends[node - leaves]
        ax, ay, bx, by = edge[0, 0] - x, edge[0, 1] - y, edge[1, 0] - x, edge[1, 1] - y
        if (ay > 0.0) != (by > 0.0) and (ax * by - ay * bx > 0.0) == (by > ay):
            inside = not inside
    return inside
