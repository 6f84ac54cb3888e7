"""Turns too sharp for the noise: courses of which the samples say that a smooth curve misses them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.across import Across

__all__ = ["Turn", "sharp_turns"]

Floats = NDArray[np.float64]

MISSED = 0.6  # in sigma: how far a smooth course may run beside its samples
WINDOW = 3.0  # in sigma: length over which samples are averaged
LEAST_SAMPLES = 16
CLIPPED = 4.0  # in sigma: how far a sample may pull an average
SURE = 4.8  # standard errors of an average
MOST = 4


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """A turn that the samples do not resolve.

    Attributes
    ----------
    station : float
    height : float
        Of the detail that the curve passes by.
    """

    station: float
    height: float


def sharp_turns(across: Across) -> list[Turn]:
    """Find where a curve passes by turns that its samples make, the largest first.

    Regression over eight sigma either side makes no turn within a radius of two sigma: where the truth
    has one, or waves about as high as the noise, the samples lie to one side of the curve. Corners are
    no turns; neither is what happens beside another branch.

    Parameters
    ----------
    across : Across
    """
    if not 0.0 < across.sigma < 0.05 * across.line.length or len(across.station) < 2 * LEAST_SAMPLES:
        return []
    station, sigma = across.station, across.sigma
    last = np.searchsorted(station, station + WINDOW * sigma, "right")
    first = np.arange(len(station))
    enough = last - first >= LEAST_SAMPLES
    count = np.maximum(last - first, 1)[:, None]
    offset = np.clip(across.offset, -CLIPPED * sigma, CLIPPED * sigma)  # one outlier is no detail
    means, squares = (_sums(x, first, last) / count for x in (offset, offset**2))
    # Noise may be larger here than along the whole curve.
    spread = np.maximum(np.sqrt(np.maximum(squares - means**2, 0.0)), sigma)
    far = np.abs(means) > np.maximum(MISSED, SURE / np.sqrt(count)) * spread
    mean = np.max(np.abs(means), axis=1)
    off = enough & far.any(axis=1)
    out: list[Turn] = []
    rest = np.flatnonzero(off)
    while len(rest) and len(out) < MOST:
        k = rest[np.argmax(mean[rest])]
        out.append(Turn(float(station[k] + 0.5 * WINDOW * sigma), float(2.0 * mean[k])))
        rest = rest[np.abs(station[rest] - station[k]) > 15.0 * sigma]
    return out


def _sums(x: Floats, first: NDArray[np.int64], last: NDArray[np.int64]) -> Floats:
    """Sums of rows from the first to before the last."""
    sums = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x, axis=0)])
    return np.asarray(sums[last] - sums[first])
