"""Planes along a face of the object: what they cut is its noise, and no contour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Slice

__all__ = ["is_grazing"]

_SMALL = 0.05  # of the extent of a slice: rings of noise, of which each scan has its own
_TORTUOUS = 5.0  # times as long as the box around it is wide: a coast of noise
_MOSTLY = 0.2  # share of the samples in either


def is_grazing(one: Slice) -> bool:
    """Tell whether a plane runs through the noise of a face: polylines are small rings, or wander about."""
    if not len(one.points):
        return False
    limit = _SMALL * _extent(one.points)
    noisy = sum(
        len(line)
        for line, closed in zip(one.polylines, one.closed, strict=True)
        if (closed and _extent(line) < limit) or _length(line) > _TORTUOUS * _extent(line)
    )
    return noisy > _MOSTLY * len(one.points)


def _extent(points: NDArray[np.float64]) -> float:
    """Return the longest edge of the box around points."""
    return float(np.ptp(points, axis=0).max())


def _length(line: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
