"""Where piecewise-linear curves in a plane cross themselves and each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["Meeting", "crossings"]


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A proper crossing: its place (3,), the two curves (or one twice), the angle in degrees."""

    place: NDArray[np.float64]
    curves: tuple[int, int]
    angle: float


def crossings(curves: Sequence[Polyline]) -> list[Meeting]:
    """Find every proper crossing of curves in the plane z = 0.

    Edges are half-open, so that a crossing at a vertex counts once; parallel overlaps and
    the common vertex of neighbouring edges do not count.

    Parameters
    ----------
    curves : sequence of Polyline
    """
    if not curves:
        return []
    curves = [Polyline(_distinct(line), line.closed) for line in curves]
    heads, tails = (
        np.concatenate(part)[:, :2] for part in zip(*(line.segments() for line in curves), strict=True)
    )
    sizes = [len(line.ring) - 1 for line in curves]
    curve = np.repeat(np.arange(len(curves)), sizes)
    number = np.concatenate([np.arange(size) for size in sizes])
    tree = shapely.STRtree(shapely.linestrings(np.stack([heads, tails], axis=1)))
    i, j = tree.query(tree.geometries, predicate="intersects")
    size = np.array(sizes)[curve]
    step = np.abs(number[i] - number[j])
    step = np.where(
        np.array([line.closed for line in curves])[curve[i]], np.minimum(step, size[i] - step), step
    )
    keep = (i < j) & ~((curve[i] == curve[j]) & (step <= 1))
    i, j = i[keep], j[keep]
    u, w = tails[i] - heads[i], tails[j] - heads[j]
    gap = heads[j] - heads[i]
    det = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
    det = np.where(det == 0.0, np.nan, det)
    a = (gap[:, 0] * w[:, 1] - gap[:, 1] * w[:, 0]) / det
    b = (gap[:, 0] * u[:, 1] - gap[:, 1] * u[:, 0]) / det
    inside = (a >= 0.0) & (a < 1.0) & (b >= 0.0) & (b < 1.0)
    norms = np.linalg.norm(u, axis=1) * np.linalg.norm(w, axis=1)
    along = np.abs(np.einsum("ij,ij->i", u, w)) / np.maximum(norms, 1e-300)
    angle = np.degrees(np.arccos(np.minimum(along, 1.0)))
    place = heads[i] + a[:, None] * u
    return [
        Meeting(np.append(place[k], 0.0), (int(curve[i[k]]), int(curve[j[k]])), float(angle[k]))
        for k in np.flatnonzero(inside)
    ]


def _distinct(line: Polyline) -> NDArray[np.float64]:
    """Vertices without repetitions, which would make edges of no length; at least two remain."""
    x = line.vertices
    moved = np.append(True, np.any(x[1:] != x[:-1], axis=1))
    if line.closed and moved.sum() > 2 and not np.any(x[0] != x[moved][-1]):
        moved[np.flatnonzero(moved)[-1]] = False
    return np.asarray(x[moved])
