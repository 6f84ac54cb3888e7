"""Coordinates on a grid, and samples told twice.

About coordinates that were rounded to a grid coarser than the noise residuals tell nothing; copies of samples
are no samples. On a grid samples coincide that are none.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import spread_subsample
from core.solved import Solved

__all__ = ["is_coarse", "is_gridded"]

LOOKED_AT = 20_000
COARSE = 0.8  # in sigma: step of a grid that shapes the residuals
REPEATED = 0.5  # share of coordinates that occur again
SAME = 1e-9  # in sigma: coordinates that differ by less are the same


def is_coarse(one: Solved) -> bool:
    """Tell whether the coordinates of a component lie on a grid of steps like its noise or larger.

    Parameters
    ----------
    one : Solved
    """
    places = _places(one)
    for axis in range(one.frame.dimension):
        steps = np.diff(np.sort(places[:, axis]))
        real = steps[steps > 1e-6 * max(one.refined.sigma, 1e-9)]
        step = float(np.median(real)) if len(real) else 0.0
        if len(real) < (1.0 - REPEATED) * len(steps) and step > COARSE * one.refined.sigma:
            return True
    return False


def is_gridded(one: Solved) -> bool:
    """Tell whether most of the different samples of a component share each coordinate with others.

    There samples may coincide by chance; elsewhere those that do are copies.

    Parameters
    ----------
    one : Solved
    """
    keys = np.rint(_places(one) / (SAME * max(one.refined.sigma, 1e-6)))
    different = np.unique(keys[:, : one.frame.dimension], axis=0)
    most = REPEATED * len(different)
    return all(len(np.unique(coordinate)) < most for coordinate in different.T)


def _places(one: Solved) -> NDArray[np.float64]:
    """(n, 3) samples along the axes of the input, fewer of many."""
    few = one.points
    if len(few) > LOOKED_AT:
        few = few[spread_subsample(few, LOOKED_AT)]
    return np.asarray(few @ one.frame.axes)
