"""Borders of all levels' regions as straight edges between points of one square grid.

Integer coordinates make every geometric decision that follows exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.surface.boxes import order_of, tree_of

__all__ = ["Grid", "Linework", "borders_of", "boxes_of", "linework_of", "node_keys", "without_doubles"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FINENESS = 1e-6  # of the extent: far below any spacing of samples, above the resolution of single precision
KEY_SHIFT = 2**31  # coordinates stay far below
APART = 2.0**24  # grid units between levels, more than contours extend: branches of trees part levels first


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Points origin + pitch * (i, j); the pitch is a power of two, so that coordinates stay exact."""

    origin: Floats
    pitch: float

    @classmethod
    def over(cls, points: Floats) -> Grid:
        """The grid for (M, 2) points, of which two differ."""
        low, high = points.min(axis=0), points.max(axis=0)
        pitch = float(2.0 ** np.ceil(np.log2(FINENESS * (high - low).max())))
        return cls(np.rint((low / 2 + high / 2) / pitch) * pitch, pitch)

    def snapped(self, points: Floats) -> Ints:
        """Grid coordinates next to (M, 2) points."""
        return np.rint((points - self.origin) / self.pitch).astype(np.int64)

    def placed(self, coordinates: Floats | Ints) -> Floats:
        """Points at (M, 2) grid coordinates."""
        return self.origin + self.pitch * coordinates


@dataclass(frozen=True, slots=True, eq=False)
class Linework:
    """Undirected edges; those of one level bound its region by the even-odd rule.

    Attributes
    ----------
    ends : (E, 2, 2) array of int
        Edge, end, coordinate.
    level : (E,) array of int
    gated : (E, 2) array of bool
        Whether the edge belongs to a contour that the similarity gate keeps apart from one of the
        level below, of the level above.
    """

    ends: Ints
    level: Ints
    gated: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.level)

    def taken(self, which: Ints | NDArray[np.bool_]) -> Linework:
        """Some of the edges."""
        return Linework(self.ends[which], self.level[which], self.gated[which])

    def by_level(self, count: int) -> list[Ints]:
        """Indices of the edges of each of so many levels, ascending."""
        order = np.argsort(self.level, kind="stable")
        return np.split(order, np.searchsorted(self.level[order], np.arange(1, count)))

    def joined(self, other: Linework) -> Linework:
        """These edges, then the others."""
        return Linework(
            np.concatenate((self.ends, other.ends)),
            np.concatenate((self.level, other.level)),
            np.concatenate((self.gated, other.gated)),
        )


def linework_of(loops: Sequence[Ints], levels: Sequence[int]) -> Linework:
    """Edges of closed loops, each an (M, 2) array of grid coordinates, and their levels.

    They do not depend on the order of the loops, nor on where and in which sense they run.
    """
    empty = np.zeros((0, 2, 2), np.int64)
    ends = np.concatenate([empty, *(np.stack((loop, np.roll(loop, -1, axis=0)), axis=1) for loop in loops)])
    level = np.repeat(np.array(levels, np.int64), [len(loop) for loop in loops])
    keys = node_keys(ends)
    ends = np.where((keys[:, 0] < keys[:, 1])[:, None, None], ends, ends[:, ::-1])
    order = np.lexsort((keys.max(axis=1), keys.min(axis=1), level))
    order = order[keys[order, 0] != keys[order, 1]]
    return Linework(ends[order], level[order], np.zeros((len(order), 2), np.bool_))


def node_keys(points: Ints) -> Ints:
    """One number for each of (..., 2) grid points, the same for the same point."""
    return (points[..., 0] + KEY_SHIFT // 2) * KEY_SHIFT + points[..., 1] + KEY_SHIFT // 2


def without_doubles(lines: Linework) -> Ints:
    """Indices of the edges that bound the region: of an even number in the same place none, of an odd one.

    Of different levels, edges may lie in the same place.
    """
    one, other = node_keys(lines.ends).T
    low, high = np.minimum(one, other), np.maximum(one, other)
    order = np.lexsort((high, low, lines.level))
    a, b, c = (np.diff(column[order]) != 0 for column in (high, low, lines.level))
    starts = np.flatnonzero(np.concatenate(([True], a | b | c))[: len(order)])
    counts = np.diff(np.append(starts, len(order)))
    return np.sort(order[starts[counts % 2 == 1]])


def boxes_of(lines: Linework) -> tuple[Floats, Ints]:
    """A tree of boxes around edges (`core.surface.boxes`), and the edge of each leaf.

    Each box is at the height of its level's number. There is at least one edge.
    """
    a, b = (np.column_stack((lines.ends[:, k], lines.level)).astype(np.float64) for k in range(2))
    order = order_of((a + b) * (1.0, 1.0, APART))
    return tree_of(np.minimum(a, b)[order], np.maximum(a, b)[order]), order


def borders_of(area: object, level: int, gated: NDArray[np.bool_]) -> Linework:
    """The borders of a shapely geometry, its vertices taken to the grid, as a level's edges."""
    polygons = shapely.get_parts(shapely.get_parts(area))
    rings = shapely.get_rings(polygons[shapely.get_dimensions(polygons) == 2])
    points, ring = shapely.get_coordinates(rings, return_index=True)
    step = np.flatnonzero(ring[1:] == ring[:-1])
    grid = np.rint(points).astype(np.int64)
    ends = np.stack((grid[step], grid[step + 1]), axis=1)
    ends = ends[np.any(ends[:, 0] != ends[:, 1], axis=1)]
    return Linework(ends, np.full(len(ends), level, np.int64), np.tile(gated, (len(ends), 1)))
