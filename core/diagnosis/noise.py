"""How large the noise is, how well that is known, and where along a curve it differs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.across import CUT, Across
from core.refine.local_noise import LocalNoise, sigma_along
from core.refine.principal_curve import Refined

__all__ = ["noise_along", "noise_error"]

Floats = NDArray[np.float64]

LEAST_SAMPLES = 200  # fewer show no change along a curve
MOST_SPENT = 0.5  # share of the samples that a fit may use up


def noise_error(refined: Refined, samples: Sequence[Across], normals: int) -> float | None:
    """Estimate the standard error of the noise of all curves together.

    The variance of a mean of squares follows from the fourth moment, so that heavy tails count; the fit's
    degrees of freedom are no observations.

    Parameters
    ----------
    refined : Refined
    samples : sequence of Across
        Of each of its curves.
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.

    Returns
    -------
    float or None
        In the units of the curves; None where too few samples tell.
    """
    count = np.array([len(each.stations) for each in samples], np.float64)
    if not refined.sigma > 0.0 or count.sum() < 4.0:
        return None
    given = refined.sigma_errors
    if len(given) == len(count) and np.all(np.isfinite(given[count > 0])) and np.any(given > 0.0):
        errors = np.where(count > 0, given, 0.0)
    else:
        errors = np.array([_own_error(each, refined.errors[k], normals) for k, each in enumerate(samples)])
    known = count > 0
    parts = (count * refined.sigmas * errors)[known] / count.sum() / refined.sigma
    return float(np.sqrt(np.sum(parts**2))) if np.all(np.isfinite(parts)) else None


def _own_error(across: Across, errors: Floats, normals: int) -> float:
    n = len(across.stations)
    if n == 0 or not across.sigma > 0.0:
        return 0.0
    square = (across.distance[across.distance <= CUT * across.sigma] / across.sigma) ** 2 / normals
    # Of Gaussian noise the square has variance 2; a few samples may show too little of the tails.
    spread = 2.0 / normals
    if len(square) >= LEAST_SAMPLES:
        spread = max(spread, float(np.var(square)) / max(float(square.mean()), 1e-300) ** 2)
    free = max(n - _spent(across, errors), (1.0 - MOST_SPENT) * n, 1.0)
    return float(0.5 * across.sigma * np.sqrt(spread / free))


def _spent(across: Across, errors: Floats) -> float:
    """Degrees of freedom of the fit, from its pointwise errors: the sum of the samples' leverages."""
    if not len(errors) or not np.all(np.isfinite(errors)):
        return 0.0
    return len(across.stations) * float(np.mean(np.minimum(errors / across.sigma, 1.0) ** 2))


def noise_along(across: Across, normals: int) -> LocalNoise | None:
    """Estimate the noise along a curve; None where it does not vary significantly.

    Parameters
    ----------
    across : Across
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    """
    if len(across.station) < LEAST_SAMPLES or not across.sigma > 0.0:
        return None
    inside = across.distance <= CUT * across.sigma
    found = sigma_along(
        across.station[inside], across.distance[inside], across.line.length, across.line.closed,
        across.sigma, CUT, normals,
    )  # fmt: skip
    return found if found.varies else None
