"""Where piecewise-linear curves in a plane cross themselves and each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["Meeting", "crossings"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ROUNDING = 1e-12  # of the extent: places nearer than this are one
SECTOR = 1e-9  # in radians: curves that leave in directions nearer than this run along each other


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A proper crossing.

    Attributes
    ----------
    place : (3,) array
    curves : (int, int)
        The two curves, or one twice.
    angle : float
        In degrees, 0 to 90.
    stations : (float, float)
        Arc length of the place on each of the two.
    """

    place: Floats
    curves: tuple[int, int]
    angle: float
    stations: tuple[float, float]


def crossings(curves: Sequence[Polyline]) -> list[Meeting]:
    """Find every proper crossing of curves in the plane z = 0.

    A crossing in a vertex counts once, and only when one curve really changes sides of the other:
    a curve that touches another, ends on it or runs along it does not cross it.

    Parameters
    ----------
    curves : sequence of Polyline
    """
    if not curves:
        return []
    edges = _Edges.of(curves)
    hits = _hits(edges)
    return _meetings(edges, *hits) if len(hits[0]) else []


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """All edges of all curves.

    ``number`` is the place of an edge on its curve of ``size`` edges and ``first`` the index of that
    curve's first edge; ``station`` the arc length at its head.
    """

    head: Floats
    step: Floats
    length: Floats
    station: Floats
    curve: Ints
    number: Ints
    size: Ints
    first: Ints
    closed: NDArray[np.bool_]
    near: float

    @classmethod
    def of(cls, curves: Sequence[Polyline]) -> _Edges:
        near = ROUNDING * max((float(np.ptp(line.vertices, axis=0).max()) for line in curves), default=0.0)
        kept = [_distinct(line, near) for line in curves]
        rings = [line.vertices[_wrapped(line, keep)] for line, keep in zip(curves, kept, strict=True)]
        sizes = np.array([len(ring) - 1 for ring in rings])
        station = [line.stations[keep][:size] for line, keep, size in zip(curves, kept, sizes, strict=True)]
        step = np.concatenate([np.diff(ring[:, :2], axis=0) for ring in rings])
        curve = np.repeat(np.arange(len(curves)), sizes)
        first = (np.cumsum(sizes) - sizes)[curve]
        return cls(
            head=np.concatenate([ring[:-1, :2] for ring in rings]),
            step=step,
            length=np.linalg.norm(step, axis=1),
            station=np.concatenate(station),
            curve=curve,
            number=np.arange(len(curve)) - first,
            size=sizes[curve],
            first=first,
            closed=np.array([line.closed for line in curves])[curve],
            near=near,
        )


def _hits(edges: _Edges) -> tuple[Ints, Ints, Floats, Floats]:
    """Pairs of edges that meet, and the fractions of them where they do."""
    segments = shapely.linestrings(np.stack([edges.head, edges.head + edges.step], axis=1))
    tree = shapely.STRtree(segments)
    i, j = tree.query(segments, predicate="intersects")
    apart = np.abs(edges.number[i] - edges.number[j])
    apart = np.where(edges.closed[i], np.minimum(apart, edges.size[i] - apart), apart)
    keep = (i < j) & ~((edges.curve[i] == edges.curve[j]) & (apart <= 1))
    i, j = i[keep], j[keep]
    u, w, gap = edges.step[i], edges.step[j], edges.head[j] - edges.head[i]
    det = _cross(u, w)
    a, b = (_cross(gap, side) / np.where(det == 0.0, np.nan, det) for side in (w, u))
    met = np.isfinite(a) & np.isfinite(b)
    # The predicate is exact, the fractions are not.
    return i[met], j[met], np.clip(a[met], 0.0, 1.0), np.clip(b[met], 0.0, 1.0)


