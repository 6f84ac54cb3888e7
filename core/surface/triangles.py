"""Distances of points to triangles, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["approach"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit(cache=True)
def approach(
    points: Floats, some: Ints, corners: Floats, which: Ints, away: Floats, radius: float, best: Floats
) -> None:
    """Lower the distances ``best`` of points to those of some triangles.

    Parameters
    ----------
    points : (N, 3) array
    some : (S,) array of int
        The points that are looked at.
    corners : (T, 3, 3) array
    which : (S, K) array of int
        Triangles to try for each of them.
    away : (S, K) array
        Distances to their centres, ascending.
    radius : float
        No triangle reaches further from its centre.
    best : (N,) array
        Lowered in place.
    """
    for row in range(len(some)):
        k = some[row]
        for column in range(which.shape[1]):
            if away[row, column] - radius >= best[k]:
                break
            a, b, c = corners[which[row, column]]
            best[k] = min(best[k], _distance(points[k], a, b, c))


@njit(cache=True)
def _distance(p: Floats, a: Floats, b: Floats, c: Floats) -> float:
    """Distance of a point to a triangle: to its plane where the foot is inside, else to its edges."""
    nx, ny, nz = _cross(b - a, c - a)
    size = nx * nx + ny * ny + nz * nz
    inside = size > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        x, y, z = _cross(end - start, p - start)
        inside = inside and x * nx + y * ny + z * nz >= 0.0
    if inside:
        away = abs((p[0] - a[0]) * nx + (p[1] - a[1]) * ny + (p[2] - a[2]) * nz)
        return float(away / np.sqrt(size))
    return float(np.sqrt(min(_to_segment(p, a, b), _to_segment(p, b, c), _to_segment(p, c, a))))


@njit(cache=True)
def _cross(u: Floats, v: Floats) -> tuple[float, float, float]:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@njit(cache=True)
def _to_segment(p: Floats, a: Floats, b: Floats) -> float:
    """Square of the distance of a point to a segment."""
    length, along = 0.0, 0.0
    for k in range(3):
        length += (b[k] - a[k]) ** 2
        along += (p[k] - a[k]) * (b[k] - a[k])
    share = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0
    square = 0.0
    for k in range(3):
        square += (p[k] - a[k] - share * (b[k] - a[k])) ** 2
    return square
