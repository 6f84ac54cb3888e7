"""The overlay of the regions A and C at the two ends of each slab, as labelled triangles.

Constrained Delaunay triangulations of both borders, one for each slab; all slabs' triangles are
then treated at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray

from core.surface.linework import Linework, node_keys

__all__ = ["Overlay", "SlabEnds", "area_of", "edges_by_slab", "edges_of", "overlay_of", "slab_ends"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

ENCLOSING = 3  # vertices of the triangle around everything that the library puts first
NONE = np.iinfo(np.uint32).max  # its neighbour beyond the border


@dataclass(frozen=True, slots=True, eq=False)
class SlabEnds:
    """The contours between which one slab spans: edges of the linework, and the heights.

    Attributes
    ----------
    lower, upper : arrays of int
        Indices of edges.
    levels : (int, int)
    heights : (float, float)
    """

    lower: Ints
    upper: Ints
    levels: tuple[int, int]
    heights: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """All slabs' triangulations; edge k of a triangle joins its vertices k and k + 1.

    Attributes
    ----------
    node : (N,) array of int
        Grid point of each vertex, an index into ``points``; a vertex belongs to one slab.
    free : (F,) array of int
        Vertices on no border.
    points : (P, 2) array of int
    slab : (N,) array of int
    triangles : (T, 3) array of int
        Counter-clockwise.
    neighbours : (T, 3) array of int
        Across the edges.
    inside : (T, 2) array of bool
        Whether the triangle lies in A, in C.
    border : (T, 3, 2) array of bool
        Whether the edge lies on the border of A, of C.
    part : (T,) array of int
        Connected part of the slab without the borders.
    """

    node: Ints
    free: Ints
    points: Ints
    slab: Ints
    triangles: Ints
    neighbours: Ints
    inside: Bools
    border: Bools
    part: Ints


def slab_ends(lines: Linework, heights: Floats, step: int = 1) -> list[SlabEnds]:
    """The slabs between all levels.

    With ``step`` 2, every other level is an intermediate one of the similarity gate: contours that
    are gated reach up or down to it only, the others past it to the next.
    """
    out = []
    by_level = lines.by_level(len(heights))
    for k in range(0, len(heights) - step, step):
        lower, upper = by_level[k], by_level[k + step]
        stop_below, stop_above = lines.gated[lower, 1], lines.gated[upper, 0]
        pairs = [(lower[~stop_below], upper[~stop_above], k, k + step)]
        if step == 2:
            middle = by_level[k + 1]
            pairs += [(lower[stop_below], middle, k, k + 1), (middle, upper[stop_above], k + 1, k + 2)]
        out += [
            SlabEnds(below, above, (i, j), (float(heights[i]), float(heights[j])))
            for below, above, i, j in pairs
            if len(below) or len(above)
        ]
    return out


def overlay_of(lines: Linework, slabs: Sequence[SlabEnds], inner: Sequence[Ints] | None = None) -> Overlay:
    """Triangles of all slabs, labelled by the even-odd rule.

    ``inner`` are further grid points (M, 2) for each slab, on no border.
    """
    _, first, nodes = np.unique(node_keys(lines.ends), return_index=True, return_inverse=True)
    points, nodes = lines.ends.reshape(-1, 2)[first], nodes.reshape(-1, 2)
    inner = inner or [points[:0]] * len(slabs)
    borders, points = len(points), np.concatenate((points, *inner))
    edges, slab, end = edges_by_slab(slabs)
    further = np.repeat(np.arange(len(slabs)), [len(each) for each in inner]), np.arange(borders, len(points))
    keys = (slab[:, None] * len(points) + nodes[edges]).ravel()
    names, ends = np.unique(
        np.concatenate((keys, further[0] * len(points) + further[1])), return_inverse=True
    )
    slab_of, node = np.divmod(names, len(points))
    ends = ends[: len(keys)].reshape(-1, 2)
    starts = np.searchsorted(slab_of, np.arange(len(slabs) + 1))
    tables = _triangulated(points[node], starts, ends - starts[slab][:, None], slab)
    vertex_starts = starts + ENCLOSING * np.arange(len(slabs) + 1)
    triangles, neighbours = _joined(tables, vertex_starts)
    vertices = np.full(int(vertex_starts[-1]), -1)
    vertices[np.arange(len(node)) + ENCLOSING * (slab_of + 1)] = node
    inside, border, part = _labelled(
        triangles, neighbours, vertices, ends + ENCLOSING * (slab[:, None] + 1), end
    )
    return Overlay(
        vertices,
        np.flatnonzero(vertices >= borders),
        points,
        np.repeat(np.arange(len(slabs)), np.diff(vertex_starts)),
        triangles,
        neighbours,
        inside,
        border,
        part,
    )


def edges_by_slab(slabs: Sequence[SlabEnds]) -> tuple[Ints, Ints, Ints]:
    """Indices of the edges of all slabs, one slab after another; the slab of each, and at which end it is."""
    both = [edges for slab in slabs for edges in (slab.lower, slab.upper)]
    which = np.repeat(np.arange(len(both)), [len(edges) for edges in both])
    return np.concatenate(both), which // 2, which % 2


def area_of(lines: Linework, mine: Ints) -> object:
    """What some noded edges enclose by the even-odd rule, as a shapely geometry of disjoint polygons."""
    overlay = overlay_of(lines, [SlabEnds(mine, mine[:0], (0, 1), (0.0, 1.0))])
    corners = overlay.points[overlay.node[overlay.triangles[overlay.inside[:, 0]]]]
    return shapely.coverage_union_all(shapely.polygons(corners.astype(np.float64)))


def edges_of(corners: Ints, total: int) -> Ints:
    """A number for each undirected edge: of polygons (T, n) an array (T, n), of pairs (E, 2) one (E,)."""
    if corners.shape[1] == 2:
        a, b = corners.T
    else:
        a, b = corners, np.roll(corners, -1, axis=1)
    keys: Ints = np.minimum(a, b) * total + np.maximum(a, b)
    return keys


def _triangulated(
    points: Ints, starts: Ints, edges: Ints, slab: Ints
) -> list[tuple[NDArray[np.uint32], NDArray[np.uint32]]]:
    """The constrained Delaunay triangulation of each slab: vertices, and neighbours, of its triangles.

    Slab s has the points ``starts[s]`` to ``starts[s + 1]``, between which its edges (E, 2) run.
    """
    cdt = import_module("pythoncdt")
    order, crossing = cdt.VertexInsertionOrder.AUTO, cdt.IntersectingConstraintEdges.NOT_ALLOWED
    places, constraints = points.astype(np.float64), edges.astype(np.uint32)
    firsts = np.searchsorted(slab, np.arange(len(starts)))
    tables = []
    for (a, b), (c, d) in zip(pairwise(starts.tolist()), pairwise(firsts.tolist()), strict=True):
        mesh = cdt.Triangulation(order, crossing, 0.0)
        mesh.insert_vertices(places[a:b])
        mesh.insert_edges(constraints[c:d])
        table = mesh.triangles_array()
        tables.append((table["vertices"], table["neighbors"]))
    return tables


def _joined(
    tables: list[tuple[NDArray[np.uint32], NDArray[np.uint32]]], vertex_starts: Ints
) -> tuple[Ints, Ints]:
    """All slabs' triangles and their neighbours, -1 for none, numbered through."""
    sizes = np.array([len(vertices) for vertices, _ in tables])
    triangles = np.concatenate([vertices for vertices, _ in tables]).astype(np.int64)
    triangles += np.repeat(vertex_starts[:-1], sizes)[:, None]
    neighbours = np.concatenate([beside for _, beside in tables])
    raised = neighbours + np.repeat(np.cumsum(sizes) - sizes, sizes)[:, None]
    return triangles, np.where(neighbours == NONE, -1, raised)


