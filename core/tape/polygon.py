"""The union of triangles as a polygon: its rings traced along the border, in linear time (§4.4).

The border of a union of triangles consists of the edges with an accepted triangle on
their left and none on their right. Following them, and turning at every vertex inside
the fan of accepted triangles on the left, never leaves a component of triangles that
share edges: at a vertex where two fans meet in nothing but that point, each fan is passed
by itself. A walk may still come back to a vertex through another fan of the same
component; it is cut there. What remains are simple rings: one of each component runs
counter-clockwise around it, all others clockwise around its holes, and rings of one
component meet in single points only. That is a valid polygon by construction, without
any geometric predicate.
"""

from __future__ import annotations

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray

from core.tape.delaunay import Triangulation, areas

__all__ = ["border_rings", "edge_components", "fill_holes", "tape_polygon"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def edge_components(triangulation: Triangulation, member: Bools) -> tuple[Ints, int]:
    """Label the components of triangles that are joined through shared edges.

    Parameters
    ----------
    triangulation : Triangulation
        T triangles.
    member : (T,) array of bool
        Which triangles take part.

    Returns
    -------
    labels : (T,) array of int
        0, 1, … in the order in which the components first appear; -1 for all others.
    count : int
        The number of components.
    """
    labels, count = _edge_components(triangulation.neighbours, member)
    return np.asarray(labels), int(count)


def border_rings(triangulation: Triangulation, accepted: Bools) -> list[Ints]:
    """Trace the border of the union of the accepted triangles.

    Parameters
    ----------
    triangulation : Triangulation
        T triangles.
    accepted : (T,) array of bool
        Which triangles belong to the union.

    Returns
    -------
    list of (n,) arrays of int
        Vertices of each ring as indices into the points, the first not repeated. Every
        ring is simple and has the union on its left: rings around components run
        counter-clockwise, those around holes clockwise.
    """
    vertices, starts, _ = _border_rings(triangulation.triangles, triangulation.neighbours, accepted)
    return list(np.split(vertices, starts[1:-1])) if len(starts) > 1 else []


def fill_holes(triangulation: Triangulation, accepted: Bools, most_area: float | Floats) -> Bools:
    """Accept small groups of rejected triangles that the accepted ones enclose.

    Parameters
    ----------
    triangulation : Triangulation
        T triangles.
    accepted : (T,) array of bool
        Which triangles belong to the tape so far.
    most_area : float or (T,) array of float
        A hole is filled if its area is less than this; of an array, less than the mean
        over the hole's triangles.

    Returns
    -------
    (T,) array of bool
        The accepted triangles and those of the holes filled.

    Notes
    -----
    A hole is a group of rejected triangles, connected through edges, none of which has
    an edge on the hull.
    """
    labels, count = edge_components(triangulation, ~accepted)
    rejected = labels >= 0
    group = labels[rejected]
    size = np.bincount(group, minlength=count)
    area = np.bincount(group, areas(triangulation)[rejected], count)
    limit = np.bincount(group, np.broadcast_to(most_area, rejected.shape)[rejected], count)
    on_hull = (triangulation.neighbours[rejected] < 0).any(axis=1)
    filled = area * size < limit
    filled[group[on_hull]] = False
    out = accepted.copy()
    out[rejected] = filled[group]
    return out


def tape_polygon(triangulation: Triangulation, accepted: Bools) -> shapely.MultiPolygon:
    """Union of the accepted triangles as a valid multipolygon.

    Parameters
    ----------
    triangulation : Triangulation
        T triangles.
    accepted : (T,) array of bool
        Which triangles belong to the union.

    Returns
    -------
    shapely.MultiPolygon
        One polygon per component of triangles that share edges, its outer ring
        counter-clockwise, its holes clockwise; empty if nothing is accepted.
    """
    vertices, starts, triangle = _border_rings(triangulation.triangles, triangulation.neighbours, accepted)
    if len(triangle) == 0:
        return shapely.MultiPolygon()
    labels, count = edge_components(triangulation, accepted)
    component = labels[triangle]
    # The outer ring is the one with positive area: first in its component.
    order = np.lexsort((-_signed_areas(triangulation.points, vertices, starts), component))
    closed, ring_offsets = _closed_rings(triangulation.points, vertices, starts, order)
    polygon_offsets = np.searchsorted(component[order], np.arange(count + 1))
    offsets = (ring_offsets, polygon_offsets, np.array([0, count]))
    return shapely.from_ragged_array(shapely.GeometryType.MULTIPOLYGON, closed, offsets)[0]


@njit(cache=True)
def _edge_components(neighbours, member):  # type: ignore[no-untyped-def]
    """Flood each component in turn."""
    labels = np.full(len(neighbours), -1)
    stack = np.empty(len(neighbours), np.int64)
    count = 0
    for seed in range(len(neighbours)):
        if not member[seed] or labels[seed] >= 0:
            continue
        labels[seed] = count
        stack[0] = seed
        depth = 1
        while depth > 0:
            depth -= 1
            t = stack[depth]
            for k in range(3):
                n = neighbours[t, k]
                if n >= 0 and member[n] and labels[n] < 0:
                    labels[n] = count
                    stack[depth] = n
                    depth += 1
        count += 1
    return labels, count


@njit(cache=True)
def _is_border(neighbours, accepted, t, k):  # type: ignore[no-untyped-def]
    """Whether an accepted triangle has no accepted neighbour across its edge k."""
    return neighbours[t, k] < 0 or not accepted[neighbours[t, k]]


@njit(cache=True)
def _next_border_edge(triangles, neighbours, accepted, t, k):  # type: ignore[no-untyped-def]
    """The border edge that leaves the vertex where edge k of triangle t ends, in the same fan."""
    vertex = triangles[t, (k + 2) % 3]
    k = (k + 1) % 3
    while not _is_border(neighbours, accepted, t, k):
        t = neighbours[t, k]
        k = 0
        while triangles[t, (k + 1) % 3] != vertex:
            k += 1
    return t, k


@njit(cache=True)
def _border_rings(triangles, neighbours, accepted):  # type: ignore[no-untyped-def]
    """Vertices of all rings one after another, where each begins, and a triangle inside each.

    A walk is cut by a stack: whenever it comes back to a vertex on the stack, what lies
    above that vertex is a ring.
    """
    done = np.zeros(triangles.shape, np.bool_)
    size = 0
    highest = 0
    for t in range(len(triangles)):
        for k in range(3):
            highest = max(highest, triangles[t, k])
            if accepted[t] and _is_border(neighbours, accepted, t, k):
                size += 1
            else:
                done[t, k] = True
    vertices = np.empty(size, np.int64)
    starts = np.zeros(size // 3 + 1, np.int64)
    inside = np.empty(size // 3, np.int64)
    stack = np.empty(size, np.int64)
    place = np.full(highest + 1, -1)
    rings = 0
    for first in range(3 * len(triangles)):
        t, k = first // 3, first % 3
        depth = 0
        while not done[t, k]:
            done[t, k] = True
            stack[depth] = triangles[t, (k + 1) % 3]
            place[stack[depth]] = depth
            depth += 1
            bottom = place[triangles[t, (k + 2) % 3]]
            if bottom >= 0:
                end = starts[rings]
                for i in range(bottom, depth):
                    vertices[end] = stack[i]
                    place[stack[i]] = -1
                    end += 1
                inside[rings] = t
                rings += 1
                starts[rings] = end
                depth = bottom
            t, k = _next_border_edge(triangles, neighbours, accepted, t, k)
    return vertices, starts[: rings + 1], inside[:rings]


@njit(cache=True)
def _signed_areas(points, vertices, starts):  # type: ignore[no-untyped-def]
    """Area of each ring, positive if counter-clockwise."""
    out = np.zeros(len(starts) - 1)
    for r in range(len(out)):
        x, y = points[vertices[starts[r]]]
        for i in range(starts[r], starts[r + 1] - 1):
            a, b = vertices[i], vertices[i + 1]
            cross = (points[a, 0] - x) * (points[b, 1] - y) - (points[a, 1] - y) * (points[b, 0] - x)
            out[r] += 0.5 * cross
    return out


@njit(cache=True)
def _closed_rings(points, vertices, starts, order):  # type: ignore[no-untyped-def]
    """Coordinates of the rings in the given order, the first point repeated, and where each begins."""
    coordinates = np.empty((len(vertices) + len(order), 2))
    offsets = np.zeros(len(order) + 1, np.int64)
    end = 0
    for i in range(len(order)):
        first, stop = starts[order[i]], starts[order[i] + 1]
        for j in range(first, stop + 1):
            coordinates[end] = points[vertices[j if j < stop else first]]
            end += 1
        offsets[i + 1] = end
    return coordinates, offsets
