"""Stretches of a curve without samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["longest_gap"]


def longest_gap(line: Polyline, station: NDArray[np.float64]) -> tuple[float, float]:
    """Find the longest stretch of a curve without a sample.

    Parameters
    ----------
    line : Polyline
    station : (n,) array
        Arc lengths of the samples' feet on it.

    Returns
    -------
    (middle, length)
        Arc length of the stretch's middle, and how long it is; the whole curve without samples.
    """
    if not len(station):
        return 0.5 * line.length, line.length
    ordered = np.sort(station)
    ends = (ordered[-1] - line.length, ordered[0] + line.length) if line.closed else (0.0, line.length)
    ways = np.concatenate([ends[:1], ordered, ends[1:]])
    gaps = np.diff(ways)
    k = int(np.argmax(gaps))
    return float(ways[k] + 0.5 * gaps[k]) % max(line.length, 1e-300), float(gaps[k])
