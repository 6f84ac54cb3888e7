"""Distances of points to triangles, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.surface.boxes import DEEP

__all__ = ["nearest"]

Floats = NDArray[np.float64]


@njit(cache=True)
def nearest(points: Floats, corners: Floats, tree: Floats) -> Floats:
    """Squares of the distances of points to the nearest of some triangles.

    Parameters
    ----------
    points : (N, 3) array
        Quickest where each lies near the one before.
    corners : (T, 3, 3) array
        Of the triangles, in the order of the tree's leaves; at least one.
    tree : (2 L, 2, 3) array
        Boxes around them (`core.surface.boxes`).
    """
    out = np.empty(len(points))
    leaves, last = len(tree) // 2, 0
    nodes, far = np.empty(DEEP, np.int64), np.empty(DEEP)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        best = _square(x, y, z, corners, last, np.inf)
        nodes[0], far[0], size = 1, 0.0, 1
        while size > 0:
            size -= 1
            if far[size] >= best:
                continue
            node = nodes[size]
            if node >= leaves:
                square = _square(x, y, z, corners, node - leaves, best)
                if square < best:
                    best, last = square, node - leaves
                continue
            one, other = _to_box(x, y, z, tree, 2 * node), _to_box(x, y, z, tree, 2 * node + 1)
            # The nearer child is looked at first: it is the last one in.
            first = 1 if one < other else 0
            nodes[size], far[size] = 2 * node + first, max(one, other)
            nodes[size + 1], far[size + 1] = 2 * node + 1 - first, min(one, other)
            size += 2
        out[i] = best
    return out


@njit(cache=True)
def _to_box(x: float, y: float, z: float, tree: Floats, node: int) -> float:
    """Square of the distance to a node's box; infinite for an empty one."""
    dx = _beyond(x, tree[node, 0, 0], tree[node, 1, 0])
    dy = _beyond(y, tree[node, 0, 1], tree[node, 1, 1])
    dz = _beyond(z, tree[node, 0, 2], tree[node, 1, 2])
    return dx * dx + dy * dy + dz * dz


@njit(cache=True)
def _beyond(x: float, low: float, high: float) -> float:
    return low - x if x < low else x - high if x > high else 0.0


@njit(cache=True)
def _square(x: float, y: float, z: float, corners: Floats, k: int, enough: float) -> float:
    """Square of the distance to a triangle, to its plane where the foot is inside, else to its edges.

    Where the plane is no nearer than ``enough``, that of the plane will do.
    """
    ax, ay, az = corners[k, 0, 0] - x, corners[k, 0, 1] - y, corners[k, 0, 2] - z
    bx, by, bz = corners[k, 1, 0] - x, corners[k, 1, 1] - y, corners[k, 1, 2] - z
    cx, cy, cz = corners[k, 2, 0] - x, corners[k, 2, 1] - y, corners[k, 2, 2] - z
    nx, ny, nz = _cross(bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az)
    size = nx * nx + ny * ny + nz * nz
    if size > 0.0:
        away = (ax * nx + ay * ny + az * nz) / np.sqrt(size)
        if away * away >= enough or (
            _beside(ax, ay, az, bx, by, bz, nx, ny, nz)
            and _beside(bx, by, bz, cx, cy, cz, nx, ny, nz)
            and _beside(cx, cy, cz, ax, ay, az, nx, ny, nz)
        ):
            return float(away * away)
    edges = _to_segment(ax, ay, az, bx, by, bz), _to_segment(bx, by, bz, cx, cy, cz)
    return float(min(edges[0], edges[1], _to_segment(cx, cy, cz, ax, ay, az)))


@njit(cache=True)
def _cross(ux, uy, uz, vx, vy, vz):  # type: ignore[no-untyped-def]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@njit(cache=True)
def _beside(ax, ay, az, bx, by, bz, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Whether the origin is on the inner side of the edge a b of a triangle with the normal n."""
    x, y, z = _cross(bx - ax, by - ay, bz - az, -ax, -ay, -az)
    return x * nx + y * ny + z * nz >= 0.0


@njit(cache=True)
def _to_segment(ax, ay, az, bx, by, bz):  # type: ignore[no-untyped-def]
    """Square of the origin's distance to a segment."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    length = ux * ux + uy * uy + uz * uz
    share = -(ax * ux + ay * uy + az * uz) / length if length > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    dx, dy, dz = ax + share * ux, ay + share * uy, az + share * uz
    return dx * dx + dy * dy + dz * dz
