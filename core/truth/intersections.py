"""Where polygonal curves cross, and how near their branches come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

__all__ = ["Crossings", "arc_lengths", "crossings", "separation"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Polyline = tuple[Floats, bool]

_AT_VERTEX = 1e-12  # of the extent: what rounding may do
_LOOK = 1e-6  # of the extent: how far along the curves to look whether they cross at a vertex


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

    def only(self, chosen: NDArray[np.bool_]) -> Crossings:
        """Return the crossings that a mask chooses."""
        return Crossings(self.locations[chosen], self.curves[chosen], self.positions[chosen])


def crossings(polylines: Sequence[Polyline]) -> Crossings:
    """Return every proper crossing of planar polygonal curves with themselves and with each other.

    Curves that touch at a vertex, or end on each other, do not cross there; a crossing at a vertex
    counts once; parallel overlaps do not count. Curves in space have no crossings.
    """
    if not polylines or polylines[0][0].shape[1] != 2:
        return Crossings(np.zeros((0, 2)), np.zeros((0, 2), np.int64), np.zeros((0, 2)))
    start, edge, curve, number = _edges(polylines)
    extent = float(np.ptp(start, axis=0).max())
    tree = shapely.STRtree(shapely.linestrings(np.stack((start, start + edge), axis=1)))
    first, second = tree.query(tree.geometries, predicate="dwithin", distance=_AT_VERTEX * extent)
    keep = first < second
    i, j = first[keep], second[keep]
    gap = start[j] - start[i]
    length = np.maximum(np.linalg.norm(edge, axis=1), 1e-300)
    rounding = _AT_VERTEX * extent / length
    det = _cross(edge[i], edge[j])
    det = np.where(np.abs(det) <= (rounding[i] + rounding[j]) * length[i] * length[j], np.nan, det)
    a, b = _cross(gap, edge[j]) / det, _cross(gap, edge[i]) / det
    beyond_a, beyond_b = np.abs(a - 0.5) - 0.5, np.abs(b - 0.5) - 0.5
    inside = (beyond_a <= rounding[i]) & (beyond_b <= rounding[j])
    sure = (beyond_a < -rounding[i]) & (beyond_b < -rounding[j])
    inside &= ~_adjacent(polylines, curve, number, i, j)
    i, j, a, b, sure = i[inside], j[inside], a[inside], b[inside], sure[inside]
    found = Crossings(
        start[i] + a[:, None] * edge[i],
        np.column_stack((curve[i], curve[j])),
        np.column_stack((number[i] + a, number[j] + b)),
    )
    return found.only(sure | _crossing_at_vertices(polylines, found, np.flatnonzero(~sure), _LOOK * extent))


def arc_lengths(vertices: Floats, closed: bool) -> Floats:
    """Return the arc length between every two vertices, the shorter way round when closed, shape (M, M)."""
    edges = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    s = np.concatenate(([0.0], np.cumsum(edges)))
    way: Floats = np.abs(s[:, None] - s[None, :])
    if closed:
        way = np.minimum(way, s[-1] + np.linalg.norm(vertices[0] - vertices[-1]) - way)
    return way


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
        apart = arc_lengths(vertices, closed) > 2 * chord
        np.fill_diagonal(apart, False)
        smallest = min(smallest, float(chord[apart].min(initial=np.inf)))
    return smallest


def _crossing_at_vertices(
    polylines: Sequence[Polyline], found: Crossings, doubtful: Ints, look: float
) -> NDArray[np.bool_]:
    """Tell which of the doubtful meetings, those at a vertex, are crossings; one of each place."""
    courses = [_Course.of(*one) for one in polylines]
    proper = np.zeros(len(found.locations), bool)
    seen: list[tuple[_Course, float, _Course, float]] = []
    for k in doubtful:
        one, other = (courses[c] for c in found.curves[k])
        s, t = (course.station(at) for course, at in zip((one, other), found.positions[k], strict=True))
        known = any(
            (one.is_near(s, a, u, look) and other.is_near(t, b, v, look))
            or (one.is_near(s, b, v, look) and other.is_near(t, a, u, look))
            for a, u, b, v in seen
        )
        if known or one.is_near(s, other, t, look):
            continue
        seen.append((one, s, other, t))
        arms, others = one.around(s, look), other.around(t, look)
        if arms is not None and others is not None:
            proper[k] = _interleave(arms - found.locations[k], others - found.locations[k])
    return proper


@dataclass(frozen=True, slots=True, eq=False)
class _Course:
    """A polyline by arc length; a closed one ends where it starts."""

    ring: Floats
    stations: Floats
    closed: bool

    @classmethod
    def of(cls, vertices: Floats, closed: bool) -> _Course:
        ring = np.vstack((vertices, vertices[:1])) if closed else vertices
        steps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
        return cls(ring, np.concatenate(([0.0], np.cumsum(steps))), closed)

    def station(self, position: float) -> float:
        """Arc length at an edge number plus fraction."""
        return float(np.interp(position, np.arange(len(self.stations)), self.stations))

    def is_near(self, s: float, other: _Course, t: float, look: float) -> bool:
        """Tell whether a station is as good as the same as one on a course."""
        gap = abs(s - t)
        return self is other and min(gap, self.stations[-1] - gap if self.closed else gap) < 3 * look

    def around(self, s: float, look: float) -> Floats | None:
        """Return the places so far before and after a station; None at an open end."""
        at = np.array([s - look, s + look])
        if self.closed:
            at %= self.stations[-1]
        elif at[0] < 0 or at[1] > self.stations[-1]:
            return None
        return np.column_stack([np.interp(at, self.stations, column) for column in self.ring.T])


def _interleave(arms: Floats, others: Floats) -> bool:
    """Tell whether exactly one of two other directions points between two directions."""
    angles = np.arctan2(*np.vstack((arms, others)).T[::-1])
    turn = (angles - angles[0]) % (2 * np.pi)
    return bool(np.sum(turn[2:] < turn[1]) == 1)


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
