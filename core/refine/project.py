"""Feet of samples on polylines: the nearest point of the nearest segment, in linear time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["Feet", "distance_to_segment", "project"]

_MOST_CELLS = 2_000_000
CELL = 0.25  # edge of a cell, in reaches: smaller cells leave fewer segments to a point,
FINE_CELL = 0.08  # and cost more to fill, which
CROWD = 100_000  # samples are worth


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Where samples project to, in arrays of length N.

    Attributes
    ----------
    curve : (N,) array of int
        Nearest polyline; -1 where none is within reach.
    station : (N,) array
        Arc length of the foot along it.
    distance : (N,) array
        Distance to the foot; infinite out of reach.
    other : (N,) array
        Distance to the nearest other polyline; infinite out of reach, and when not asked for.
    """

    curve: NDArray[np.int64]
    station: NDArray[np.float64]
    distance: NDArray[np.float64]
    other: NDArray[np.float64]


def project(
    points: NDArray[np.float64], polylines: Sequence[Polyline], reach: float, rivals: bool = False
) -> Feet:
    """Find the foot of every sample on the polylines.

    Parameters
    ----------
    points : (N, 3) array
    polylines : sequence of Polyline
    reach : float
        Samples farther than this from all polylines have no foot.
    rivals : bool
        Whether to find the distance to the nearest other polyline too; it costs time.
    """
    heads, tails, curves, stations = [], [], [], []
    for index, line in enumerate(polylines):
        a, b = line.segments()
        heads.append(a)
        tails.append(b)
        curves.append(np.full(len(a), index, np.int64))
        stations.append(line.stations[:-1])
    a, b = np.concatenate(heads), np.concatenate(tails)
    low = np.minimum(a.min(axis=0), b.min(axis=0)) - 1.001 * reach
    extent = np.maximum(a.max(axis=0), b.max(axis=0)) + 1.001 * reach - low
    fine = FINE_CELL if len(points) >= CROWD else CELL
    cell = reach if rivals or len(points) <= len(a) else reach * fine
    # Cells far smaller than the segments would be many and hold the same few.
    cell = max(cell, 0.25 * float(np.median(np.linalg.norm(b - a, axis=1))))
    size = extent / cell
    if a[0, 2] == points[0, 2] and not np.any(np.ptp(a, axis=0)[2]) and not np.any(np.ptp(points[:, 2])):
        size[2] = 0.0  # a plane needs one layer only
    while np.prod(size + 1.0) > _MOST_CELLS:
        cell *= 1.25
        size /= 1.25
    shape = size.astype(np.int64) + 1
    starts, members = _cover(a, b, low, extent, cell, shape, reach, rivals)
    return Feet(
        *_nearest(
            points, a, b, np.linalg.norm(b - a, axis=1), np.concatenate(curves), np.concatenate(stations),
            low, extent, cell, shape, starts, members, reach,
        )
    )  # fmt: skip


@njit(cache=True, inline="always")
def _cell_of(x, low, extent, cell, size):  # type: ignore[no-untyped-def]
    """Index of a coordinate's cell along one axis; -1 outside. A single layer holds everything."""
    if not (low <= x <= low + extent):
        return -1
    return min(int((x - low) / cell), size - 1)


@njit(cache=True)
def distance_to_segment(px, py, pz, a, b, s):  # type: ignore[no-untyped-def]
    """Squared distance of a point to segment ``s``, and the foot's fraction along it."""
    ux, uy, uz = b[s, 0] - a[s, 0], b[s, 1] - a[s, 1], b[s, 2] - a[s, 2]
    dx, dy, dz = px - a[s, 0], py - a[s, 1], pz - a[s, 2]
    square = ux * ux + uy * uy + uz * uz
    t = min(max((dx * ux + dy * uy + dz * uz) / square, 0.0), 1.0) if square > 0.0 else 0.0
    dx, dy, dz = dx - t * ux, dy - t * uy, dz - t * uz
    return dx * dx + dy * dy + dz * dz, t


