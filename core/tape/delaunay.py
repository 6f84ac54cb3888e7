"""Delaunay triangulations of planar samples, whatever the library that makes them (§4.4).

Two libraries serve. pythoncdt decides by exact predicates and inserts points in an order
that keeps its time near linear whatever the points. Qhull, by way of scipy, works in
floating point: it leaves out points far from the origin, merges what it cannot tell apart,
and takes quadratic time where many points are exactly cocircular or collinear, as on a
circle without noise. So the points are first brought to the origin and to unit scale, by
operations that round nothing; and Qhull is given them slightly displaced, which bounds its
time but for extremes: it is there for want of the other.

Whatever the library, points enter it sorted, so that ties are broken the same way in
whatever order they were given, and what comes back is freed of triangles on the hull that
are flat to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from core.cloud.points import bounds, inverse_power_of_two, scaled_offset

__all__ = ["Backend", "Triangulation", "areas", "edge_lengths", "triangulate"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
AnyInts = NDArray[np.integer[Any]]
Backend = Literal["auto", "pythoncdt", "scipy"]

# Triangles whose height over the longest edge is less than this, in extents, are flat: a
# thousand times what is lost when coordinates are computed.
FLAT = 4e-12
# Largest displacement of the points that Qhull is given, in extents. With ten times less, a
# hundred thousand points on two parallel lines take it minutes.
DISPLACEMENT = 1e-9
# Triangles that it cannot have turned over are higher than this.
FLAT_FOR_QHULL = 4 * DISPLACEMENT
# Qhull is given one point of all in a square of this side, in extents.
CELL = 64 * DISPLACEMENT
# Points on a strip narrower than this, in extents, lie on a line as far as Qhull can see.
LEAST_WIDTH = 1000 * DISPLACEMENT
# Qhull's triangulation is repeated at most so often without the points it got wrong.
MOST_PASSES = 30
# Coordinates nearer to 0 than this, in extents, are 0: products of four of them, of which
# exact predicates are made, do not underflow.
LEAST_COORDINATE = 2.0**-130


@dataclass(frozen=True, slots=True, eq=False)
class Triangulation:
    """Triangles over given points, and which of them share an edge.

    Attributes
    ----------
    points : (N, 2) array of float
        The points as they were given, but for coordinates below 10^-39 of the extent, which are 0.
    triangles : (T, 3) array of int
        Vertices of each triangle as indices into ``points``, counter-clockwise.
    neighbours : (T, 3) array of int
        The triangle across the edge opposite vertex k, -1 where there is none.
    """

    points: Floats
    triangles: Ints
    neighbours: Ints


def triangulate(points: Floats, backend: Backend = "auto") -> Triangulation:
    """Triangulate points in the plane after Delaunay.

    Parameters
    ----------
    points : (N, 2) array
        Finite coordinates, wherever they lie and however large they are; any number.
    backend : {"auto", "pythoncdt", "scipy"}
        The library to use; "auto" is pythoncdt where it is installed.

    Returns
    -------
    Triangulation
        Over the given points. Of points that coincide, the first is a vertex. There are
        no triangles if fewer than three points are distinct, or if all lie on a line.

    Notes
    -----
    Triangles on the hull that are flat to rounding are left out: the hull of the
    triangulation can be that much less than convex. "scipy" also leaves out points that it
    cannot tell from others or from an edge, nearer than some 10^-8 of the extent, and finds
    no triangles over points that lie within 10^-6 of a line.

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.25]])
    >>> len(triangulate(square).triangles)
    4
    >>> len(triangulate(square[:2]).triangles)
    0
    """
    points = _settled(np.ascontiguousarray(points, np.float64))
    kept = _distinct(points)
    if len(kept) < 3:
        return Triangulation(points, _none(), _none())
    library = _qhull if backend == "scipy" or (backend == "auto" and not _has_cdt()) else _cdt
    triangles, neighbours = library(_normalised(points[kept]))
    return Triangulation(points, kept[triangles], neighbours)


def areas(triangulation: Triangulation) -> Floats:
    """Areas (T,) of the triangles, in units of the points squared."""
    return np.asarray(_areas(triangulation.points, triangulation.triangles))


def edge_lengths(triangulation: Triangulation) -> Floats:
    """Lengths (T, 3) of the edges opposite the vertices, in units of the points."""
    return np.asarray(_edge_lengths(triangulation.points, triangulation.triangles))


def _none() -> Ints:
    return np.empty((0, 3), np.int64)


def _distinct(points: Floats) -> Ints:
    """Index of the first of each set of equal points, sorted by their coordinates."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    ranked = points[order]
    first = np.append(np.ones(min(1, len(order)), bool), (ranked[1:] != ranked[:-1]).any(axis=1))
    return np.asarray(order[first])


