"""Coordinates on a grid.

About coordinates that were rounded to a grid coarser than the noise residuals tell nothing. On any grid as
dense as the samples different ones coincide; elsewhere samples that coincide are copies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["LOOKED_AT", "Lattice"]

LOOKED_AT = 10_000  # samples
COARSE = 0.8  # in sigma: step of a grid that shapes the residuals
REPEATED = 0.5  # share of coordinates that occur again
SAME = 1e-9  # in sigma: coordinates that differ by less are the same
STEP = 1e-6  # in sigma: least step of a grid


@dataclass(frozen=True, slots=True)
class Lattice:
    """What the coordinates of samples show of a grid.

    Attributes
    ----------
    coarse : bool
        Whether its steps are like the noise, or larger, along any axis.
    gridded : bool
        Whether along every axis most of the different samples share their coordinate with others.
    """

    coarse: bool
    gridded: bool

    @classmethod
    def of(cls, places: NDArray[np.float64], sigma: float) -> Lattice:
        """Look for a grid.

        Parameters
        ----------
        places : (n, d) array
            Samples along the axes of the input.
        sigma : float
            Noise standard deviation.
        """
        sigma = max(sigma, 1e-9)
        coarse = any(_step(coordinate, STEP * sigma) > COARSE * sigma for coordinate in places.T)
        keys = np.rint(places / (SAME * max(sigma, 1e-6)))
        different = keys[np.append(True, np.any(np.diff(keys, axis=0) != 0.0, axis=1))]
        most = REPEATED * len(different)
        return cls(coarse, all(len(np.unique(coordinate)) < most for coordinate in different.T))


def _step(coordinate: NDArray[np.float64], least: float) -> float:
    """Typical step of a grid along an axis; 0 where most coordinates occur but once."""
    steps = np.diff(np.sort(coordinate))
    real = steps[steps > least]
    return float(np.median(real)) if 0 < len(real) < (1.0 - REPEATED) * len(steps) else 0.0
