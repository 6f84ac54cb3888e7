"""Coordinates that were rounded to a lattice: equal points are then no copies of one sample."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.sampling import spread_subsample

__all__ = ["lattice_step"]

SEEDS = 240
SAME = 1e-6  # of the step: what rounding leaves of it
SHARE = 0.8  # of the points must have their nearest neighbour one step away


def lattice_step(points: NDArray[np.float64]) -> float | None:
    """Find the step of the lattice to which distinct points have been rounded.

    Parameters
    ----------
    points : (N, d) array
        No two of them equal.

    Returns
    -------
    float or None
        None where there is none to be seen.
    """
    if len(points) < 2:
        return None
    seeds = points.take(spread_subsample(points, SEEDS), axis=0)
    nearest = np.asarray(cKDTree(points).query(seeds, [2])[0])[:, 0]
    step = float(np.median(nearest))
    return step if np.mean(np.abs(nearest - step) <= SAME * step) > SHARE else None
