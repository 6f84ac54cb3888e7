"""The overlay of the regions A and C at the two ends of each slab, as labelled triangles.

Constrained Delaunay triangulations of both borders, one for each slab; all slabs' triangles are
then treated at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from core.surface.linework import Linework, node_keys

__all__ = ["Overlay", "SlabEnds", "area_of", "edges_of", "grouped", "overlay_of", "slab_ends"]

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
    """

    node: Ints
    free: Ints
    points: Ints
    slab: Ints
    triangles: Ints
    neighbours: Ints
    inside: Bools
    border: Bools


def slab_ends(lines: Linework, heights: Floats, step: int = 1) -> list[SlabEnds]:
    """The slabs between all levels.

    With ``step`` 2, every other level is an intermediate one of the similarity gate: contours that
    are gated reach up or down to it only, the others past it to the next.
    """
    out = []
    by_level = [np.flatnonzero(lines.level == k) for k in range(len(heights))]
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
    counts = np.cumsum([len(points), *(len(each) for each in inner)])
    points = np.concatenate((points, *inner))
    cuts = [
        _triangulated(points, nodes[slab.lower], nodes[slab.upper], np.arange(first, last))
        for slab, first, last in zip(slabs, counts[:-1], counts[1:], strict=True)
    ]
    starts = np.cumsum([0] + [len(cut.node) for cut in cuts])[:-1]
    firsts = np.cumsum([0] + [len(cut.triangles) for cut in cuts])[:-1]
    total = int(sum(len(cut.node) for cut in cuts))
    triangles = np.concatenate([cut.triangles + start for cut, start in zip(cuts, starts, strict=True)])
    neighbours = np.concatenate(
        [_raised(cut.neighbours, int(t)) for cut, t in zip(cuts, firsts, strict=True)]
    )
    sides = edges_of(triangles, total)
    border = np.stack(
        [
            np.isin(
                sides,
                np.concatenate(
                    [edges_of(cut.borders[k] + s, total) for cut, s in zip(cuts, starts, strict=True)]
                ),
            )
            for k in range(2)
        ],
        axis=-1,
    )
    node = np.concatenate([cut.node for cut in cuts])
    outside = np.any(node[triangles] < 0, axis=1)
    inside = np.column_stack([_parity(neighbours, border[:, :, k], outside) for k in range(2)])
    slab = np.repeat(np.arange(len(cuts)), [len(cut.node) for cut in cuts])
    free = np.flatnonzero(node >= counts[0])
    return Overlay(node, free, points, slab, triangles, neighbours, inside, border)


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


def grouped(neighbours: Ints, parted: Bools) -> Ints:
    """Number of the connected part of each triangle, where ``parted`` (T, 3) edges part."""
    triangle, side = np.nonzero((neighbours >= 0) & ~parted)
    links = coo_array(
        (np.ones(len(triangle)), (triangle, neighbours[triangle, side])), (len(neighbours),) * 2
    )
    labels: Ints = connected_components(links, directed=False)[1].astype(np.int64)
    return labels


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """One slab's triangulation; node -1 is a vertex of the enclosing triangle."""

    node: Ints
    triangles: Ints
    neighbours: Ints
    borders: tuple[Ints, Ints]


def _triangulated(points: Ints, lower: Ints, upper: Ints, inner: Ints) -> _Cut:
    """The constrained Delaunay triangulation of edges (E, 2) between points, and of further points."""
    cdt = import_module("pythoncdt")
    node, local = np.unique(np.concatenate((lower, upper)), return_inverse=True)
    local = local.reshape(-1, 2) + ENCLOSING
    mesh = cdt.Triangulation(cdt.VertexInsertionOrder.AUTO, cdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    node = np.concatenate((node, inner))
    mesh.insert_vertices(points[node].astype(np.float64))
    mesh.insert_edges((local - ENCLOSING).astype(np.uint32))
    table = mesh.triangles_array()
    neighbours = table["neighbors"].astype(np.int64)
    neighbours[neighbours == NONE] = -1
    node = np.concatenate((np.full(ENCLOSING, -1), node))
    return _Cut(
        node, table["vertices"].astype(np.int64), neighbours, (local[: len(lower)], local[len(lower) :])
    )


def _raised(neighbours: Ints, first: int) -> Ints:
    return np.where(neighbours < 0, -1, neighbours + first)


def _parity(neighbours: Ints, border: Bools, outside: Bools) -> Bools:
    """Whether an odd number of borders lies between each triangle and the outside."""
    part = grouped(neighbours, border)
    count = int(part.max()) + 1
    triangle, side = np.nonzero(border)
    outer = np.unique(part[outside])
    rows = np.concatenate((part[triangle], np.full(len(outer), count)))
    columns = np.concatenate((part[neighbours[triangle, side]], outer))
    links = coo_array((np.ones(len(rows)), (rows, columns)), (count + 1, count + 1)).tocsr()
    steps = dijkstra(links, directed=False, indices=np.array([count]), unweighted=True)
    odd: Bools = steps[0, part].astype(np.int64) % 2 == 0
    return odd
