"""Implicit functions of solids: negative inside, positive outside, zero on the surface.

Values are distances, or nearly so, near the surface, and never grow faster than distances by
much. Unions and differences are blended over a width, twice continuously differentiable, so that
the surfaces are smooth.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Field", "ball", "capsule", "carved", "ellipsoid", "gradient", "moved", "ring", "union"]

Floats = NDArray[np.float64]
Field = Callable[[Floats], Floats]


def ball(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> Field:
    """Return the distance to a sphere."""
    middle = np.asarray(centre, np.float64)
    return lambda p: _length(p - middle) - radius


def ellipsoid(radii: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)) -> Field:
    """Return the distance to an ellipsoid with axes along x, y and z, to first order."""
    half, middle = np.asarray(radii, np.float64), np.asarray(centre, np.float64)

    def field(p: Floats) -> Floats:
        scaled = (p - middle) / half
        size = _length(scaled)
        steepness = _length(scaled / half)
        deep = size < 0.3  # about the centre the first order is no distance: a smaller ball does as well
        return np.where(deep, (size - 1.0) * half.min(), size * (size - 1.0) / np.where(deep, 1.0, steepness))

    return field


def ring(major: float, minor: float, centre: ArrayLike = (0.0, 0.0, 0.0), axis: int = 2) -> Field:
    """Return the distance to a torus about a coordinate axis."""
    middle = np.asarray(centre, np.float64)
    plane = [k for k in range(3) if k != axis]

    def field(p: Floats) -> Floats:
        q = p - middle
        return np.asarray(np.hypot(np.hypot(q[:, plane[0]], q[:, plane[1]]) - major, q[:, axis]) - minor)

    return field


def capsule(start: ArrayLike, end: ArrayLike, radius: float) -> Field:
    """Return the distance to a rod with round ends."""
    first = np.asarray(start, np.float64)
    way = np.asarray(end, np.float64) - first

    def field(p: Floats) -> Floats:
        along = np.clip((p - first) @ way / (way @ way), 0.0, 1.0)
        return _length(p - first - along[:, None] * way) - radius

    return field


def union(*parts: Field, blend: float = 0.0) -> Field:
    """Return the union of solids, blended over a width."""

    def field(p: Floats) -> Floats:
        result = parts[0](p)
        for part in parts[1:]:
            result = _least(result, part(p), blend)
        return result

    return field


def carved(solid: Field, *tools: Field, blend: float) -> Field:
    """Return what is left of a solid when others are taken away, blended over a width."""

    def field(p: Floats) -> Floats:
        result = solid(p)
        for tool in tools:
            result = -_least(-result, tool(p), blend)
        return result

    return field


def moved(field: Field, offset: ArrayLike) -> Field:
    """Return a solid moved by an offset."""
    shift = np.asarray(offset, np.float64)
    return lambda p: field(p - shift)


def gradient(field: Field, points: Floats, step: float) -> Floats:
    """Return the gradient of a field at (N, 3) points, by central differences over a step."""
    columns = [(field(points + axis) - field(points - axis)) / (2.0 * step) for axis in step * np.eye(3)]
    return np.stack(columns, axis=1)


def _length(vectors: Floats) -> Floats:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _least(one: Floats, other: Floats, blend: float) -> Floats:
    """Return the smaller value, rounded by a cubic where the two differ by less than ``blend``."""
    if blend == 0.0:
        return np.asarray(np.minimum(one, other))
    overlap = np.maximum(blend - np.abs(one - other), 0.0) / blend
    return np.asarray(np.minimum(one, other) - blend / 6.0 * overlap**3)
