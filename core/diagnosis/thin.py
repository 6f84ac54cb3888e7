"""Gaps that noise has blurred: stretches of a curve with far fewer samples than either side of them.

Where there are many samples within a standard deviation of the noise, a gap a few of them wide is not empty:
its neighbours' samples scatter into it. Counts in windows show it nevertheless.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr

from core.diagnosis.across import Across

__all__ = ["thinnest"]

Floats = NDArray[np.float64]

WIDTHS = (1.5, 2.2, 3.2, 4.5)  # in sigma: of the windows
GUARD = 1.5  # in sigma: between a window and what is either side of it,
SIDE = 9.0  # which is so many sigma long
THIN = 0.45  # of the samples that are due
CHANCE = 0.003  # that independent samples are as thin anywhere
APART = 1.0  # in sigma: how far apart windows of all widths say different things


def thinnest(across: Across, share: float = 1.0) -> tuple[float, float] | None:
    """Find the stretch that lacks most samples.

    Parameters
    ----------
    across : Across
    share : float
        Of all samples, by which the chance of error is divided among curves.

    Returns
    -------
    (middle, length) or None
        In arc length; None where no stretch lacks samples significantly.
    """
    line, sigma, at = across.line, across.sigma, across.places
    if not 0.0 < sigma < 0.02 * line.length or len(at) < 2:
        return None
    ordered = across.stations
    if line.closed:
        ordered = np.concatenate([ordered - line.length, ordered, ordered + line.length])
    best, least = None, CHANCE * share * (APART * sigma / line.length)
    for width in WIDTHS:
        half = 0.5 * width * sigma
        inner, outer = half + GUARD * sigma, half + (GUARD + SIDE) * sigma
        seen = _count(ordered, at - half, at + half)
        before, after = _count(ordered, at - outer, at - inner), _count(ordered, at + inner, at + outer)
        room = np.full(len(at), True) if line.closed else (at > outer) & (at < line.length - outer)
        fit = room & _all_clear(across, outer)
        fit &= seen < THIN * np.minimum(before, after) * (width / SIDE)
        # Each of the samples of the window and of both sides may lie in the window, as far as chance goes.
        chance = bdtr(seen, seen + before + after, width / (width + 2.0 * SIDE))
        chance = np.where(fit, chance, 1.0)
        k = int(np.argmin(chance))
        if chance[k] < least:
            best, least = (float(at[k]), width * sigma), float(chance[k])
    return best


def _count(ordered: Floats, low: Floats, high: Floats) -> NDArray[np.int64]:
    return np.asarray(np.searchsorted(ordered, high) - np.searchsorted(ordered, low))


def _all_clear(across: Across, reach: float) -> NDArray[np.bool_]:
    """Whether a curve is clear of all else within a reach of each place."""
    step = across.line.length / len(across.places)
    span = int(np.ceil(reach / max(step, 1e-300)))
    marks = np.pad(~across.clear, span, mode="wrap" if across.line.closed else "edge").astype(np.int64)
    sums = np.concatenate([[0], np.cumsum(marks)])
    return np.asarray(sums[2 * span + 1 :] == sums[: -2 * span - 1])
