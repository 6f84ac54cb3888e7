"""How well curves explain a point set: a description length, to choose between hypotheses.

Each sample comes from some place on a curve, displaced by Gaussian noise, or from a uniform
background, whose share is the likeliest. Where branches cross their densities add up. A stretch of
curve without samples lowers the density of all others and so costs as many nats as samples were due
there; every end and every curve costs what its parameters do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline

__all__ = ["bending", "description_length", "typical_curvature"]

BACKGROUND = 0.02  # share of outliers at first, and in as many samples more:
PRIOR = 50.0  # of no data
ROUNDS = 12  # of finding the share
COST_OF_CURVE = 1.0  # in units of ln N
COST_OF_END = 2.5
SAMPLES_A_STRETCH = 80.0
MOST_STRETCHES = 12
LEAST_DENSITY = 0.15  # of the mean
EXPECTATIONS = 3
MOST_CHORDS = 5000  # a curve
LEAST_SIGMA = 2e-4  # of the extent: finer differences do not tell hypotheses apart
REACH = 5.5  # in sigma: what lies farther adds nothing
CHORD = 3.0  # in sigma: what a turn is measured over
NODES = 24  # a sigma apart, the nearest to each sample: both branches of a crossing


def description_length(
    points: NDArray[np.float64],
    curves: Sequence[Polyline],
    sigma: float,
    extent: float,
    flat: bool,
    whole: bool = False,
    uneven: bool = False,
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
    whole : bool
        Whether the number of curves and ends is given, and costs nothing.
    uneven : bool
        Whether samples may be denser in some stretches of the curves than in others.
    """
    if not curves:
        return float("inf")
    axes = 2 if flat else 3
    sigma = max(sigma, LEAST_SIGMA * extent)
    nodes, weight = _nodes(curves, sigma)
    distance, found = cKDTree(nodes).query(points, NODES, distance_upper_bound=REACH * sigma)
    near = np.asarray(found, np.int64)
    seen = np.isfinite(distance)
    blurred = np.where(seen, np.exp(-0.5 * (np.where(seen, distance, 0.0) / sigma) ** 2), 0.0)
    if uneven:
        weight = _with_density(weight, blurred, near, LEAST_SIGMA * extent)
    blurred *= np.append(weight, 0.0)[near]
    on_curves = (
        1.0
        / max(float(weight.sum()), LEAST_SIGMA * extent)
        * blurred.sum(axis=1)
        / (sigma * np.sqrt(2.0 * np.pi)) ** axes
    )
    likelihood = _among_outliers(on_curves, 1.0 / (2.0 * extent) ** axes)
    if whole:
        return float(-likelihood)
    ends = sum(2 for line in curves if not line.closed)
    parameters = (COST_OF_CURVE * len(curves) + COST_OF_END * ends) * np.log(len(points) + 1.0)
    return float(parameters - likelihood)


def _with_density(
    weight: NDArray[np.float64], blurred: NDArray[np.float64], near: NDArray[np.int64], least: float
) -> NDArray[np.float64]:
    """Lengths times the density of samples along the curves, from a few rounds of expectation.

    It is the same within a stretch, of which there are few, and no stretch is taken for empty: else
    curves could go anywhere for nothing.
    """
    stretches = int(np.clip(len(near) / SAMPLES_A_STRETCH, 1, MOST_STRETCHES))
    which = np.minimum(np.cumsum(weight) / max(float(weight.sum()), least) * stretches, stretches - 1).astype(
        np.int64
    )
    where = np.append(which, stretches)
    density = np.append(np.ones(stretches), 0.0)
    length = np.bincount(which, weight, stretches)
    for _ in range(EXPECTATIONS):
        each = blurred * np.append(weight, 0.0)[near] * density[where[near]]
        each /= np.maximum(each.sum(axis=1), 1e-300)[:, None]
        count = np.bincount(where[near].ravel(), each.ravel(), stretches + 1)[:stretches]
        found = count / np.maximum(length, 1e-300) * (float(length.sum()) / max(float(count.sum()), 1e-300))
        density[:stretches] = np.maximum(found, LEAST_DENSITY)
    return np.asarray(weight * density[which])


def _among_outliers(dense: NDArray[np.float64], background: float) -> float:
    """Log-likelihood of samples from the curves, and from a background of the likeliest share."""
    share = BACKGROUND
    for _ in range(ROUNDS):
        stray = share * background / (share * background + (1.0 - share) * dense)
        share = float((stray.sum() + PRIOR * BACKGROUND) / (len(dense) + PRIOR))
    return float(np.log((1.0 - share) * dense + share * background).sum())


def bending(curves: Sequence[Polyline], sigma: float, curvature: float) -> float:
    """Nats of the curves' own course: sharp turns are unlikely where the rest bends gently.

    Half the bending energy, the integral of squared curvature over arc length, in units of the
    typical curvature: a circle of typical curvature costs pi. Where samples hardly tell whether
    two branches cross or turn back, this does.

    Parameters
    ----------
    curves : sequence of Polyline
    sigma : float
        Noise standard deviation; turns are measured over a few of them.
    curvature : float
        Typical of the point set.
    """
    return sum(_energy(line, CHORD * sigma) for line in curves) / (2.0 * max(curvature, 1e-300))


def typical_curvature(curves: Sequence[Polyline], sigma: float) -> float:
    """Curvature that three quarters of the curves' length do not exceed, measured over a few sigma.

    Parameters
    ----------
    curves : sequence of Polyline
    sigma : float
        Noise standard deviation.
    """
    found = []
    for line in curves:
        turn, chord = _turns(line, 2.0 * CHORD * sigma)
        found.append(turn / max(chord, 1e-300))
    return float(np.quantile(np.concatenate(found), 0.75)) if found else 0.0


def _energy(line: Polyline, chord: float) -> float:
    """Sum of squared turns over the chord's length."""
    turn, chord = _turns(line, chord)
    return float(np.sum(turn**2)) / max(chord, 1e-300)


def _turns(line: Polyline, chord: float) -> tuple[NDArray[np.float64], float]:
    """Turns in radians between chords about so long, and how long they are."""
    length = line.length
    count = max(int(length / max(chord, length / MOST_CHORDS, 1e-300)), 4)
    x = line.at(np.linspace(0.0, length, count + 1)[: count + (0 if line.closed else 1)])
    step = np.diff(np.concatenate([x, x[:2]]) if line.closed else x, axis=0)
    step /= np.maximum(np.linalg.norm(step, axis=1), 1e-300)[:, None]
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", step[1:], step[:-1]), -1.0, 1.0))
    return np.asarray(turn), length / count


def _nodes(curves: Sequence[Polyline], step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places about a sigma apart along the curves, and the length that each stands for."""
    places, weights = [], []
    for line in curves:
        length = line.length
        count = max(int(np.ceil(length / step)), 3)
        places.append(line.at((np.arange(count) + 0.5) * (length / count)))
        weights.append(np.full(count, length / count))
    return np.concatenate(places), np.concatenate(weights)
