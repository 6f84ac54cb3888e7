"""Whether a short curve is but a clump of outliers.

Any clump can be marched through. The samples about a short curve are told twice: as samples of
the curve, and as a round cloud; either among scattered outliers. The briefer account wins.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["is_blob", "is_small"]

Floats = NDArray[np.float64]

WIDE = 18.0  # in sigma: no clump of outliers extends farther
AROUND = 6.0  # in sigma about the curve: what is there speaks too
ASPECT = 2.0  # of a clump, at most
PIECE = 8.0  # in sigma: a curve is free to bend so often
WIDEST = 2.0  # in sigma: a curve's own noise, at most
CLEARLY = 4.0  # nats by which the curve must be briefer
BESIDE = 3.0  # in sigma of another curve: its samples
LEAST_FREE = 0.3  # of a curve must be away from the others to be told from a clump
ROUNDS = 30
NODES = 16  # nearest to each sample


def is_blob(
    points: Floats, line: Polyline, sigma: float, flat: bool, others: Sequence[Polyline] = ()
) -> bool:
    """Tell whether a round cloud explains the samples about a curve as well as the curve does.

    Parameters
    ----------
    points : (N, 3) array
    line : Polyline
    sigma : float
        Noise standard deviation.
    flat : bool
        Whether there is one normal direction or two.
    others : sequence of Polyline
        Other curves: those that reach beyond the surroundings explain what samples they pass.
    """
    if not is_small(line, sigma):
        return False
    places = line.at(np.linspace(0.0, line.length, max(int(2.0 * line.length / sigma), 8)))
    centre = places.mean(axis=0)
    extent = float(np.linalg.norm(places - centre, axis=1).max()) + AROUND * sigma
    offset = points - centre
    near = points[np.einsum("ij,ij->i", offset, offset) <= extent**2]
    passing = [x for x in others if np.linalg.norm(x.vertices - centre, axis=1).max() > extent]
    if passing:
        reach = BESIDE * sigma
        near = near[project(near, passing, reach).curve < 0] if len(near) else near
        free = project(places, passing, reach).curve < 0
        if np.mean(free) < LEAST_FREE:
            return False
        places = places[free]
    axes = 2 if flat else 3
    if len(near) <= axes + 2:
        return True
    empty = np.pi * extent**2 * (1.0 if flat else 4.0 / 3.0 * extent)
    as_cloud = _cloud(near[:, :axes], empty)
    as_curve = _curve(near, places, sigma, axes, empty)
    spare = axes * (2.0 + line.length / (PIECE * sigma)) - 0.5 * axes * (axes + 3)
    return bool(as_curve - as_cloud < 0.5 * max(spare, 0.0) * np.log(len(near)) + CLEARLY)


def is_small(line: Polyline, sigma: float) -> bool:
    """Whether a curve extends no farther than clumps of outliers do, however much it winds.

    Parameters
    ----------
    line : Polyline
    sigma : float
        Noise standard deviation.
    """
    return float(np.linalg.norm(np.ptp(line.vertices, axis=0))) < WIDE * sigma


def _cloud(points: Floats, empty: float) -> float:
    """Log-likelihood of a normal cloud, not too long, among uniform outliers."""
    share = np.ones(len(points))
    likelihood = -np.inf
    for _ in range(ROUNDS):
        total = max(float(share.sum()), 1e-300)
        mean = share @ points / total
        offset = points - mean
        value, vector = np.linalg.eigh((offset * share[:, None]).T @ offset / total)
        value = _rounded(np.maximum(value, 1e-300))
        square = ((offset @ vector) ** 2 / value).sum(axis=1)
        dense = np.exp(-0.5 * square) / np.sqrt(np.prod(2.0 * np.pi * value))
        own = min(total / len(points), 0.999) * dense
        stray = max(1.0 - total / len(points), 0.001) / empty
        share = own / (own + stray)
        likelihood = float(np.log(own + stray).sum())
    return likelihood


def _rounded(value: Floats) -> Floats:
    """Variances along the axes, ascending, drawn together until the cloud is not too long."""
    longest = float(value[-1])
    if longest <= ASPECT**2 * value[0]:
        return value
    # The likeliest variances within the aspect: v for the short axes, ASPECT^2 v for the longest.
    shape = np.minimum(np.maximum(value / value[0], 1.0), ASPECT**2)
    shape[-1] = ASPECT**2
    return np.asarray(shape * np.mean(value / shape))


def _curve(points: Floats, places: Floats, sigma: float, axes: int, empty: float) -> float:
    """Log-likelihood of samples spread evenly over places on a curve, among uniform outliers."""
    count = len(places)
    distance, _ = cKDTree(places).query(points, min(NODES, count))
    square = np.asarray(distance).reshape(len(points), -1) ** 2
    width, share = sigma, 0.9
    likelihood = -np.inf
    for _ in range(ROUNDS):
        each = np.exp(-0.5 * square / width**2) / count / (2.0 * np.pi * width**2) ** (0.5 * axes)
        own = share * each.sum(axis=1)
        stray = (1.0 - share) / empty
        likelihood = float(np.log(own + stray).sum())
        part = own / (own + stray)
        share = min(max(float(part.mean()), 0.001), 0.999)
        weight = each * (part / np.maximum(each.sum(axis=1), 1e-300))[:, None]
        spread = float(np.sum(weight * square)) / max(float(weight.sum()) * axes, 1e-300)
        width = min(max(float(np.sqrt(spread)), 0.5 * sigma), WIDEST * sigma)
    return likelihood
