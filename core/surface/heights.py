"""How high the surface is inside a slab, from the distances of a place to the contours around it.

Between two contours, the height is a monotone cubic function of the signed distance (Fritsch and
Butland 1984), which knows of the slopes from the next contours below and above. A cap is a paraboloid
whose slope at its border is that of the slab before; where that says that it would reach the next
plane, the top is flat for all that is known: it rises at 45 degrees, half the way at most. Where it is
known from elsewhere how high the surface is, that counts, the more the farther away the contours are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.surface.borders import Borders, signed_distances
from core.surface.linework import Grid
from core.surface.overlay import SlabEnds

__all__ = ["Passes", "Places", "heights_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

Passes = Callable[[Floats, Floats, Floats], Floats]
"""Heights at which the surface is left over places (M, 2) from heights (M,) to others; NaN: not known."""

CLEAR = 0.02  # of a slab's height: places keep off the planes
NEAR = 0.25  # of a slab's height: that near to contours these know best
FLAT = 2.0  # slabs: a cap that would be higher is a flat top


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Places strictly inside slabs.

    Attributes
    ----------
    xy : (M, 2) array
        Grid coordinates.
    slab : (M,) array of int
    part : (M,) array of int
        Number of the connected part of the sheet.
    reached : (2, M) array of bool
        Whether the part has a border in the lower plane, in the upper one.
    """

    xy: Floats
    slab: Ints
    part: Ints
    reached: Bools


def heights_of(
    places: Places, borders: Borders, slabs: Sequence[SlabEnds], grid: Grid, passes: Passes | None = None
) -> Floats:
    """Heights (M,) of places, strictly between the planes of their slabs.

    ``passes`` takes places in the frame of the levels.
    """
    levels, z = _around(slabs)
    levels, z = levels[places.slab], z[places.slab]
    distance = grid.pitch * np.column_stack(
        [signed_distances(places.xy, levels[:, k], borders) for k in range(4)]
    )
    share = np.empty(len(places.xy))
    both = places.reached.all(axis=0)
    share[both] = _between(distance[both], z[both])
    for end in range(2):
        only = places.reached[end] & ~both
        # Seen from its border, a cap that hangs down is one that rises.
        near, before = 1 + end, 3 * end
        rise = _cap(distance[only][:, [before, near]], z[only][:, [before, near, 2 - end]], places.part[only])
        share[only] = rise if end == 0 else 1.0 - rise
    if passes is not None:
        share = _shown(share, grid.placed(places.xy), distance[:, 1:3], z[:, 1:3], passes)
    return z[:, 1] + (z[:, 2] - z[:, 1]) * np.clip(share, CLEAR, 1.0 - CLEAR)


def _shown(share: Floats, xy: Floats, distance: Floats, z: Floats, passes: Passes) -> Floats:
    """How far up the slab the surface is where that is shown, the less the nearer contours are."""
    rise = z[:, 1] - z[:, 0]
    away = np.clip(np.abs(distance).min(axis=1) / rise - NEAR, 0.0, 1.0)
    hanging = distance[:, 1] > 0.0  # over the upper level's region, which the surface is below
    some = np.flatnonzero(away > 0.0)
    start = np.where(hanging, z[:, 1], z[:, 0])[some]
    end = np.where(hanging, z[:, 0], z[:, 1])[some]
    found = (passes(xy[some], start, end) - z[some, 0]) / rise[some]
    known = np.isfinite(found)
    some, weight = some[known], away[some[known]]
    result = share.copy()
    result[some] += weight * (found[known] - share[some])
    return result


def _around(slabs: Sequence[SlabEnds]) -> tuple[Ints, Floats]:
    """Levels and heights (S, 4) of the contours before, at both ends of, and after slabs; -1, NaN: none."""
    heights = {level: z for slab in slabs for level, z in zip(slab.levels, slab.heights, strict=True)}
    levels = np.full((len(slabs), 4), -1)
    for row, slab in zip(levels, slabs, strict=True):
        step = slab.levels[1] - slab.levels[0]
        row[1:3] = slab.levels
        for k, level in ((0, slab.levels[0] - step), (3, slab.levels[1] + step)):
            row[k] = level if level in heights else -1
    return levels, np.array([[heights.get(int(level), np.nan) for level in row] for row in levels])


def _between(distance: Floats, z: Floats) -> Floats:
    """How far up the slab the signed distance is zero: (M, 4) distances and heights of contours."""
    with np.errstate(invalid="ignore", divide="ignore"):
        step = np.diff(distance, axis=1)
        secant = np.diff(z, axis=1) / step
        slopes = []
        for k in (0, 2):
            near, far = 2.0 * step[:, 1] + step[:, k], step[:, 1] + 2.0 * step[:, k]
            slope = (near + far) / (near / secant[:, k] + far / secant[:, 1])
            smooth = np.isfinite(slope) & (secant[:, k] * secant[:, 1] > 0.0)
            slopes.append(np.where(smooth, slope, secant[:, 1]))
    along = -distance[:, 1] / step[:, 1]
    rise = z[:, 2] - z[:, 1]
    begin, end = (slope * step[:, 1] / rise for slope in slopes)
    cubic = begin + end - 2.0
    share: Floats = along * (begin + along * (3.0 - 2.0 * begin - end + along * cubic))
    return share


def _cap(distance: Floats, z: Floats, part: Ints) -> Floats:
    """How far up the slab caps are: distances from the border before and the own one (M, 2), heights."""
    if not len(part):
        return np.zeros(0)
    rise = np.abs(z[:, 2] - z[:, 1])
    deep = np.abs(distance[:, 1])
    width = np.zeros(int(part.max()) + 1)
    np.maximum.at(width, part, deep)
    with np.errstate(invalid="ignore", divide="ignore"):
        run = np.where(distance[:, 0] * distance[:, 1] > 0.0, np.abs(distance[:, 0]) - deep, -np.inf)
        run = (np.bincount(part, run) / np.bincount(part))[part]
        slope = np.abs(z[:, 1] - z[:, 0]) / run * width[part] / (width[part] + run / 2.0)
        high = slope * width[part] / 2.0 / rise
    high = np.where(np.isfinite(high) & (run > 0.0), high, FLAT)
    dome = np.where(high < 1.0, high, 1.5 - high / 2.0) * (1.0 - (1.0 - deep / width[part]) ** 2)
    return np.where(high < FLAT, dome, np.minimum(1.0, 2.0 * deep / rise) / 2.0)
