"""How often the truth lies within the band that curves' standard errors draw about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from core.truth.metrics import true_points
from core.truth.point_sets import PointSet

__all__ = ["Banded", "Coverage", "coverage"]

Floats = NDArray[np.float64]
Banded = tuple[Floats, bool, Floats]

_SAMPLES = 2048  # places on all true curves together
_NEAREST = 4  # chords that may hold the foot


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """True places, equidistant along the curves, seen from the result; lengths in units of the points.

    Attributes
    ----------
    place : (K, d) array
        Those whose foot is not an open end of the result, nor has no standard error.
    distance : (K,) array
        To the nearest place on the result: normal to it.
    error : (K,) array
        Standard error there, interpolated between the vertices.
    """

    place: Floats
    distance: Floats
    error: Floats

    def share(self, factor: float = 2.0) -> float:
        """Share of the length that lies within ``factor`` standard errors; NaN for none."""
        inside = self.distance <= factor * self.error
        return float(np.mean(inside)) if len(inside) else float("nan")


def coverage(curves: Sequence[Banded], truth: PointSet) -> Coverage:
    """Compare the distance of the true curves from a result with its standard errors.

    Where the truth goes on beyond an open end of the result, its distance is not normal to the
    result: such places are left out.

    Parameters
    ----------
    curves : sequence of ((M, d) vertices, closed, (M,) standard errors)
        A closed curve does not repeat its first vertex; at least one curve.
    truth : PointSet

    Examples
    --------
    >>> from core.truth.point_sets import point_set
    >>> sample = point_set("circle", n=10)
    >>> band = [(one.vertices, one.closed, 1.0 + 0.0 * one.vertices[:, 0]) for one in sample.curves]
    >>> coverage(band, sample).share()
    1.0
    """
    places = true_points(truth.curves, _SAMPLES)
    heads, edges, low, high, first, last = (
        np.concatenate(a) for a in zip(*map(_chords, curves), strict=True)
    )
    _, near = KDTree(heads + edges / 2).query(places, k=min(_NEAREST, len(heads)))
    near = near.reshape(len(places), -1)
    square = np.maximum(np.einsum("ij,ij->i", edges, edges), 1e-300)
    along = np.einsum("ikj,ikj->ik", places[:, None] - heads[near], edges[near]) / square[near]
    along = np.clip(along, 0.0, 1.0)
    away = np.linalg.norm(places[:, None] - heads[near] - along[..., None] * edges[near], axis=2)
    best = np.arange(len(places)), np.argmin(away, axis=1)
    chord, t = near[best], along[best]
    error = (1.0 - t) * low[chord] + t * high[chord]
    beyond = (first[chord] & (t == 0.0)) | (last[chord] & (t == 1.0))
    kept = ~beyond & np.isfinite(error)
    return Coverage(places[kept], away[best][kept], error[kept])


def _chords(curve: Banded) -> tuple[NDArray[np.generic], ...]:
    """Heads, edges, errors at both ends, and whether a chord begins or ends an open curve.

    Edges are cut so finely that the nearest middles belong to the nearest chords.
    """
    vertices, closed, error = curve
    ring = np.vstack((vertices, vertices[:1])) if closed else vertices
    known = np.append(error, error[:1]) if closed else error
    way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))))
    way, kept = np.unique(way, return_index=True)
    at = np.unique(np.concatenate((way, np.linspace(0.0, way[-1], _SAMPLES))))
    x = np.column_stack([np.interp(at, way, column) for column in ring[kept].T])
    e = np.interp(at, way, known[kept])
    ends = np.zeros((2, len(at) - 1), np.bool_)
    ends[0, 0] = ends[1, -1] = not closed
    return x[:-1], np.diff(x, axis=0), e[:-1], e[1:], ends[0], ends[1]