def _meetings(edges: _Edges, i: Ints, j: Ints, a: Floats, b: Floats) -> list[Meeting]:
    """Hits in which one curve changes sides of the other."""
    one, other = _Strand.of(edges, i, a), _Strand.of(edges, j, b)
    # Up to four pairs of edges meet in a vertex.
    pairs = np.sort(np.column_stack([one.key, other.key]), axis=1)
    _, kept = np.unique(pairs, axis=0, return_index=True)
    proper = one.inner & other.inner & _interleaved(one, other)
    u, w = one.course, other.course
    angle = np.degrees(np.arctan2(np.abs(_cross(u, w)), np.abs(_dot(u, w))))
    return [
        Meeting(
            np.append(one.place[k], 0.0),
            (int(edges.curve[i[k]]), int(edges.curve[j[k]])),
            float(angle[k]),
            (float(one.station[k]), float(other.station[k])),
        )
        for k in np.sort(kept)
        if proper[k]
    ]


def _interleaved(one: _Strand, other: _Strand) -> NDArray[np.bool_]:
    """Tell where the other strand comes from one side of this one and leaves to the other."""
    turn = _turn(one.back, one.ahead)
    sides = np.stack([_turn(one.back, other.back), _turn(one.back, other.ahead)])
    along = np.minimum(np.minimum(sides, 2.0 * np.pi - sides), np.abs(sides - turn)) <= SECTOR
    return np.asarray(((sides[0] < turn) != (sides[1] < turn)) & ~along.any(axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class _Strand:
    """One of the two strands at each hit.

    ``key`` (K,) tells the edge or, in a vertex, the edge that begins there; ``back`` and ``ahead``
    are unit vectors (K, 2) away from the place; ``inner`` is false at the end of an open curve.
    """

    key: Ints
    place: Floats
    station: Floats
    back: Floats
    ahead: Floats
    inner: NDArray[np.bool_]

    @classmethod
    def of(cls, edges: _Edges, edge: Ints, fraction: Floats) -> _Strand:
        reach = fraction * edges.length[edge]
        at_head = reach <= edges.near
        at_tail = ~at_head & (edges.length[edge] - reach <= edges.near)
        following, last = _neighbour(edges, edge, 1)
        begun = np.where(at_tail & ~last, following, edge)
        before, first = _neighbour(edges, begun, -1)
        vertex = at_head | (at_tail & ~last)
        unit = edges.step / np.maximum(edges.length, 1e-300)[:, None]
        return cls(
            key=2 * begun + vertex,
            place=edges.head[edge] + fraction[:, None] * edges.step[edge],
            station=edges.station[edge] + reach,
            back=-unit[np.where(vertex, before, begun)],
            ahead=unit[begun],
            inner=~((at_head & first) | (at_tail & last)),
        )

    @property
    def course(self) -> Floats:
        """Mean direction, (K, 2), not of unit length."""
        mean = self.ahead - self.back
        return np.where(np.any(mean != 0.0, axis=1)[:, None], mean, self.ahead)


def _neighbour(edges: _Edges, edge: Ints, step: int) -> tuple[Ints, NDArray[np.bool_]]:
    """The next or last edge on the same curve, and where there is none."""
    number = edges.number[edge] + step
    missing = ~edges.closed[edge] & ((number < 0) | (number >= edges.size[edge]))
    return np.where(missing, edge, edges.first[edge] + number % edges.size[edge]), missing


def _turn(a: Floats, b: Floats) -> Floats:
    """Angle from one direction to another, counter-clockwise, in [0, 2 pi)."""
    return np.asarray(np.mod(np.arctan2(_cross(a, b), _dot(a, b)), 2.0 * np.pi))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _wrapped(line: Polyline, keep: Ints) -> Ints:
    return np.append(keep, keep[0]) if line.closed else keep


def _distinct(line: Polyline, near: float) -> Ints:
    """Indices of vertices without repetitions, which would make edges of no length; at least two remain."""
    x = line.vertices
    moved = np.append(True, np.linalg.norm(np.diff(x, axis=0), axis=1) > near)
    if line.closed and moved.sum() > 2 and np.linalg.norm(x[moved][-1] - x[0]) <= near:
        moved[np.flatnonzero(moved)[-1]] = False
    keep = np.flatnonzero(moved)
    return keep if len(keep) > 1 else np.array([0, len(x) - 1])