@njit(cache=True)
def _labelled(
    triangles: Ints, neighbours: Ints, node: Ints, edges: Ints, end: Ints
) -> tuple[Bools, Bools, Ints]:
    """What lies inside of which border, which edges are borders, and connected parts without them.

    Every slab is flooded from outside; a border is crossed when a part is full.
    """
    border = _bordered(triangles, len(node), edges, end)
    inside = np.zeros((len(triangles), 2), np.bool_)
    part = np.full(len(triangles), -1)
    same, beyond = np.empty(len(triangles), np.int64), np.empty(3 * len(triangles) + 1, np.int64)
    count = 0
    for seed in range(len(triangles)):
        a, b, c = triangles[seed, 0], triangles[seed, 1], triangles[seed, 2]
        outside = node[a] < 0 or node[b] < 0 or node[c] < 0
        if part[seed] >= 0 or not outside:
            continue
        beyond[0], waiting = seed, 1
        while waiting > 0:
            waiting -= 1
            if part[beyond[waiting]] >= 0:
                continue
            same[0], size = beyond[waiting], 1
            part[same[0]] = count
            while size > 0:
                size -= 1
                one = same[size]
                for k in range(3):
                    other = neighbours[one, k]
                    if other < 0 or part[other] >= 0:
                        continue
                    inside[other, 0] = inside[one, 0] != border[one, k, 0]
                    inside[other, 1] = inside[one, 1] != border[one, k, 1]
                    if border[one, k, 0] or border[one, k, 1]:
                        beyond[waiting] = other
                        waiting += 1
                    else:
                        part[other] = count
                        same[size] = other
                        size += 1
            count += 1
    return inside, border, part


@njit(cache=True)
def _bordered(triangles: Ints, count: int, edges: Ints, end: Ints) -> Bools:
    """Which edges of triangles are among those at which end; edges are listed by their lower vertex."""
    first, following = np.full(count, -1), np.empty(len(edges), np.int64)
    for e in range(len(edges)):
        low = min(edges[e, 0], edges[e, 1])
        first[low], following[e] = e, first[low]
    border = np.zeros((len(triangles), 3, 2), np.bool_)
    for t in range(len(triangles)):
        for k in range(3):
            a, b = triangles[t, k], triangles[t, (k + 1) % 3]
            e = first[min(a, b)]
            while e >= 0:
                if max(edges[e, 0], edges[e, 1]) == max(a, b):
                    border[t, k, end[e]] = True
                e = following[e]
    return border
