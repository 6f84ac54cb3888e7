"""Oriented samples of meshes, spread over grids and read off them; compiled.

Coordinates are in cells of the grid: x, y, height. Grids have the height first, so that layers are
contiguous. A coarse grid has a node every ``ratio`` cells. No place may be outside, or on the border.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["add_divergence", "read", "samples_of", "spread", "subtract"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]

_ROOM = 1_000_000  # samples beyond two for each triangle
_STACK = 256  # parts of a triangle that wait: a few for each halving of its edges


def samples_of(vertices: Floats, faces: Ints, longest: float) -> tuple[Singles, Singles]:
    """Return centroids and area vectors of triangles, of parts of them where edges are long.

    Triangles are halved across their longest edge until none is longer than ``longest``. Where that would
    make too many parts for memory, they are larger by a power of two.

    Parameters
    ----------
    vertices : (V, 3) array
    faces : (F, 3) array
    longest : float

    Returns
    -------
    places, areas : (S, 3) arrays of float32
    """
    room = 2 * len(faces) + _ROOM
    places, areas = np.empty((room, 3), np.float32), np.empty((room, 3), np.float32)
    count = -1
    while count < 0:
        count = _split(vertices, faces, longest * longest, places, areas)
        longest *= 2.0
    return places[:count], areas[:count]


@njit(cache=True)
def _split(vertices, faces, most, places, areas):  # type: ignore[no-untyped-def]
    """Fill in the samples, and return how many there are; -1 where there is no room for them."""
    stack = np.empty((_STACK, 3, 3))
    count = 0
    for face in range(faces.shape[0]):
        for corner in range(3):
            for k in range(3):
                stack[0, corner, k] = vertices[faces[face, corner], k]
        waiting = 1
        while waiting:
            t = stack[waiting - 1]
            far, first = 0.0, 0
            for corner in range(3):
                after = (corner + 1) % 3
                square = 0.0
                for k in range(3):
                    square += (t[after, k] - t[corner, k]) ** 2
                if square > far:
                    far, first = square, corner
            if far > most and waiting < _STACK:
                after = (first + 1) % 3
                for k in range(3):
                    middle = 0.5 * (t[first, k] + t[after, k])
                    for corner in range(3):
                        stack[waiting, corner, k] = t[corner, k]
                    stack[waiting, first, k] = middle
                    t[after, k] = middle
                waiting += 1
                continue
            if count == places.shape[0]:
                return -1
            for k in range(3):
                p, q = (k + 1) % 3, (k + 2) % 3
                areas[count, k] = 0.5 * (
                    (t[1, p] - t[0, p]) * (t[2, q] - t[0, q]) - (t[1, q] - t[0, q]) * (t[2, p] - t[0, p])
                )
                places[count, k] = (t[0, k] + t[1, k] + t[2, k]) / 3.0
            count += 1
            waiting -= 1
    return count


@njit(cache=True)
def spread(places, amounts, ratio, grid):  # type: ignore[no-untyped-def]
    """Add amounts (S,) at places to the eight nodes around each of a coarse grid, trilinearly."""
    inverse = np.float32(1.0 / ratio)
    one = np.float32(1.0)
    for s in range(places.shape[0]):
        x, y, z = places[s, 0] * inverse, places[s, 1] * inverse, places[s, 2] * inverse
        i, j, k = int(x), int(y), int(z)
        x, y, z = x - np.float32(i), y - np.float32(j), z - np.float32(k)
        for dk in range(2):
            for dj in range(2):
                share = amounts[s] * (z if dk else one - z) * (y if dj else one - y)
                grid[k + dk, j + dj, i] += share * (one - x)
                grid[k + dk, j + dj, i + 1] += share * x


@njit(cache=True)
def read(places, ratio, grid):  # type: ignore[no-untyped-def]
    """Return the values of a coarse grid at places, trilinearly, shape (S,)."""
    inverse = np.float32(1.0 / ratio)
    one = np.float32(1.0)
    values = np.empty(places.shape[0], np.float32)
    for s in range(places.shape[0]):
        x, y, z = places[s, 0] * inverse, places[s, 1] * inverse, places[s, 2] * inverse
        i, j, k = int(x), int(y), int(z)
        x, y, z = x - np.float32(i), y - np.float32(j), z - np.float32(k)
        value = np.float32(0.0)
        for dk in range(2):
            for dj in range(2):
                row = grid[k + dk, j + dj, i] * (one - x) + grid[k + dk, j + dj, i + 1] * x
                value += row * (z if dk else one - z) * (y if dj else one - y)
        values[s] = value
    return values


@njit(cache=True)
def add_divergence(places, areas, grid):  # type: ignore[no-untyped-def]
    """Add the divergence of the field of all area vectors to the nodes of a fine grid.

    Each vector is a quadratic B-spline around its place, and the divergence is that of the splines,
    exactly: differences of nodes would have errors of their own.
    """
    half, most = np.float32(0.5), np.float32(0.75)
    spline, slope = np.empty((3, 3), np.float32), np.empty((3, 3), np.float32)
    node = np.empty(3, np.int64)
    for s in range(places.shape[0]):
        for axis in range(3):
            node[axis] = int(places[s, axis] + half)
            t = places[s, axis] - np.float32(node[axis])
            spline[axis, 0] = half * (half - t) * (half - t)
            spline[axis, 1] = most - t * t
            spline[axis, 2] = half * (half + t) * (half + t)
            slope[axis, 0], slope[axis, 1], slope[axis, 2] = half - t, t + t, -half - t
        i, j, k = node[0] - 1, node[1] - 1, node[2] - 1
        x, y, z = areas[s, 0], areas[s, 1], areas[s, 2]
        for dk in range(3):
            for dj in range(3):
                along = x * spline[1, dj] * spline[2, dk]
                across = y * slope[1, dj] * spline[2, dk] + z * spline[1, dj] * slope[2, dk]
                for di in range(3):
                    grid[k + dk, j + dj, i + di] += along * slope[0, di] + across * spline[0, di]


@njit(cache=True)
def subtract(coarse, ratio, grid):  # type: ignore[no-untyped-def]
    """Subtract a coarse grid from a fine one, trilinearly interpolated."""
    inverse = np.float32(1.0 / ratio)
    one = np.float32(1.0)
    row = np.empty(coarse.shape[2], np.float32)
    for k in range(grid.shape[0]):
        low, z = k // ratio, np.float32(k % ratio) * inverse
        for j in range(grid.shape[1]):
            near, y = j // ratio, np.float32(j % ratio) * inverse
            for i in range(row.shape[0]):
                below = (one - y) * coarse[low, near, i] + y * coarse[low, near + 1, i]
                above = (one - y) * coarse[low + 1, near, i] + y * coarse[low + 1, near + 1, i]
                row[i] = (one - z) * below + z * above
            for i in range(grid.shape[2]):
                left, x = i // ratio, np.float32(i % ratio) * inverse
                grid[k, j, i] -= (one - x) * row[left] + x * row[left + 1]
