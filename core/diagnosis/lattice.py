"""Coordinates that were rounded to a grid coarser than the noise: residuals about them tell nothing."""

from __future__ import annotations

import numpy as np

from core.solved import Solved

__all__ = ["is_coarse"]

LOOKED_AT = 20_000
COARSE = 0.8  # in sigma: step of a grid that shapes the residuals
REPEATED = 0.5  # share of coordinates that occur again


def is_coarse(one: Solved) -> bool:
    """Tell whether the coordinates of a component lie on a grid of steps like its noise or larger.

    Parameters
    ----------
    one : Solved
    """
    few = one.points[:: max(1, len(one.points) // LOOKED_AT)]
    places = few @ one.frame.axes
    for axis in range(one.frame.dimension):
        steps = np.diff(np.sort(places[:, axis]))
        real = steps[steps > 1e-6 * max(one.refined.sigma, 1e-9)]
        step = float(np.median(real)) if len(real) else 0.0
        if len(real) < (1.0 - REPEATED) * len(steps) and step > COARSE * one.refined.sigma:
            return True
    return False
