"""Open ends that stop on another branch: there, neither a gap nor a stub is left."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.refine.branches import Branches
from core.refine.further_feet import further_feet
from core.refine.polyline import Polyline

__all__ = ["meeting"]

Floats = NDArray[np.float64]

REACH = 2.0  # in sigma: farther from the other branch an end is an end by itself
TOUCH = 0.5  # in sigma: how near the two courses must come
LEAST_SINE = 0.4  # of their angle: flatter, and they run side by side
STEPS = 8  # places to a sigma


def meeting(line: Polyline, curve: int, station: float, branches: Branches, ends: Floats) -> float | None:
    """Find where a curve meets another branch near its end; None when it does not.

    Parameters
    ----------
    line : Polyline
        The open curve, prolonged beyond its ends.
    curve : int
        Its number.
    station : float
        Of its end.
    branches : Branches
    ends : (C, 2) array
        Stations where the curves begin and end.

    Returns
    -------
    float or None
        Station on the line.
    """
    sigma = float(branches.sigmas[curve])
    at = station + sigma / STEPS * np.arange(-(REACH + 1) * STEPS, (REACH + 1) * STEPS + 1)
    square = _squares(line, curve, at, branches, ends)
    near = square[STEPS:-STEPS]
    k = int(np.argmin(near)) + STEPS
    if not near.min() < (TOUCH * sigma) ** 2 or k in (STEPS, len(at) - STEPS - 1):
        return None
    if min(square[k - STEPS], square[k + STEPS]) < (LEAST_SINE * sigma) ** 2:
        return None
    before, here, after = square[k - 1 : k + 2]
    rise = before - 2.0 * here + after
    shift = 0.5 * (before - after) / rise if np.isfinite(rise) and rise > 0.0 else 0.0
    return float(at[k] + shift * sigma / STEPS)


def _squares(line: Polyline, curve: int, at: Floats, branches: Branches, ends: Floats) -> Floats:
    """Squared distances of places on a curve from other branches; infinite beyond the line and the cut."""
    on = np.where((at >= 0.0) & (at <= line.length), curve, -1)
    further, _ = further_feet(line.at(at), on, at, np.zeros(len(at)), branches)
    # Beyond its end the other curve only seems to be.
    inside = (further.station > ends[further.curve, 0]) & (further.station < ends[further.curve, 1])
    square = np.full(len(at), np.inf)
    np.minimum.at(square, further.sample[further.row[inside]], further.distance[inside] ** 2)
    return square
