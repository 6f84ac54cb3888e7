"""From the overlay of each slab to one closed mesh ("overlay slabs").

Between the planes of the regions A and C, the surface is a graph over A minus C, where it looks up,
and over C minus A, where it looks down; vertical where both borders coincide. It reaches the lower
plane along the border of A only, and the upper one along that of C only: so what two slabs share is
one border, and every edge has two faces. Bajaj, Coyle and Lin (1996) and Boissonnat (1988) give the
background on branching; the similarity of contours is that of Ruiz et al. (2005).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.surface.borders import Borders
from core.surface.heights import Passes, Places, heights_of
from core.surface.inner_points import inner_points
from core.surface.linework import Grid, Linework
from core.surface.overlay import Overlay, SlabEnds, edges_of, overlay_of
from core.surface.results import Mesh

__all__ = ["mesh_of_slabs"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

INNER = 2  # neither end of the slab


def mesh_of_slabs(
    lines: Linework, slabs: Sequence[SlabEnds], grid: Grid, passes: Passes | None = None
) -> Mesh:
    """The closed mesh between noded borders.

    Parameters
    ----------
    lines : Linework
        Noded, no region touching itself.
    slabs : sequence of SlabEnds
        Each level's region is the upper end of the slabs below it and the lower one of those above.
    grid : Grid
    passes : Passes, optional
        How high the surface is inside slabs, where that is known.

    Returns
    -------
    Mesh
        In the frame of the levels: x, y, height.
    """
    borders = Borders.of(lines)
    overlay = overlay_of(lines, slabs, inner_points(lines, borders, slabs, grid.pitch))
    sheet = _sheet(overlay)
    edges, places = _inner_vertices(overlay, sheet)
    inner = _Inner(edges, places.xy, heights_of(places, borders, slabs, grid, passes))
    corners = _Corners(overlay, slabs)
    pieces = _pieces(sheet, corners, inner, len(overlay.node))
    strips = _strips(sheet, corners, inner, len(overlay.node))
    walls = _walls(overlay, corners)
    return corners.mesh(grid, inner, np.concatenate((pieces, strips, walls)))


@dataclass(frozen=True, slots=True, eq=False)
class _Sheet:
    """The triangles of A minus C and of C minus A.

    Attributes
    ----------
    triangles : (S, 3) array of int
    part : (S,) array of int
        Connected part.
    down : (S,) array of bool
        Whether it looks down, lying in C.
    top : (S, 3) array of int
        At which end of the slab the vertex lies, 0 or 1; ``INNER`` for one on no border.
    border : (S, 3) array of bool
    needed : (S, 3) array of int
        The end at which the surface's border lies over the edge, where it is one.
    split : (S, 3) array of bool
        Edges that would lie in a plane inside the surface.
    flat : (S,) array of bool
        Triangles that would lie in a plane.
    """

    triangles: Ints
    part: Ints
    down: Bools
    top: Ints
    border: Bools
    needed: Ints
    split: Bools
    flat: Bools


def _sheet(overlay: Overlay) -> _Sheet:
    """Where A and C differ, and at which end of the slab each vertex lies.

    Where both ends are asked for, a vertex goes to the plane of its own region (A for what looks
    up): the border over there can then be shared by no other face.
    """
    chosen = np.flatnonzero(overlay.inside[:, 0] != overlay.inside[:, 1])
    part = overlay.part[chosen]
    triangles, down = overlay.triangles[chosen], overlay.inside[chosen, 1]
    border = overlay.border[chosen]
    own_end = down.astype(np.int64)[:, None]
    own = np.take_along_axis(border, own_end[:, :, None], axis=2)[:, :, 0]
    needed = np.where(own, own_end, 1 - own_end)
    touched = np.zeros((2, len(overlay.node)), np.bool_)
    row, side = np.nonzero(own)
    for corner in (side, (side + 1) % 3):
        touched[own_end[row, 0], triangles[row, corner]] = True
    top = np.where(touched[np.broadcast_to(own_end, triangles.shape), triangles], own_end, 1 - own_end)
    top[np.isin(triangles, overlay.free)] = INNER
    anywhere: Bools = np.any(border, axis=2)
    level = (top == np.roll(top, -1, axis=1)) & (top != INNER)
    split = level & ~(anywhere & (needed == top))
    flat = level.all(axis=1) & ~split.any(axis=1)
    return _Sheet(triangles, part, down, top, anywhere, needed, split, flat)


@dataclass(frozen=True, slots=True, eq=False)
class _Inner:
    """Vertices strictly inside slabs: on split edges, in flat triangles, on no border, in this order.

    Attributes
    ----------
    edges : (M,) array of int
        Sorted numbers of the split edges.
    places : (I, 2) array
        Grid coordinates.
    heights : (I,) array
    """

    edges: Ints
    places: Floats
    heights: Floats

    def on(self, edges: Ints) -> Ints:
        """Numbers, counted from the end, of the vertices on edges."""
        return np.searchsorted(self.edges, edges).astype(np.int64) - len(self.heights)


def _inner_vertices(overlay: Overlay, sheet: _Sheet) -> tuple[Ints, Places]:
    """Split edges, and the places of the inner vertices."""
    edges, first = np.unique(edges_of(sheet.triangles, len(overlay.node))[sheet.split], return_index=True)
    row, side = (found[first] for found in np.nonzero(sheet.split))
    flat, free = np.flatnonzero(sheet.flat), overlay.free
    owner = np.zeros(len(overlay.node), np.int64)
    owner[sheet.triangles] = np.arange(len(sheet.triangles))[:, None]
    xy = overlay.points[overlay.node].astype(np.float64)
    ends = xy[sheet.triangles[row, side]], xy[sheet.triangles[row, (side + 1) % 3]]
    places = np.concatenate(((ends[0] + ends[1]) / 2.0, xy[sheet.triangles[flat]].mean(axis=1), xy[free]))
    rows = np.concatenate((row, flat, owner[free]))
    reached = np.zeros((2, int(sheet.part.max(initial=0)) + 1), np.bool_)
    row, side = np.nonzero(sheet.border)
    reached[sheet.needed[row, side], sheet.part[row]] = True
    part = sheet.part[rows]
    return edges, Places(places, overlay.slab[sheet.triangles[rows, 0]], part, reached[:, part])


class _Corners:
    """Vertices in the planes: one for each grid point of a level's border."""

    def __init__(self, overlay: Overlay, slabs: Sequence[SlabEnds]) -> None:
        self._overlay = overlay
        self._levels = np.array([each.levels for each in slabs], np.int64)
        self._height = np.zeros(int(self._levels.max()) + 1)
        self._height[self._levels] = [each.heights for each in slabs]

    def at(self, vertex: Ints, top: Ints) -> Ints:
        """Numbers, far from dense, of vertices of the overlay at an end of their slab."""
        level = self._levels[self._overlay.slab[vertex], np.minimum(top, 1)]
        numbers = level * len(self._overlay.points) + self._overlay.node[vertex]
        return np.where(
            top == INNER, np.searchsorted(self._overlay.free, vertex) - len(self._overlay.free), numbers
        )

    def mesh(self, grid: Grid, inner: _Inner, faces: Ints) -> Mesh:
        """The mesh of faces whose corners are such numbers; those of inner vertices are negative."""
        # Numbers of inner vertices count from the last one.
        used, dense = np.unique(faces, return_inverse=True)
        level, node = np.divmod(used, len(self._overlay.points))
        inside = used < 0
        xy = np.where(inside[:, None], 0.0, self._overlay.points[np.where(inside, 0, node)])
        z = self._height[np.where(inside, 0, level)]
        xy[inside], z[inside] = inner.places[used[inside]], inner.heights[used[inside]]
        return Mesh(np.column_stack((grid.placed(xy), z)), dense.reshape(-1, 3).astype(np.int64))


