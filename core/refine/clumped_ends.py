"""Ends of open curves that run into a clump of outliers: its samples are not the curve's.

Where the clump begins the samples suddenly lie farther from the curve, all round. From the end
inward, the likelihood that they come from a wider cloud than the curve's noise is summed up; the
largest sum, when it is no chance, tells how far the clump reaches. Where half of the samples are rather
the curve's, it goes on through the clump.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc

__all__ = ["FARTHEST", "clumped"]

Floats = NDArray[np.float64]

SCALES = (1.75, 2.5, 4.0)  # widths of clumps, in sigma
FARTHEST = 24.0  # in sigma: how far a clump reaches along a curve
MOST = 0.3  # of the curve's length
LEAST_SAMPLES = 8
BACKGROUND = 0.05  # share of scattered outliers within the cut
CERTAIN = 9.0  # nats
ROUND = 1.4  # in sigma: least spread of a clump across its own length


def clumped(
    points: Floats,
    station: Floats,
    relative: Floats,
    span: tuple[float, float],
    sigma: float,
    cut: float,
    normals: int,
) -> NDArray[np.bool_]:
    """Tell which samples of an open curve lie in a clump at one of its ends.

    Parameters
    ----------
    points : (N, 3) array
    station : (N,) array
        Arc lengths of their feet.
    relative : (N,) array
        Distances to their feet in units of the noise there, less than ``cut``.
    span : (float, float)
        Stations where the curve begins and ends.
    sigma : float
        Typical noise.
    cut : float
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    """
    out = np.zeros(len(station), np.bool_)
    reach = min(FARTHEST * sigma, MOST * (span[1] - span[0]))
    for inward in (station - span[0], span[1] - station):
        near = np.flatnonzero(inward < reach)
        near = near[np.argsort(inward[near], kind="stable")]
        count = _reach(relative[near], cut, normals)
        if count and _is_round(points[near[:count]], normals, sigma):
            out[near[:count]] = True
    return out


def _reach(relative: Floats, cut: float, normals: int) -> int:
    """Number of the foremost samples that come from a clump."""
    if len(relative) < LEAST_SAMPLES:
        return 0
    ratios = [
        _density(relative, scale, cut, normals) / _density(relative, 1.0, cut, normals) for scale in SCALES
    ]
    gains = [np.cumsum(np.log(ratio)) for ratio in ratios]
    gain = max(gains, key=lambda one: float(one.max()))
    count = int(np.argmax(gain)) + 1
    mixed = max(float(np.log(0.5 + 0.5 * ratio[:count]).sum()) for ratio in ratios)
    return count if gain[count - 1] > max(CERTAIN, mixed) and count >= LEAST_SAMPLES else 0


def _density(relative: Floats, scale: float, cut: float, normals: int) -> Floats:
    """Of samples at these distances, but for a factor that is the same for every scale."""
    within = float(gammainc(0.5 * normals, 0.5 * (cut / scale) ** 2))
    core = np.exp(-0.5 * (relative / scale) ** 2) / scale**normals / within
    even = 0.5 * np.sqrt(2.0 * np.pi) / cut if normals == 1 else 2.0 / cut**2
    return np.asarray((1.0 - BACKGROUND) * core + BACKGROUND * even)


def _is_round(points: Floats, normals: int, sigma: float) -> bool:
    """Whether samples spread across their own length too: else the curve has only missed its samples."""
    offset = points - points.mean(axis=0)
    value = np.linalg.eigvalsh(offset.T @ offset / len(points))[::-1]
    across = float(np.sum(value[1 : 1 + normals])) / normals
    return across > (ROUND * sigma) ** 2
