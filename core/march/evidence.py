"""How well curves explain a point set: a description length, to choose between hypotheses.

Each sample comes from some place on a curve, displaced by Gaussian noise, or from a
uniform background. A stretch of curve without samples lowers the density of all others
and so costs as many nats as samples were due there; every end and every curve costs
what its parameters do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["description_length"]

BACKGROUND = 0.02  # prior share of outliers
COST_OF_CURVE = 3.0  # in units of ln N
COST_OF_END = 1.5


def description_length(
    points: NDArray[np.float64], curves: Sequence[Polyline], sigma: float, extent: float, flat: bool
) -> float:
    """Nats needed to describe the samples by the curves; less is better.

    Parameters
    ----------
    points : (N, 3) array
    curves : sequence of Polyline
    sigma : float
        Noise standard deviation per direction; the same for all hypotheses that are compared.
    extent : float
        Radius of the region in which outliers would lie.
    flat : bool
        Whether there is one normal direction or two.
    """
    if not curves:
        return float("inf")
    normals = 1 if flat else 2
    sigma = max(sigma, 1e-9 * extent)
    feet = project(points, curves, 6.0 * sigma)
    length = max(sum(line.length for line in curves), 1e-9 * extent)
    log_curve = np.log((1.0 - BACKGROUND) / length) - normals * np.log(sigma * np.sqrt(2.0 * np.pi))
    log_background = np.log(BACKGROUND) - (1 + normals) * np.log(2.0 * extent)
    log_noise = np.where(np.isfinite(feet.distance), -0.5 * (feet.distance / sigma) ** 2, -np.inf)
    likelihood = np.logaddexp(log_curve + log_noise, log_background).sum()
    ends = sum(2 for line in curves if not line.closed)
    parameters = (COST_OF_CURVE * len(curves) + COST_OF_END * ends) * np.log(len(points) + 1.0)
    return float(parameters - likelihood)
