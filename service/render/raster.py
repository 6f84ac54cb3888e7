"""Triangles to pixels, the nearest in front. Compiled: whoever asks for no such picture imports no numba."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["fill"]

Floats = NDArray[np.float64]

_EDGE = -1e-9  # a pixel on the edge of two triangles belongs to at least one of them


@njit(cache=True)
def fill(corners: Floats, values: Floats, depth: Floats, image: Floats) -> None:
    """Draw triangles into an image, whose values are interpolated between the corners'.

    Parameters
    ----------
    corners : (F, 3, 3) array
        Column, row and nearness of each corner, in pixels; pixel (i, j) is the square from (j, i) on.
    values : (F, 3) array
        Of each corner. Triangles seen from behind (clockwise) have them negated.
    depth, image : (H, W) arrays
        Nearness and value of what is seen; written where a triangle is nearer.
    """
    height, width = depth.shape
    for f in range(len(corners)):
        x0, y0, z0 = corners[f, 0]
        x1, y1, z1 = corners[f, 1]
        x2, y2, z2 = corners[f, 2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        side = 1.0 if area > 0.0 else -1.0
        first_row = max(0, int(np.ceil(min(y0, y1, y2) - 0.5)))
        last_row = min(height - 1, int(np.floor(max(y0, y1, y2) - 0.5)))
        first_column = max(0, int(np.ceil(min(x0, x1, x2) - 0.5)))
        last_column = min(width - 1, int(np.floor(max(x0, x1, x2) - 0.5)))
        for i in range(first_row, last_row + 1):
            y = i + 0.5
            for j in range(first_column, last_column + 1):
                x = j + 0.5
                a = ((x1 - x) * (y2 - y) - (x2 - x) * (y1 - y)) / area
                b = ((x2 - x) * (y0 - y) - (x0 - x) * (y2 - y)) / area
                c = 1.0 - a - b
                if a < _EDGE or b < _EDGE or c < _EDGE:
                    continue
                z = a * z0 + b * z1 + c * z2
                if z > depth[i, j]:
                    depth[i, j] = z
                    image[i, j] = side * (a * values[f, 0] + b * values[f, 1] + c * values[f, 2])
