"""Whether a sample is fit for reconstruction: the paper's Nyquist condition (§1), checked on the result.

The noise must stay below half of the smallest detail: here the distance between branches
that are not neighbours along the curve.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline

__all__ = ["LEAST_GAP", "BranchGap", "branch_gaps"]

LEAST_GAP = 4.5  # in sigma: nearer branches are not told apart reliably
_STATIONS = 1500

BranchGap = tuple[NDArray[np.float64], float]


def branch_gaps(curves: Sequence[Polyline], sigma: float, look: float = 25.0) -> list[BranchGap]:
    """Places where two branches come close, the closest first.

    Parameters
    ----------
    curves : sequence of Polyline
    sigma : float
        Noise standard deviation.
    look : float
        How far to look, in sigma.

    Returns
    -------
    list of (location (3,), distance)
        One entry a close stretch, in the units of the curves.
    """
    if not curves or not sigma > 0:
        return []
    stations = [_stations(line, sigma) for line in curves]
    places = np.concatenate([line.at(s) for line, s in zip(curves, stations, strict=True)])
    curve = np.repeat(np.arange(len(curves)), [len(s) for s in stations])
    station = np.concatenate(stations)
    period = np.array([line.length if line.closed else np.inf for line in curves])
    pairs = cKDTree(places).query_pairs(min(look * sigma, _affordable(places)), output_type="ndarray")
    i, j = pairs[:, 0], pairs[:, 1]
    chord = np.linalg.norm(places[i] - places[j], axis=1)
    way = np.abs(station[i] - station[j])
    way = np.where(curve[i] == curve[j], np.minimum(way, period[curve[i]] - way), np.inf)
    # On a circle the way is at most pi / 2 chords: longer ways mean another branch.
    apart = way > 2.0 * chord + 2.0 * sigma
    return _closest_first(places[i[apart]], places[j[apart]], chord[apart], 10.0 * sigma)


def _stations(line: Polyline, sigma: float) -> NDArray[np.float64]:
    count = int(min(max(line.length / max(sigma, 1e-300), 16), _STATIONS))
    return np.linspace(0.0, line.length, count, endpoint=not line.closed)


def _affordable(places: NDArray[np.float64]) -> float:
    """A radius that keeps the number of pairs linear in the number of places."""
    spread = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return max(spread, 1e-300) * max(0.02, min(1.0, 100.0 / len(places)))


def _closest_first(
    a: NDArray[np.float64], b: NDArray[np.float64], chord: NDArray[np.float64], apart: float
) -> list[BranchGap]:
    """The closest pair, then the closest one that is not near a pair already taken, and so on."""
    out: list[BranchGap] = []
    rest = np.argsort(chord)
    while len(rest) and len(out) < 20:
        k = rest[0]
        place = 0.5 * (a[k] + b[k])
        out.append((place, float(chord[k])))
        near = np.minimum(np.linalg.norm(a[rest] - place, axis=1), np.linalg.norm(b[rest] - place, axis=1))
        rest = rest[near > max(apart, 2.0 * chord[k])]
    return out
