"""Where polygonal curves cross, and how near their branches come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

__all__ = ["Crossings", "crossings", "separation"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Polyline = tuple[Floats, bool]


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Proper crossings of polygonal curves.

    Attributes
    ----------
    locations : (K, 2) array
    curves : (K, 2) integer array
        The two curves that cross, the same one twice for a self-crossing.
    positions : (K, 2) array
        Position along each: edge number plus fraction of the edge.
    """

    locations: Floats
    curves: Ints
    positions: Floats


def crossings(polylines: Sequence[Polyline]) -> Crossings:
    """Return every proper crossing of planar polygonal curves with themselves and with each other.

    Edges are half-open, so that a crossing at a vertex counts once; parallel overlaps do not count.
    Curves in space have no crossings.
    """
    if not polylines or polylines[0][0].shape[1] != 2:
        return Crossings(np.zeros((0, 2)), np.zeros((0, 2), np.int64), np.zeros((0, 2)))
    start, edge, curve, number = _edges(polylines)
    tree = shapely.STRtree(shapely.linestrings(np.stack((start, start + edge), axis=1)))
    first, second = tree.query(tree.geometries, predicate="intersects")
    keep = first < second
    i, j = first[keep], second[keep]
    gap = start[j] - start[i]
    det = _cross(edge[i], edge[j])
    det = np.where(det == 0, np.nan, det)
    a, b = _cross(gap, edge[j]) / det, _cross(gap, edge[i]) / det
    inside = (a >= 0) & (a < 1) & (b >= 0) & (b < 1) & ~_adjacent(polylines, curve, number, i, j)
    i, j, a, b = i[inside], j[inside], a[inside], b[inside]
    places = np.column_stack((number[i] + a, number[j] + b))
    return Crossings(start[i] + a[:, None] * edge[i], np.column_stack((curve[i], curve[j])), places)


def separation(polylines: Sequence[Polyline]) -> float:
    """Return the smallest distance between two branches, in the units of the vertices.

    Two vertices are on different branches when they are on different curves, or when the way between
    them along their curve is more than twice the chord (on a circle that is the diameter).
    """
    smallest = np.inf
    for k, (vertices, closed) in enumerate(polylines):
        for other, _ in polylines[k + 1 :]:
            smallest = min(smallest, float(cdist(vertices, other).min()))
        chord = cdist(vertices, vertices)
        apart = _way(vertices, closed) > 2 * chord
        np.fill_diagonal(apart, False)
        smallest = min(smallest, float(chord[apart].min(initial=np.inf)))
    return smallest


def _way(vertices: Floats, closed: bool) -> Floats:
    """Arc length between every two vertices, the shorter way round when closed."""
    edges = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    s = np.concatenate(([0.0], np.cumsum(edges)))
    way: Floats = np.abs(s[:, None] - s[None, :])
    if closed:
        way = np.minimum(way, s[-1] + np.linalg.norm(vertices[0] - vertices[-1]) - way)
    return way


def _edges(polylines: Sequence[Polyline]) -> tuple[Floats, Floats, Ints, Ints]:
    """Start and vector of all edges, with the curve and the number that each has on it."""
    starts, vectors, curve, number = [], [], [], []
    for k, (vertices, closed) in enumerate(polylines):
        ring = np.vstack((vertices, vertices[:1])) if closed else vertices
        starts.append(ring[:-1])
        vectors.append(np.diff(ring, axis=0))
        curve.append(np.full(len(ring) - 1, k, np.int64))
        number.append(np.arange(len(ring) - 1, dtype=np.int64))
    return np.concatenate(starts), np.concatenate(vectors), np.concatenate(curve), np.concatenate(number)


def _adjacent(
    polylines: Sequence[Polyline], curve: Ints, number: Ints, i: Ints, j: Ints
) -> NDArray[np.bool_]:
    """Tell which pairs of edges are neighbours on one curve."""
    count = np.array([len(v) if closed else -9 for v, closed in polylines])
    step = np.abs(number[i] - number[j])
    neighbours = (step <= 1) | (step == count[curve[i]] - 1)
    return np.asarray((curve[i] == curve[j]) & neighbours)


def _cross(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