@njit(cache=True)
def _cover(a, b, low, extent, cell, shape, reach, rivals):  # type: ignore[no-untyped-def]
    """For each cell the segments that may be nearest to a point in it (all within reach for rivals)."""
    starts, members = _boxes(a, b, low, extent, cell, shape, reach)
    if rivals:
        return starts, members
    half = np.empty(3)
    for k in range(3):
        half[k] = 0.5 * (cell if shape[k] > 1 else 0.0)
    radius = np.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    kept = 0
    distance = np.empty(64)
    for c in range(starts.shape[0] - 1):
        first, last = starts[c], starts[c + 1]
        starts[c] = kept
        if last - first > distance.shape[0]:
            distance = np.empty(2 * (last - first))
        iz = c % shape[2]
        iy = (c // shape[2]) % shape[1]
        ix = c // (shape[2] * shape[1])
        x = low[0] + (ix + 0.5) * (cell if shape[0] > 1 else extent[0])
        y = low[1] + (iy + 0.5) * (cell if shape[1] > 1 else extent[1])
        z = low[2] + (iz + 0.5) * (cell if shape[2] > 1 else extent[2])
        least = np.inf
        for j in range(first, last):
            square, _ = distance_to_segment(x, y, z, a, b, members[j])
            distance[j - first] = np.sqrt(square)
            least = min(least, distance[j - first])
        for j in range(first, last):
            if distance[j - first] <= least + 2.0 * radius:
                members[kept] = members[j]
                kept += 1
    starts[-1] = kept
    return starts, members[:kept]


@njit(cache=True)
def _boxes(a, b, low, extent, cell, shape, reach):  # type: ignore[no-untyped-def]
    """For each cell the segments whose bounding box, widened by the reach, meets it."""
    starts = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    members = np.empty(0, np.int64)
    for filling in range(2):
        if filling:
            for c in range(starts.shape[0] - 1, 0, -1):
                starts[c] = starts[c - 1]
            starts[0] = 0
            for c in range(starts.shape[0] - 1):
                starts[c + 1] += starts[c]
            members = np.empty(starts[-1], np.int64)
            cursor = starts[:-1].copy()
        else:
            cursor = starts
        for s in range(a.shape[0]):
            x0 = _cell_of(min(a[s, 0], b[s, 0]) - reach, low[0], extent[0], cell, shape[0])
            y0 = _cell_of(min(a[s, 1], b[s, 1]) - reach, low[1], extent[1], cell, shape[1])
            z0 = _cell_of(min(a[s, 2], b[s, 2]) - reach, low[2], extent[2], cell, shape[2])
            x1 = _cell_of(max(a[s, 0], b[s, 0]) + reach, low[0], extent[0], cell, shape[0])
            y1 = _cell_of(max(a[s, 1], b[s, 1]) + reach, low[1], extent[1], cell, shape[1])
            z1 = _cell_of(max(a[s, 2], b[s, 2]) + reach, low[2], extent[2], cell, shape[2])
            for ix in range(x0, x1 + 1):
                for iy in range(y0, y1 + 1):
                    for iz in range(z0, z1 + 1):
                        c = (ix * shape[1] + iy) * shape[2] + iz
                        if filling:
                            members[cursor[c]] = s
                        cursor[c] += 1
    return starts, members


@njit(cache=True)
def _nearest(points, a, b, lengths, curves, stations, low, extent, cell, shape, starts, members, reach):  # type: ignore[no-untyped-def]
    """Nearest segment of every point, and the distance to the nearest other curve."""
    n = points.shape[0]
    curve = np.full(n, -1, np.int64)
    station = np.zeros(n)
    distance = np.full(n, np.inf)
    other = np.full(n, np.inf)
    for i in range(n):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        ix = _cell_of(px, low[0], extent[0], cell, shape[0])
        iy = _cell_of(py, low[1], extent[1], cell, shape[1])
        iz = _cell_of(pz, low[2], extent[2], cell, shape[2])
        if ix < 0 or iy < 0 or iz < 0:
            continue
        c = (ix * shape[1] + iy) * shape[2] + iz
        best, second = reach * reach, reach * reach
        for j in range(starts[c], starts[c + 1]):
            s = members[j]
            d2, t = distance_to_segment(px, py, pz, a, b, s)
            if d2 < best:
                if curve[i] >= 0 and curves[s] != curve[i]:
                    second = best
                best = d2
                curve[i] = curves[s]
                station[i] = stations[s] + t * lengths[s]
            elif d2 < second and curves[s] != curve[i]:
                second = d2
        if curve[i] >= 0:
            distance[i] = np.sqrt(best)
            if second < reach * reach:
                other[i] = np.sqrt(second)
    return curve, station, distance, other