def _pieces(sheet: _Sheet, corners: _Corners, inner: _Inner, total: int) -> Ints:
    """The sheets' triangles, cut at the vertices on their split edges."""
    vertex = corners.at(sheet.triangles, sheet.top)
    middle = np.full(vertex.shape, 0)
    middle[sheet.split] = inner.on(edges_of(sheet.triangles, total)[sheet.split])
    count = sheet.split.sum(axis=1)
    # Each triangle is turned so that its split edges come first, in a row.
    turn = np.where(
        count == 1, sheet.split.argmax(axis=1), np.where(count == 2, (~sheet.split).argmax(axis=1) + 1, 0)
    )
    order = (np.arange(3) + turn[:, None]) % 3
    a, b, c = np.take_along_axis(vertex, order, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, order, axis=1).T
    centre = np.zeros(len(a), np.int64)
    centre[sheet.flat] = len(inner.edges) - len(inner.heights) + np.arange(np.count_nonzero(sheet.flat))
    cases: list[tuple[Bools, list[tuple[Ints, Ints, Ints]]]] = [
        ((count == 0) & ~sheet.flat, [(a, b, c)]),
        (sheet.flat, [(a, b, centre), (b, c, centre), (c, a, centre)]),
        (count == 1, [(a, ab, c), (ab, b, c)]),
        (count == 2, [(ab, b, bc), (a, ab, bc), (a, bc, c)]),
        (count == 3, [(a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca)]),
    ]
    faces = [_turned(np.column_stack(one)[case], sheet.down[case]) for case, ones in cases for one in ones]
    return np.concatenate(faces)


