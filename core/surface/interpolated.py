"""Contours between levels: signed distances, interpolated along the axis (§5.1.1).

Between heights z0 and z1 with signed distances f0 and f1 to their contours (negative inside) the contour
at z is where ((z1 - z) f0 + (z - z0) f1) / (z1 - z0) is zero: closed curves, whatever joins or parts.
Where levels beyond these two have as many contours, the parabola or cubic through all goes on
around bends, from which the straight line errs by half the curvature times (z - z0) (z1 - z).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

__all__ = ["Stratum", "between", "closest", "resampled", "signed_distances", "steps_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST_NODES = 400_000  # of the grid


@dataclass(frozen=True, slots=True, eq=False)
class Stratum:
    """A level to interpolate from: its height, and its closed contours, (M, 2) arrays."""

    height: float
    loops: Sequence[Floats]


def between(strata: Sequence[Stratum], height: float, pitch: float) -> list[Floats]:
    """Return the closed contours at a height between levels.

    Parameters
    ----------
    strata : two to four of Stratum
        Ascending; one or two of them below the height, and above it. Contours do not repeat their first
        vertex; inside is what an odd number of them encloses.
    height : float
    pitch : float
        Of the grid on which distances are interpolated; larger where too many nodes would be needed. On
        curves of radius r the contours err by about pitch² / (8 r).

    Returns
    -------
    list of (M, 2) arrays
        Without loops of less than about a cell.
    """
    from skimage.measure import find_contours  # noqa: PLC0415 # half a second, and only for levels with gaps

    every = np.concatenate([loop for one in strata for loop in one.loops])
    low, extent = every.min(axis=0), np.ptp(every, axis=0)
    pitch = max(pitch, float(np.sqrt(np.prod(extent + pitch) / _MOST_NODES)))
    low = low - 2.0 * pitch
    shape = np.ceil((extent + 4.0 * pitch) / pitch).astype(int) + 1
    nodes = low + pitch * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 2)
    values = _field(strata, height, nodes, pitch).reshape(shape)
    values[values == 0.0] = np.finfo(float).tiny  # no contour runs through a node
    loops = find_contours(values, 0.0)  # type: ignore[no-untyped-call]
    return [low + pitch * loop[:-1] for loop in loops if len(loop) > 4]


def _field(strata: Sequence[Stratum], height: float, nodes: Floats, pitch: float) -> Floats:
    """Interpolate signed distances at nodes: exact near the contours, elsewhere as far as the sign goes.

    Nodes farther from all contours than these are from each other are inside all of them, or outside.
    """
    dense = [[_dense(loop, pitch) for loop in one.loops] for one in strata]
    every = [np.concatenate(loops) for loops in dense]
    trees = [cKDTree(one) for one in every]
    apart = max(float(np.max(tree.query(one)[0])) for one in every for tree in trees)
    band = 1.5 * apart + 2.0 * pitch
    near = np.isfinite(cKDTree(np.concatenate(every)).query(nodes, distance_upper_bound=band)[0])
    values = np.where(_inside(dense[0], nodes), -band, band)
    heights = np.array([one.height for one in strata])
    values[near] = _interpolated([signed_distances(loops, nodes[near]) for loops in dense], heights, height)
    return values


def _interpolated(fields: Sequence[Floats], heights: Floats, height: float) -> Floats:
    """Interpolate values at heights: straight, or by the parabola or cubic unless that goes astray."""
    inner = int(np.searchsorted(heights, height))
    below, above = fields[inner - 1], fields[inner]
    share = (height - heights[inner - 1]) / (heights[inner] - heights[inner - 1])
    straight = np.asarray((1.0 - share) * below + share * above)
    if len(fields) == 2:
        return straight
    curved = np.zeros_like(straight)
    for k, field in enumerate(fields):
        others = np.delete(heights, k)
        curved += np.prod((height - others) / (heights[k] - others)) * field
    # contours that bend move from level to level by more than the curve differs from the straight line
    steps = [np.abs(fields[k] - fields[k - 1]) for k in range(1, len(fields))]
    most = sum(steps[1:], steps[0]) / 2.0
    return np.asarray(straight + np.clip(curved - straight, -most, most))


def _dense(loop: Floats, spacing: float) -> Floats:
    """Return a closed curve with more vertices on edges longer than ``spacing``."""
    return np.asarray(shapely.get_coordinates(shapely.segmentize(shapely.LinearRing(loop), spacing))[:-1])


def signed_distances(loops: Sequence[Floats], points: Floats) -> Floats:
    """Return the distances of (N, 2) points to closed contours, negative inside (even-odd)."""
    distance = np.linalg.norm(points - closest(loops, points)[0], axis=1)
    return np.asarray(np.where(_inside(loops, points), -distance, distance), np.float64)


def _inside(loops: Sequence[Floats], points: Floats) -> NDArray[np.bool_]:
    """Tell which points an odd number of closed contours encloses."""
    inside = np.zeros(len(points), np.bool_)
    for loop in loops:
        ring = shapely.Polygon(loop)
        shapely.prepare(ring)
        inside ^= shapely.contains_xy(ring, points)
    return inside


def closest(loops: Sequence[Floats], points: Floats, closed: bool = True) -> tuple[Floats, Floats]:
    """Return the places on polylines that are closest to (N, 2) points, and the directions there, either way.

    The nearest vertex is found first, then the place on the two segments that meet there: exact where the
    vertices lie closer together than branches do.
    """
    vertices = np.concatenate(loops)
    starts = np.cumsum([0, *map(len, loops)])
    after = np.arange(1, len(vertices) + 1)
    after[starts[1:] - 1] = starts[:-1] if closed else starts[1:] - 2
    before = np.arange(-1, len(vertices) - 1)
    before[starts[:-1]] = starts[1:] - 1 if closed else starts[:-1] + 1
    nearest = cKDTree(vertices).query(points)[1]
    ahead, way_ahead = _onto(vertices[nearest], vertices[after[nearest]], points)
    behind, way_behind = _onto(vertices[before[nearest]], vertices[nearest], points)
    better = np.linalg.norm(ahead - points, axis=1) <= np.linalg.norm(behind - points, axis=1)
    return np.where(better[:, None], ahead, behind), np.where(better[:, None], way_ahead, way_behind)


def _onto(start: Floats, end: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Return the nearest places on segments, and the unit directions of the segments."""
    way = end - start
    square = np.einsum("ij,ij->i", way, way)
    share = np.einsum("ij,ij->i", points - start, way) / np.where(square > 0.0, square, 1.0)
    length = np.sqrt(np.where(square > 0.0, square, 1.0))
    return start + np.clip(share, 0.0, 1.0)[:, None] * way, way / length[:, None]


def steps_of(loop: Floats) -> Floats:
    """Return the lengths of the edges of a closed polyline (M, 2) that does not repeat its first vertex."""
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))


def resampled(line: Floats, spacing: float, closed: bool) -> Floats:
    """Return a polyline with vertices equally far apart, about ``spacing``, in arc length."""
    whole = np.vstack((line, line[:1])) if closed else line
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(whole, axis=0), axis=1))))
    count = max(int(np.ceil(arc[-1] / spacing)), 3) + (not closed)
    wanted = np.linspace(0.0, arc[-1], count, endpoint=not closed)
    return np.stack([np.interp(wanted, arc, whole[:, k]) for k in range(2)], axis=1)
