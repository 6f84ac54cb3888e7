"""Curves of different components that are near each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline

__all__ = ["Approach", "approaches"]

Floats = NDArray[np.float64]

LOOK = 25.0  # in sigma: how far
STEP = 1.0  # in sigma: between places on a curve, at least
FINEST = 0.25  # of the largest noise of all,
MOST_PLACES = 12_000  # and more where places would be too many on all of them
LEAST_PLACES = 16  # on one
FARTHEST = 0.02  # of the extent: what keeps the number of pairs in proportion to that of places
NEAREST = 8.0  # in sigma: at least so far
TIP = 3.0  # in sigma: ends that are near each other are a gap in one curve rather than two branches
MOST = 20


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """A place between two components, their distance there, and the larger noise of both."""

    place: Floats
    gap: float
    sigma: float


def approaches(lines: Sequence[Polyline], groups: Sequence[int], sigmas: Sequence[float]) -> list[Approach]:
    """Find where curves of different components come near each other, the nearest in sigma first.

    Parameters
    ----------
    lines : sequence of Polyline
    groups : sequence of int
        The component of each.
    sigmas : sequence of float
        Noise about each.
    """
    largest = max(sigmas, default=0.0)
    if len(set(groups)) < 2 or not largest > 0.0:
        return []
    most = max(MOST_PLACES // len(lines), LEAST_PLACES)
    steps = [max(STEP * sigma, FINEST * largest) for sigma in sigmas]
    stations = [_stations(line, step, most) for line, step in zip(lines, steps, strict=True)]
    counts = [len(s) for s in stations]
    places = np.concatenate([line.at(s) for line, s in zip(lines, stations, strict=True)])
    group, sigma = np.repeat(groups, counts), np.repeat(sigmas, counts)
    ends = [_is_end(line, s, TIP * noise) for line, s, noise in zip(lines, stations, sigmas, strict=True)]
    end = np.concatenate(ends)
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    reach = min(LOOK * largest, max(FARTHEST * extent, 100.0 / len(places) * extent, NEAREST * largest))
    i, j = cKDTree(places).query_pairs(reach, output_type="ndarray").T
    apart = (group[i] != group[j]) & ~(end[i] & end[j])
    i, j = i[apart], j[apart]
    gap, noise = np.linalg.norm(places[i] - places[j], axis=1), np.maximum(sigma[i], sigma[j])
    rest = np.flatnonzero((noise > 0.0) & (gap < LOOK * noise))
    rest = rest[np.argsort(gap[rest] / noise[rest], kind="stable")]
    middle = 0.5 * (places[i] + places[j])
    out: list[Approach] = []
    while len(rest) and len(out) < MOST:
        k = rest[0]
        out.append(Approach(middle[k], float(gap[k]), float(noise[k])))
        away = np.linalg.norm(middle[rest] - middle[k], axis=1)
        rest = rest[away > max(10.0 * noise[k], 2.0 * gap[k])]
    return out


def _stations(line: Polyline, step: float, most: int) -> Floats:
    count = int(min(max(line.length / step, LEAST_PLACES), most))
    return np.linspace(0.0, line.length, count, endpoint=not line.closed)


def _is_end(line: Polyline, station: Floats, tip: float) -> NDArray[np.bool_]:
    """Which stations are next to an end."""
    if line.closed:
        return np.zeros(len(station), np.bool_)
    return (station <= tip) | (station >= line.length - tip)
