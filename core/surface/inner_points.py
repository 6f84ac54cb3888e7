"""Further vertices for wide sheets: points of a lattice that are far enough from all contours.

Where neighbouring contours are far apart (caps, shoulders, saddles), triangles between them alone
could not follow the surface's shape.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.surface.heights import signed_distances
from core.surface.linework import Linework
from core.surface.overlay import Overlay, SlabEnds

__all__ = ["inner_points"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SPACING = 3.0  # typical edges of the contours
LEAST = 1.0 / 200.0  # of the extent: finer lattices show nothing more
CLEAR = 0.7  # spacings from the borders, at least


def inner_points(overlay: Overlay, lines: Linework, slabs: Sequence[SlabEnds]) -> list[Ints]:
    """Lattice points (M, 2) for each slab, inside the regions of which only one is solid."""
    chosen = overlay.triangles[overlay.inside[:, 0] != overlay.inside[:, 1]]
    corners = overlay.points[overlay.node[chosen]]
    spacing = _spacing(lines, corners)
    row, point = _lattice_points(corners, spacing)
    slab = overlay.slab[chosen[row, 0]]
    rows = np.unique(np.column_stack((slab, point)), axis=0)
    slab, point = rows[:, 0], rows[:, 1:]
    order = np.argsort(lines.level, kind="stable")
    levels = np.array([each.levels for each in slabs])[slab]
    starts = np.searchsorted(lines.level[order], np.arange(int(levels.max(initial=0)) + 2))
    ends = lines.ends[order].astype(np.float64)
    far = np.ones(len(point), np.bool_)
    for k in range(2):
        far &= (
            np.abs(signed_distances(point.astype(np.float64), levels[:, k], ends, starts)) >= CLEAR * spacing
        )
    slab, point = slab[far], point[far]
    return np.split(point, np.searchsorted(slab, np.arange(1, len(slabs))))


def _spacing(lines: Linework, corners: Ints) -> int:
    """Of the lattice, in grid units: such that its points are not more than the contours' edges."""
    length = np.sort(np.hypot(*(lines.ends[:, 1] - lines.ends[:, 0]).T))
    # Half of the contours' length is in shorter edges, half in longer ones.
    typical = length[np.searchsorted(np.cumsum(length), length.sum() / 2.0)]
    u, v = (corners[:, k] - corners[:, 0] for k in (1, 2))
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2.0
    extent = np.ptp(lines.ends.reshape(-1, 2), axis=0).max()
    return int(max(SPACING * typical, LEAST * extent, np.sqrt(area / len(lines))))


def _lattice_points(corners: Ints, spacing: int) -> tuple[Ints, Ints]:
    """Triangles (T, 3, 2) and the lattice points in them: indices (M,), and points (M, 2)."""
    low = -(-corners.min(axis=1) // spacing)
    size = np.maximum(corners.max(axis=1) // spacing - low + 1, 0)
    count = size.prod(axis=1)
    row = np.repeat(np.arange(len(corners)), count)
    number = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    step = np.column_stack((number % np.maximum(size[row, 0], 1), number // np.maximum(size[row, 0], 1)))
    point = (low[row] + step) * spacing
    inside = np.ones(len(row), np.bool_)
    for k in range(3):
        a, b = corners[row, k], corners[row, (k + 1) % 3]
        u, v = b - a, point - a
        inside &= u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] >= 0
    return row[inside], point[inside]
