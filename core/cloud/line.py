"""The line through a local point set: principal axis (§3.1) or least squares (§3.2)."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["fit_line"]

Floats = NDArray[np.float64]

_MOST_TURNS = 60
_ALIGNED = 1e-12


def fit_line(
    points: Floats, estimator: Literal["pca", "least_squares"] = "pca", rng: np.random.Generator | None = None
) -> tuple[Floats, Floats]:
    """Fit p(eta) = O_p + eta X_p.

    Least squares minimise offsets along one axis and so depend on the frame. In a frame that
    is turned at random first, and then again to each line found, they come to rest on
    the principal axis: the paper's two estimators are one (§3.2).

    Parameters
    ----------
    points : (N, d) array
        At least two distinct points.
    estimator : {"pca", "least_squares"}
    rng : numpy.random.Generator, optional
        Of the first rotation, for least squares.

    Returns
    -------
    centre : (d,) array
        O_p, the centre of gravity.
    direction : (d,) array
        X_p, a unit vector; its sign is arbitrary.

    Examples
    --------
    >>> centre, direction = fit_line(np.array([[0.0, 0.0], [2.0, 2.0], [4.0, 4.0]]))
    >>> centre, np.abs(direction).round(3)
    (array([2., 2.]), array([0.707, 0.707]))
    """
    centre = points.mean(axis=0)
    offset = points - centre
    if estimator == "pca":
        return centre, np.linalg.eigh(offset.T @ offset)[1][:, -1]
    return centre, _least_squares(offset, rng or np.random.default_rng(0))


def _least_squares(offset: Floats, rng: np.random.Generator) -> Floats:
    """Direction of the regression line, refitted in the frame of each line until it rests."""
    direction = _random_direction(offset.shape[1], rng)
    for _ in range(_MOST_TURNS):
        along = offset @ direction
        # The slopes of all other coordinates over this one make the new direction.
        turned = offset.T @ along
        norm = float(np.linalg.norm(turned))
        if norm == 0.0:  # a first frame exactly across the line
            direction = _random_direction(len(direction), rng)
            continue
        turned = turned / norm
        if np.linalg.norm(turned - direction) < _ALIGNED:
            break
        direction = turned
    return direction


def _random_direction(dimension: int, rng: np.random.Generator) -> Floats:
    direction = rng.normal(size=dimension)
    return np.asarray(direction / np.linalg.norm(direction))
