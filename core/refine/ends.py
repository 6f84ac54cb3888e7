"""Where an open curve begins and ends, from the blurred end of its samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["ends_of", "prolonged"]

Floats = NDArray[np.float64]

END_MASS = 0.3989  # E max(0, X) of a standard normal X: share of rho sigma beyond an open end
REACH = 1.5  # in sigma beyond the half-density mark: samples farther out belong to something else


def prolonged(line: Polyline, by: float) -> Polyline:
    """Prolong an open curve straight at both ends, so that samples beyond them have a foot.

    Parameters
    ----------
    line : Polyline
    by : float
        Length to add at each end.
    """
    if line.closed or by <= 0.0:
        return line
    x = line.vertices
    span = max(min(by, 0.25 * line.length), 0.02 * line.length)
    head = x[0] - line.at(np.array([span]))[0]
    tail = x[-1] - line.at(np.array([line.length - span]))[0]
    first = x[0] + head * (by / max(float(np.linalg.norm(head)), 1e-300))
    last = x[-1] + tail * (by / max(float(np.linalg.norm(tail)), 1e-300))
    return Polyline(np.concatenate([first[None], x, last[None]]), False)


def ends_of(
    station: Floats, length: float, sigma: float, weight: Floats | None = None
) -> tuple[float, float]:
    """Estimate the stations of both ends: the mass beyond an end is 0.4 rho sigma.

    Parameters
    ----------
    station : (N,) array
        Arc lengths of the samples' feet on the prolonged curve, in [0, length].
    length : float
        Of the prolonged curve.
    sigma : float
        Noise standard deviation.
    weight : (N,) array, optional
        Shares of the samples that are this curve's.
    """
    near = max(0.2 * length, 20.0 * sigma)
    if len(station) < 200 or near > 0.5 * length:
        near = length
    weight = np.ones(len(station)) if weight is None else weight
    low, high = station <= near, station >= length - near
    return (
        _end(*_in_order(station[low], weight[low]), sigma),
        length - _end(*_in_order(length - station[high], weight[high]), sigma),
    )


def _in_order(station: Floats, weight: Floats) -> tuple[Floats, Floats]:
    order = np.argsort(station, kind="stable")
    return station[order], weight[order]


def _end(ordered: Floats, weight: Floats, sigma: float) -> float:
    """Find the station that leaves 0.4 rho sigma samples before it.

    Noise blurs an end symmetrically: half the density marks it roughly, and samples far
    before that mark belong to something else.
    """
    n = len(ordered)
    if n < 8:
        return float(ordered[0]) if n else 0.0
    before = np.concatenate([[0.0], np.cumsum(weight)])
    total = before[-1]
    # The density beside the end, but clear of its blur.
    first = _rank(before, total // 4)
    last = max(_rank(before, total // 2), min(n - 1, 10))
    between = ordered[last] - ordered[first]
    held = before[last] - before[first]
    density = held / between if between > 0.0 else total / max(ordered[-1] - ordered[0], 1e-300)
    window = max(2.0 * sigma, 6.0 / density)
    some = np.arange(0, last + 1, max(1, last // 2000))
    inside = before[np.searchsorted(ordered, ordered[some] + window)] - before[some]
    # Where the window is six spacings the threshold is three samples: rounding must not decide.
    dense = some[inside > 0.5 * density * window - 0.5]
    mark = ordered[dense[0]] if len(dense) else ordered[0]
    start = np.searchsorted(ordered, mark - REACH * sigma)
    ordered, before = ordered[start:], before[start:] - before[start]
    beyond = min(END_MASS * density * sigma, 0.25 * before[-1])
    k = _rank(before, beyond)
    previous = ordered[0] - 1.0 / density if k == 0 else ordered[k - 1]
    return float(previous + (beyond - before[k]) / (before[k + 1] - before[k]) * (ordered[k] - previous))


def _rank(before: Floats, amount: float) -> int:
    """Which sample an amount of weight falls to."""
    return int(np.clip(np.searchsorted(before, amount, "right") - 1, 0, len(before) - 2))