def _settled(points: Floats) -> Floats:
    """Points with negligible coordinates set to 0."""
    if len(points) == 0:
        return points
    low, high = bounds(points)
    least = LEAST_COORDINATE * float((high / 2 - low / 2).max())
    return np.where(np.abs(points) < least, 0.0, points)


def _normalised(points: Floats) -> Floats:
    """Points near the origin and of extent about 1, each difference of coordinates as it was.

    Numbers within a factor of two of one another are subtracted without rounding (Sterbenz'
    lemma). An axis nearer to the origin than that needs no shift.
    """
    low, high = bounds(points)
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    far = (half <= np.minimum(np.abs(low), np.abs(high)) / 2) & (np.sign(low) == np.sign(high))
    return scaled_offset(points, np.where(far, middle, 0.0), inverse_power_of_two(float(half.max())))


def _has_cdt() -> bool:
    """Whether pythoncdt is installed."""
    return find_spec("pythoncdt") is not None


def _cdt(points: Floats) -> tuple[Ints, Ints]:
    """Triangles and neighbours of distinct points by pythoncdt."""
    cdt = import_module("pythoncdt")
    mesh = cdt.Triangulation(cdt.VertexInsertionOrder.AUTO, cdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    mesh.insert_vertices(points)
    mesh.erase_super_triangle()
    table = mesh.triangles_array()
    # Its neighbour k lies across the edge from vertex k to the next, and the largest
    # unsigned integer stands for none.
    neighbours = np.roll(table["neighbors"], -1, axis=1).astype(np.int32)
    return _without_slivers(points, table["vertices"], neighbours, FLAT)


def _qhull(points: Floats) -> tuple[Ints, Ints]:
    """Triangles and neighbours of distinct points by Qhull.

    They are displaced, in the same way each time. Away from the hull, that leaves triangles
    flat only where a point lies nearly on an edge: it is left out, for they may overlap others.
    """
    rng = np.random.default_rng(0)
    kept = _spaced(points)
    for _ in range(MOST_PASSES):
        if _width(points[kept]) <= LEAST_WIDTH:
            break
        part = points[kept]
        try:
            mesh = Delaunay(part + rng.uniform(-DISPLACEMENT, DISPLACEMENT, part.shape))
        except QhullError:
            break
        triangles, neighbours = _without_slivers(part, mesh.simplices, mesh.neighbors, FLAT_FOR_QHULL)
        flat = _flat_vertices(part, triangles, FLAT_FOR_QHULL)
        if flat.max(initial=-1) < 0:
            return kept[triangles], neighbours
        kept = np.delete(kept, flat[flat >= 0])
    return _none(), _none()


def _spaced(points: Floats) -> Ints:
    """Indices of points no two of which are nearer than half a cell.

    Two points that near lie in one square of at least one of four grids, half a cell apart.
    """
    kept = np.arange(len(points))
    for shift in ([0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]):
        kept = kept[_distinct(np.floor(points[kept] / CELL + shift))]
    return kept


def _width(points: Floats) -> float:
    """Width of the points across the line from the first to the farthest, over that distance."""
    if len(points) < 3:
        return 0.0
    offset = points - points[0]
    line = offset[np.argmax(np.einsum("ij,ij->i", offset, offset))]
    return float(np.ptp(offset[:, 0] * line[1] - offset[:, 1] * line[0]) / (line @ line))


def _without_slivers(
    points: Floats, triangles: AnyInts, neighbours: AnyInts, least: float
) -> tuple[Ints, Ints]:
    """Leave out triangles less high than given, from the hull inwards."""
    corners, across = triangles.astype(np.int64), neighbours.astype(np.int64)
    keep = _peel(points, corners, across, least)
    if keep.all():
        return corners, across
    number = np.append(np.cumsum(keep) - 1, -1)
    return corners[keep], number[across[keep]]


@njit(cache=True)
def _doubled_area(points, triangle):  # type: ignore[no-untyped-def]
    """Twice the area of a triangle, positive if it is counter-clockwise."""
    a, b, c = triangle
    left = (points[a, 0] - points[c, 0]) * (points[b, 1] - points[c, 1])
    return left - (points[a, 1] - points[c, 1]) * (points[b, 0] - points[c, 0])


@njit(cache=True)
def _edge_length(points, triangle, k):  # type: ignore[no-untyped-def]
    """Length of the edge opposite vertex k."""
    a, b = triangle[(k + 1) % 3], triangle[(k + 2) % 3]
    return math.hypot(points[a, 0] - points[b, 0], points[a, 1] - points[b, 1])


@njit(cache=True)
def _flat_at(points, triangle, least):  # type: ignore[no-untyped-def]
    """The vertex opposite the longest edge if the triangle is flat or turned over, -1 otherwise."""
    opposite, longest = 0, -1.0
    for k in range(3):
        length = _edge_length(points, triangle, k)
        if length > longest:
            opposite, longest = triangle[k], length
    return opposite if _doubled_area(points, triangle) <= least * longest else -1


@njit(cache=True)
def _peel(points, triangles, neighbours, least):  # type: ignore[no-untyped-def]
    """Which triangles to keep; the neighbours of others are changed to have none there."""
    keep = np.ones(len(triangles), np.bool_)
    stack = np.empty(len(triangles), np.int64)
    waiting = np.zeros(len(triangles), np.bool_)
    depth = 0
    for t in range(len(triangles)):
        if neighbours[t].min() < 0 and _flat_at(points, triangles[t], least) >= 0:
            stack[depth] = t
            waiting[t] = True
            depth += 1
    while depth > 0:
        depth -= 1
        t = stack[depth]
        keep[t] = False
        for k in range(3):
            n = neighbours[t, k]
            if n < 0:
                continue
            for j in range(3):
                if neighbours[n, j] == t:
                    neighbours[n, j] = -1
            if not waiting[n] and _flat_at(points, triangles[n], least) >= 0:
                stack[depth] = n
                waiting[n] = True
                depth += 1
    return keep


@njit(cache=True)
def _flat_vertices(points, triangles, least):  # type: ignore[no-untyped-def]
    """For each triangle the vertex at which it is flat, -1 for all others."""
    out = np.empty(len(triangles), np.int64)
    for t in range(len(triangles)):
        out[t] = _flat_at(points, triangles[t], least)
    return out


@njit(cache=True)
def _edge_lengths(points, triangles):  # type: ignore[no-untyped-def]
    out = np.empty((len(triangles), 3))
    for t in range(len(triangles)):
        for k in range(3):
            out[t, k] = _edge_length(points, triangles[t], k)
    return out


@njit(cache=True)
def _areas(points, triangles):  # type: ignore[no-untyped-def]
    out = np.empty(len(triangles))
    for t in range(len(triangles)):
        out[t] = 0.5 * _doubled_area(points, triangles[t])
    return out
