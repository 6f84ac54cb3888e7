"""Samples as an image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["MARGIN", "Raster"]

Floats = NDArray[np.float64]

MARGIN = 24  # empty pixels around the samples: room for closing and blurring


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Numbers of samples in square pixels; rows along y.

    Attributes
    ----------
    counts : (rows, columns) array
    corner : (2,) array
        The corner of pixel (0, 0) that is the least in x and y.
    pixel : float
        Side of a pixel, in the units of the points.
    """

    counts: Floats
    corner: Floats
    pixel: float

    @classmethod
    def of(cls, points: Floats, pixel: float) -> Raster:
        """Count points, an (N, 2) array, in pixels of the given side."""
        corner = points.min(axis=0) - MARGIN * pixel
        place = np.floor((points - corner) / pixel).astype(np.int64)
        columns, rows = place.max(axis=0) + MARGIN + 1
        counts = np.bincount(place[:, 1] * columns + place[:, 0], minlength=rows * columns)
        return cls(counts.reshape(rows, columns).astype(np.float64), corner, pixel)

    def points(self, pixels: Floats) -> Floats:
        """Return the centres of pixels, (M, 2) rows and columns, in the units of the points."""
        return self.corner + (np.asarray(pixels, np.float64)[:, ::-1] + 0.5) * self.pixel
