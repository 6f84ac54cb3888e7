"""Further vertices for wide sheets: points of a lattice that are far enough from all contours.

Where neighbouring contours are far apart (caps, shoulders, saddles), triangles between them alone
could not follow the surface's shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.surface.borders import Borders, signed_distances
from core.surface.linework import Linework
from core.surface.overlay import SlabEnds, edges_by_slab

__all__ = ["inner_points"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

SPACING = 3.0  # typical edges of the contours
STEEP = 2.0  # heights of a slab: flat parts between steep ones need points that near to their borders
LEAST = 1.0 / 200.0  # of the extent: finer lattices show nothing more
CLEAR = 0.7  # spacings from the borders, at least


def inner_points(lines: Linework, borders: Borders, slabs: Sequence[SlabEnds], pitch: float) -> list[Ints]:
    """Lattice points (M, 2) for each slab, inside the regions of which only one is solid.

    ``pitch`` is that of the grid, in units of the heights.
    """
    length = np.sort(np.hypot(*(lines.ends[:, 1] - lines.ends[:, 0]).T))
    # Half of the contours' length is in shorter edges, half in longer ones.
    typical = length[np.searchsorted(np.cumsum(length), length.sum() / 2.0)]
    extent = np.ptp(lines.ends.reshape(-1, 2), axis=0).max()
    high = float(np.median([each.heights[1] - each.heights[0] for each in slabs])) / pitch
    spacing = int(max(min(SPACING * typical, STEEP * high), LEAST * extent))
    chords = _chords(lines, slabs, spacing)
    # No more points than the contours have edges.
    area = float(spacing * (chords.stop - chords.start).sum())
    if area > len(lines) * spacing**2:
        spacing = int(np.sqrt(area / len(lines)))
        chords = _chords(lines, slabs, spacing)
    slab, point = _on(chords, spacing)
    far = _are_far(borders, slabs, slab, point, CLEAR * spacing)
    slab, point = slab[far], point[far]
    return np.split(point, np.searchsorted(slab, np.arange(1, len(slabs))))


@dataclass(frozen=True, slots=True, eq=False)
class _Chords:
    """Where rows of the lattice lie inside one region only: slab, row, and from where to where (M,)."""

    slab: Ints
    row: Ints
    start: Floats
    stop: Floats


def _chords(lines: Linework, slabs: Sequence[SlabEnds], spacing: int) -> _Chords:
    """By slab and row; a vertex on a row counts as above it."""
    edges, slab, _ = edges_by_slab(slabs)
    a, b = lines.ends[edges, 0], lines.ends[edges, 1]
    low, high = np.minimum(a[:, 1], b[:, 1]) // spacing, np.maximum(a[:, 1], b[:, 1]) // spacing
    edge = np.repeat(np.arange(len(edges)), high - low)
    row = _ranges(low + 1, high - low)
    share = (row * spacing - a[edge, 1]) / (b - a)[edge, 1]
    x = a[edge, 0] + share * (b - a)[edge, 0]
    order = np.lexsort((x, row, slab[edge]))
    # Each row crosses closed borders an even number of times, and from one crossing to the next is
    # in turn inside one region, and inside both or none.
    first, second = order[::2], order[1::2]
    return _Chords(slab[edge[first]], row[first], x[first], x[second])


def _on(chords: _Chords, spacing: int) -> tuple[Ints, Ints]:
    """The slabs (M,) and points (M, 2) of the lattice on chords."""
    low = np.ceil(chords.start / spacing).astype(np.int64)
    count = np.maximum(np.floor(chords.stop / spacing).astype(np.int64) - low + 1, 0)
    column, row = _ranges(low, count), np.repeat(chords.row, count)
    return np.repeat(chords.slab, count), np.column_stack((column, row)) * spacing


def _are_far(borders: Borders, slabs: Sequence[SlabEnds], slab: Ints, point: Ints, least: float) -> Bools:
    """Whether points are so far from both borders of their slabs."""
    levels = np.array([each.levels for each in slabs])[slab]
    xy = point.astype(np.float64)
    below, above = (np.abs(signed_distances(xy, levels[:, k], borders)) >= least for k in range(2))
    return below & above


def _ranges(starts: Ints, sizes: Ints) -> Ints:
    """The numbers start, start + 1, ... of all ranges, one after another."""
    return np.repeat(starts - (np.cumsum(sizes) - sizes), sizes) + np.arange(int(sizes.sum()))
