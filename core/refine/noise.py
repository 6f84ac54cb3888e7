"""The noise standard deviation from the residuals of a fitted curve."""

from __future__ import annotations

from math import erf

import numpy as np
from numpy.typing import NDArray

__all__ = ["mass", "mean_square", "noise_of", "truncated_deviation"]

TAIL = 3.0  # in sigma: what lies between here and the cut shows a background of outliers
LEAST_SAMPLES = 100  # fewer show no background for sure
MOST_BACKGROUND = 0.3  # share of the samples
SIGNIFICANT = 3.0  # standard deviations by which the tail must exceed a Gaussian one


def noise_of(
    distance: NDArray[np.float64],
    spent: float,
    sigma: float,
    cut: float,
    normals: int,
    weight: NDArray[np.float64] | None = None,
) -> float:
    """Estimate sigma from distances to the curve that were cut at ``cut`` times ``sigma``.

    A uniform background of outliers shows as too many samples between three sigma and
    the cut; its share is taken out of the sum of squares.

    Parameters
    ----------
    distance : (N,) array
        Distances of the samples within ``cut * sigma``.
    spent : float
        Degrees of freedom of the fit.
    sigma : float
        Estimate by which the samples were cut.
    cut : float
        In sigma.
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    weight : (N,) array, optional
        Shares of the samples that are this curve's.
    """
    if cut > TAIL + 0.5 and sigma > 0.0:
        inner = _inner_background(distance, sigma, cut, normals, weight)
        if inner > 0.0:
            core = distance <= TAIL * sigma
            near, share = distance[core], None if weight is None else weight[core]
            # Background samples have distances of density proportional to d^(normals - 1).
            square = _squares(near, share) - inner * (TAIL * sigma) ** 2 * normals / (normals + 2.0)
            return _deviation(square, mass(len(near), share) - inner - spent, TAIL, normals)
    return _deviation(_squares(distance, weight), mass(len(distance), weight) - spent, cut, normals)


def mass(count: int, weight: NDArray[np.float64] | None) -> float:
    """Return the sum of the weights, free of rounding where it is a whole number; the count without."""
    return float(count) if weight is None else round(float(weight.sum()), 6)


def mean_square(distance: NDArray[np.float64], weight: NDArray[np.float64] | None) -> float:
    """Return the weighted mean of the squares."""
    return float(np.mean(distance**2)) if weight is None else _squares(distance, weight) / float(weight.sum())


def _squares(distance: NDArray[np.float64], weight: NDArray[np.float64] | None) -> float:
    return float(np.sum(distance**2) if weight is None else np.einsum("i,i,i", weight, distance, distance))


def _deviation(square: float, free: float, cut: float, normals: int) -> float:
    return float(np.sqrt(max(square, 0.0) / (normals * max(free, 1.0)))) / truncated_deviation(cut, normals)


def _inner_background(
    distance: NDArray[np.float64], sigma: float, cut: float, normals: int, weight: NDArray[np.float64] | None
) -> float:
    """Number of background samples within the tail's beginning; 0 unless the tail is significantly heavy."""
    tail = distance > TAIL * sigma
    count = mass(len(distance), weight)
    seen = float(np.count_nonzero(tail) if weight is None else weight[tail].sum())
    due = count * (_within(cut, normals) - _within(TAIL, normals))
    if count < LEAST_SAMPLES or seen - due < SIGNIFICANT * np.sqrt(due + 1.0):
        return 0.0
    inner = (seen - due) * TAIL**normals / (cut**normals - TAIL**normals)
    return min(inner, MOST_BACKGROUND * count)


def _within(cut: float, normals: int) -> float:
    """Probability that Gaussian noise stays within ``cut`` sigma."""
    return erf(cut / np.sqrt(2.0)) if normals == 1 else 1.0 - float(np.exp(-0.5 * cut * cut))


def truncated_deviation(cut: float, normals: int) -> float:
    """Compute the standard deviation, per direction, of unit Gaussian noise cut at ``cut``."""
    if normals == 1:
        density = float(np.exp(-0.5 * cut * cut)) / np.sqrt(2.0 * np.pi)
        return float(np.sqrt(1.0 - 2.0 * cut * density / erf(cut / np.sqrt(2.0))))
    tail = float(np.exp(-0.5 * cut * cut))
    return float(np.sqrt(1.0 - 0.5 * cut * cut * tail / (1.0 - tail)))
