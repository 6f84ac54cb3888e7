"""Gaps that noise has blurred: stretches of a curve with far fewer samples than either side of them.

Where there are many samples within a standard deviation of the noise, a gap a few of them wide is not empty:
its neighbours' samples scatter into it. Counts in windows show it nevertheless.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.across import Across

__all__ = ["thinnest"]

Floats = NDArray[np.float64]

WIDTHS = (1.5, 2.2, 3.2, 4.5)  # in sigma: of the windows
GUARD = 1.5  # in sigma: between a window and what is either side of it,
SIDE = 9.0  # which is so many sigma long
LEAST_DUE = 12.0  # samples
THIN = 0.45  # of the samples that are due
SURE = 4.4  # standard deviations of a count


def thinnest(across: Across) -> tuple[float, float] | None:
    """Find the stretch that lacks most samples.

    Parameters
    ----------
    across : Across

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
    best, least = None, -SURE
    for width in WIDTHS:
        half = 0.5 * width * sigma
        inner, outer = half + GUARD * sigma, half + (GUARD + SIDE) * sigma
        seen = _count(ordered, at - half, at + half)
        before, after = _count(ordered, at - outer, at - inner), _count(ordered, at + inner, at + outer)
        due, least_due = 0.5 * (before + after) * (width / SIDE), np.minimum(before, after) * (width / SIDE)
        spread = np.sqrt(1.0 + 0.5 * width / SIDE)
        score = 2.0 * (np.sqrt(seen + 0.375) - np.sqrt(due + 0.375)) / spread
        room = np.full(len(at), True) if line.closed else (at > outer) & (at < line.length - outer)
        fit = room & _all_clear(across, outer) & (least_due > LEAST_DUE) & (seen < THIN * least_due)
        score = np.where(fit, score, 0.0)
        k = int(np.argmin(score))
        if score[k] < least:
            best, least = (float(at[k]), width * sigma), float(score[k])
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
