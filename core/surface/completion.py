"""Levels that were not seen whole, completed from their neighbours (§5.1.1).

The contours between the neighbours tell which loops there are and how they run; where the level has
samples of its own they tell where: each place of a loop moves onto the level's own curve if that lies
near and runs alike, and elsewhere by what the places at both ends of the gap have moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.surface.draft import Draft
from core.surface.interpolated import Stratum, between, closest, resampled, signed_distances

__all__ = ["completed_loops"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_CELLS = 256  # of the grid of distances, along the longer edge
_NOISE = 6.0  # standard deviations beyond which a curve is not the one that the neighbours tell of
_STEEP = 2.0  # how far a contour moves from level to level, in distances between them, beyond what is seen
_MOSTLY = 0.5  # share of a contour that must have been seen where it has a neighbour on one side only
_ALIKE = 0.7  # cosine between directions of a contour and of its neighbours'
_GAP = 8.0  # mean distances between samples: a curve without samples that near was not seen
_FADE = 2.0  # way, in distances between the neighbours, over which what the end of a gap tells fades
_ACROSS = 0.5  # of an offset's length may lie along the curve: more is the way round an open end


def completed_loops(
    draft: Draft, points: Floats, below: Sequence[Draft], above: Sequence[Draft]
) -> list[Floats]:
    """Return the contours of an incomplete level.

    Parameters
    ----------
    draft : Draft
        What the level says by itself; it may be nothing.
    points : (N, 2) array
        Its samples, in the plane.
    below, above : sequences of Draft
        Complete levels, the nearest first; two of each are enough, and one of them may be empty.

    Returns
    -------
    list of (M, 2) arrays
        Closed, without crossings. Empty when both are empty, and beyond the last complete level where less
        than half of the contours was seen: nobody knows whether they go on.
    """
    guide = _guide(draft, below, above)
    own = _own(draft)
    neighbours = [*below[:1], *above[:1]]
    if not guide or not own or not len(points):
        return guide if len(neighbours) == 2 else []
    limit = max(_NOISE * draft.sigma, _GAP * draft.spacing)
    step = min(_step(guide), limit)
    fine = [resampled(one, step, closed=False) for one in own]
    supported = cKDTree(points)
    feet = [closest(fine, one, closed=False) for one in guide]
    seen = [
        _is_seen(one, *foot, _reach(one, draft, neighbours)) & (supported.query(foot[0])[0] <= limit)
        for one, foot in zip(guide, feet, strict=True)
    ]
    if len(neighbours) == 1 and np.concatenate(seen).mean() < _MOSTLY:
        return []
    fade = np.inf if len(neighbours) == 1 else _FADE * (neighbours[1].height - neighbours[0].height)
    fitted = [
        one + _carried(one, foot[0] - one, mask, limit, fade)
        for one, foot, mask in zip(guide, feet, seen, strict=True)
    ]
    return fitted if _is_simple(fitted) else guide


def _guide(draft: Draft, below: Sequence[Draft], above: Sequence[Draft]) -> list[Floats]:
    """Return the contours that the neighbours tell of, with vertices close to each other."""
    near = [*below[:1], *above[:1]]
    if not near or not all(one.loops for one in near):
        return []
    every = np.concatenate([curve.vertices for one in near for curve in one.loops])
    pitch = float(np.ptp(every, axis=0).max()) / _CELLS
    if len(near) == 1:
        loops = [curve.vertices for curve in near[0].loops]
    else:
        strata = [Stratum(one.height, [curve.vertices for curve in one.loops]) for one in _used(below, above)]
        loops = between(strata, draft.height, pitch)
    return [resampled(loop, pitch, closed=True) for loop in loops]


def _used(below: Sequence[Draft], above: Sequence[Draft]) -> list[Draft]:
    """Return the levels to interpolate from: two on each side where they have as many contours."""
    four = [*reversed(below[:2]), *above[:2]]
    same = len({len(one.loops) for one in four}) == 1
    return four if len(four) == 4 and same else [below[0], above[0]]


def _own(draft: Draft) -> list[Floats]:
    """Return the level's own curves; closed ones with their first vertex repeated."""
    closed = [np.vstack((one.vertices, one.vertices[:1])) for one in draft.loops]
    return closed + [one.vertices for one in draft.loose if len(one.vertices) > 1]


def _step(loops: Sequence[Floats]) -> float:
    """Return the mean distance between vertices."""
    steps = [np.linalg.norm(np.roll(one, -1, axis=0) - one, axis=1) for one in loops]
    return float(np.concatenate(steps).mean())


def _reach(loop: Floats, draft: Draft, neighbours: Sequence[Draft]) -> Floats:
    """Return how far the level's own curve may lie from each vertex."""
    result = np.full(len(loop), _NOISE * draft.sigma)
    for one in neighbours:
        result += np.abs(signed_distances([curve.vertices for curve in one.loops], loop))
        if len(neighbours) == 1:
            result += _STEEP * abs(one.height - draft.height)
    return result


def _is_seen(loop: Floats, feet: Floats, along: Floats, reach: Floats) -> Bools:
    """Tell for each vertex whether its foot on the level's own curves is a place of the same contour."""
    offset = feet - loop
    way = np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), np.finfo(float).tiny)
    size = np.linalg.norm(offset, axis=1)
    across = np.abs(np.einsum("ij,ij->i", offset, along)) <= _ACROSS * size + 1e-9 * reach
    alike = np.abs(np.einsum("ij,ij->i", way, along)) >= _ALIKE
    return np.asarray((size <= reach) & across & alike)


def _carried(loop: Floats, offset: Floats, seen: Bools, margin: float, fade: float) -> Floats:
    """Return the offsets where they were seen, and in gaps what both ends tell, fading with the way.

    What was seen within ``margin`` of a gap does not count: ends of curves are their worst parts.
    """
    steps = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    arc, length = np.cumsum(steps) - steps, float(steps.sum())
    seen = seen & (_way_to(arc, ~seen, length) > margin)
    if not seen.any():
        return np.zeros_like(offset)
    columns = [np.interp(arc, arc[seen], offset[seen, k], period=length) for k in range(2)]
    return np.stack(columns, axis=1) * np.exp(-_way_to(arc, seen, length) / fade)[:, None]


def _way_to(arc: Floats, marked: Bools, length: float) -> Floats:
    """Return the way along a closed curve from each vertex to the nearest marked one."""
    places = arc[marked]
    if not len(places):
        return np.full(len(arc), np.inf)
    around = np.concatenate((places - length, places, places + length))
    after = np.searchsorted(around, arc)
    return np.asarray(np.minimum(around[after] - arc, arc - around[after - 1]))


def _is_simple(loops: Sequence[Floats]) -> bool:
    """Tell whether closed curves cross neither themselves nor each other."""
    return bool(shapely.MultiLineString([np.vstack((one, one[:1])) for one in loops]).is_simple)
