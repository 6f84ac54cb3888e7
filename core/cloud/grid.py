"""A uniform grid of buckets over a point set: ball and strip queries in linear time.

The points are kept sorted by cell, so that a query reads contiguous memory. The grid is a
named tuple, which compiled kernels take as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["Grid", "build_grid", "cell_range"]

_CELLS_PER_POINT = 4
_LEAST_CELLS = 4096


class Grid(NamedTuple):
    """Points sorted by cell.

    Attributes
    ----------
    points : (N, 3) array
        The points in the order of their cells.
    order : (N,) array
        ``points[i]`` is the input's point ``order[i]``.
    starts : (cells + 1,) array
        Cell ``c`` holds ``points[starts[c]:starts[c + 1]]``.
    origin : (3,) array
    cell : float
        Edge length of a cell.
    shape : (3,) array of int
    """

    points: NDArray[np.float64]
    order: NDArray[np.int64]
    starts: NDArray[np.int64]
    origin: NDArray[np.float64]
    cell: float
    shape: NDArray[np.int64]


def build_grid(points: NDArray[np.float64], cell: float) -> Grid:
    """Sort points into cells of edge ``cell``, or larger where cells would outnumber the points.

    Parameters
    ----------
    points : (N, 3) array
    cell : float
        Wished edge length; must be positive.
    """
    low = points.min(axis=0)
    extent = points.max(axis=0) - low
    cell = _affordable(extent, cell, max(_LEAST_CELLS, _CELLS_PER_POINT * len(points)))
    shape = (extent / cell).astype(np.int64) + 1
    order, starts = _sort_into_cells(points, low, cell, shape)
    return Grid(points[order], order, starts, low, cell, shape)


def _affordable(extent: NDArray[np.float64], cell: float, limit: int) -> float:
    """Enlarge the cell until at most about ``limit`` cells cover the extent."""
    if not cell > 0.0:
        cell = max(float(extent.max()), 1.0) * 1e-9
    while np.prod(extent / cell + 1.0) > limit:
        cell *= 1.25
    return cell


@njit(cache=True)
def _sort_into_cells(points, origin, cell, shape):  # type: ignore[no-untyped-def]
    """Counting sort of the points by cell, rows major."""
    n = points.shape[0]
    keys = np.empty(n, np.int64)
    starts = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    inverse = 1.0 / cell
    for i in range(n):
        ix = min(int((points[i, 0] - origin[0]) * inverse), shape[0] - 1)
        iy = min(int((points[i, 1] - origin[1]) * inverse), shape[1] - 1)
        iz = min(int((points[i, 2] - origin[2]) * inverse), shape[2] - 1)
        keys[i] = (ix * shape[1] + iy) * shape[2] + iz
        starts[keys[i] + 1] += 1
    for c in range(starts.shape[0] - 1):
        starts[c + 1] += starts[c]
    order = np.empty(n, np.int64)
    cursor = starts[:-1].copy()
    for i in range(n):
        order[cursor[keys[i]]] = i
        cursor[keys[i]] += 1
    return order, starts


@njit(cache=True, inline="always")
def cell_range(low, high, origin, cell, size):  # type: ignore[no-untyped-def]
    """Range of cell indices along one axis that covers [low, high]; empty when outside."""
    first = max(int(np.floor((low - origin) / cell)), 0)
    last = min(int(np.floor((high - origin) / cell)), size - 1)
    return first, last