def _strips(sheet: _Sheet, corners: _Corners, inner: _Inner, total: int) -> Ints:
    """Vertical triangles between the edges of the sheets and the borders over them."""
    row, side = np.nonzero(sheet.border)
    v, w = sheet.triangles[row, side], sheet.triangles[row, (side + 1) % 3]
    needed, down = sheet.needed[row, side], sheet.down[row]
    at_v, at_w = sheet.top[row, side], sheet.top[row, (side + 1) % 3]
    v_is, w_is = corners.at(v, at_v), corners.at(w, at_w)
    v_to, w_to = corners.at(v, needed), corners.at(w, needed)
    first, second = (at_v != needed) & (at_w == needed), (at_v == needed) & (at_w != needed)
    both = (at_v != needed) & (at_w != needed)
    middle = np.zeros(len(row), np.int64)
    middle[both] = inner.on(edges_of(np.column_stack((v, w)), total)[both])
    cases = [
        (first, (w_is, v_is, v_to)),
        (second, (w_is, v_is, w_to)),
        (both, (middle, v_is, v_to)),
        (both, (middle, v_to, w_to)),
        (both, (middle, w_to, w_is)),
    ]
    return np.concatenate([_turned(np.column_stack(one)[case], down[case]) for case, one in cases])


def _walls(overlay: Overlay, corners: _Corners) -> Ints:
    """Vertical quadrangles, as two triangles, where the solid of both regions meets the outside."""
    solid: Bools = np.all(overlay.inside, axis=1)
    both: Bools = np.all(overlay.border, axis=2)
    row, side = np.nonzero(both & solid[:, None])
    v, w = overlay.triangles[row, side], overlay.triangles[row, (side + 1) % 3]
    low, high = np.zeros(len(row), np.int64), np.ones(len(row), np.int64)
    v_low, v_high, w_low, w_high = (corners.at(x, end) for x in (v, w) for end in (low, high))
    return np.concatenate((np.column_stack((v_low, w_low, w_high)), np.column_stack((v_low, w_high, v_high))))


def _turned(faces: Ints, down: Bools) -> Ints:
    """Faces with those reversed that look down."""
    return np.where(down[:, None], faces[:, ::-1], faces)
