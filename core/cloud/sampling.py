"""What a point set says of itself before any curve is known: noise, density, curvature.

A subsample drawn by distance from the centroid serves as seeds and as candidates: the
choice does not depend on the order of the points or on the axes of the frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.balls import MINIMUM_RADIUS_FACTOR, Balls, optimal_balls

__all__ = ["Sample", "Scale", "estimate_scale", "spread_subsample"]

MANY = 100_000
FEW = 20_000
CANDIDATES = 5000
SEEDS = 160
CENTRAL = 0.2  # shift, in radii, up to which a ball lies evenly about its seed


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """A component's points, and a few of them for all that needs no more.

    Attributes
    ----------
    points : (N, 3) array
        Working coordinates.
    many : (min(N, 100000), 3) array
        A spread subsample for the march: more samples show no more topology.
    few : (min(N, 20000), 3) array
        A spread subsample for first passes and for questions of counting.
    """

    points: NDArray[np.float64]
    many: NDArray[np.float64]
    few: NDArray[np.float64]

    @property
    def thinning(self) -> float:
        """Share of the marched points that are in ``few``."""
        return len(self.few) / len(self.many)

    @classmethod
    def of(cls, points: NDArray[np.float64]) -> Sample:
        """Draw the subsamples."""
        many = points if len(points) <= MANY else points[spread_subsample(points, MANY)]
        return cls(points, many, many if len(many) <= FEW else many[spread_subsample(many, FEW)])


@dataclass(frozen=True, slots=True, eq=False)
class Scale:
    """Typical lengths of a component.

    Attributes
    ----------
    sigma : float
        Noise standard deviation normal to the curve, in units of the points.
    density : float
        Marched samples per unit length, typical of the curve's length.
    radius : float
        Typical optimal radius.
    curvature : float
        Typical curvature, from the optimal radii.
    balls : Balls
        The optimal balls of the seeds.
    """

    sigma: float
    density: float
    radius: float
    curvature: float
    balls: Balls


def spread_subsample(points: NDArray[np.float64], size: int) -> NDArray[np.int64]:
    """Choose about ``size`` points independently of their order and of the frame.

    Every k-th point by distance from the centroid: a choice that rotation, translation,
    scaling and permutation leave as it is.

    Parameters
    ----------
    points : (N, d) array
    size : int

    Returns
    -------
    (min(N, size),) array of indices
    """
    if len(points) <= size:
        return np.arange(len(points))
    offset = points - points.mean(axis=0)
    order = np.argsort(np.einsum("ij,ij->i", offset, offset))
    return order[np.linspace(0, len(points) - 1, size).round().astype(np.int64)]


def estimate_scale(sample: Sample, extent: float, flat: bool) -> Scale | None:
    """Estimate noise, density and radius from optimal balls (§4.2.1) over a subsample.

    Parameters
    ----------
    sample : Sample
    extent : float
        Radius of a ball about the centroid that holds the points.
    flat : bool
        Whether the points lie in a plane.

    Returns
    -------
    Scale or None
        None when no ball anywhere looks like a piece of a curve.
    """
    candidates = sample.few[spread_subsample(sample.few, CANDIDATES)]
    seeds = candidates[spread_subsample(candidates, SEEDS)]
    balls = optimal_balls(candidates, seeds, 2.0 * extent, flat)
    found = balls.found
    if not found.any():
        return None
    thinning = len(sample.many) / len(candidates)
    sigma = float(np.median(balls.sigma[found]))
    radius = float(np.median(balls.radius[found]))
    # Seeds fall where samples are many: weighting by 1/density turns "typical sample" into "typical length".
    # In a thick cloud some balls stop inside the noise, and at ends of curves balls are half empty:
    # their density is not the curve's.
    whole = found & (balls.sigma >= 0.5 * sigma) & (balls.radius >= 1.5 * sigma) & (balls.shift < CENTRAL)
    whole = whole if whole.any() else found
    density = float(whole.sum() / np.sum(1.0 / balls.density[whole])) * thinning
    curvature = max(sigma, 1e-12 * extent) * (MINIMUM_RADIUS_FACTOR / radius) ** 2
    return Scale(sigma, density, radius, curvature, balls)
