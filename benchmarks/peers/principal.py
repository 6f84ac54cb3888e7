"""The peers pcurvepy2 and prinpy: principal curves, told where each curve's samples are."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from pcurvepy2 import PrincipalCurve
from prinpy.local_curves import ConstrainedFitter, GreedyFit, SVDFit

from benchmarks.peers.told import Answer, Told, subset

__all__ = ["run_hastie", "run_local", "settings_hastie", "settings_local"]

Floats = NDArray[np.float64]
Hastie = tuple[bool, float]
Local = tuple[str, float, bool]

LOCAL = {
    "greedy": GreedyFit(),
    "greedy, inner radius 0.5": GreedyFit(inner_radius=0.5),
    "SVD": SVDFit(),
}


def settings_hastie(told: Told, n: int) -> Iterator[tuple[str, Hastie]]:
    """Yield where to start, and factors of the sum of squares that the noise explains (the smoothness)."""
    del told, n
    yield "own start, s = 0.4 n σ²", (False, 0.4)
    for factor in (0.2, 0.4, 0.7):
        yield f"start told, s = {factor:g} n σ²", (True, factor)


def run_hastie(parts: list[Floats], told: Told, setting: Hastie) -> Answer:
    """Fit splines over the projections (Hastie, Stuetzle 1989)."""
    is_told, factor = setting
    starts = iter(told.starts)

    def fit(some: Floats) -> Floats:
        start = np.array(next(starts)) if is_told else None
        curve = PrincipalCurve(k=3)
        curve.fit(some, initial_points=start, param_s=factor * len(some) * told.sigma**2, max_iter=20)
        return np.asarray(curve.points)

    return _each(parts, told, fit)


def settings_local(told: Told, n: int) -> Iterator[tuple[str, Local]]:
    """Yield algorithms, tolerances in sigma, and whether the samples come sorted by the principal axis."""
    del told, n
    for name in LOCAL:
        for tolerance in (2.0, 4.0, 8.0, 16.0):
            for is_sorted in (False, True):
                words = f"{name}, tolerance {tolerance:g} σ{', sorted' if is_sorted else ''}"
                yield words, (name, tolerance, is_sorted)


def run_local(parts: list[Floats], told: Told, setting: Local) -> Answer:
    """Grow a curve piece by piece (constrained local principal curves)."""
    name, tolerance, is_sorted = setting

    def fit(some: Floats) -> Floats:
        if is_sorted:
            axis = np.linalg.svd(some - some.mean(axis=0), full_matrices=False)[2][0]
            some = some[np.argsort(some @ axis)]
        curve = ConstrainedFitter(algorithm=LOCAL[name], tolerance=tolerance * told.sigma).fit(some)
        return np.asarray(curve.interpolate_from_unit(np.linspace(0.0, 1.0, 400)).points, np.float64)

    return _each(parts, told, fit)


def _each(parts: list[Floats], told: Told, fit: Callable[[Floats], Floats]) -> Answer:
    """Fit each curve's samples; what is told to be closed is closed, for these peers fit open curves only."""
    pairs = [(subset(part, told), closed) for part, closed in zip(parts, told.closed, strict=True)]
    return Answer(curves=[(fit(some), closed) for some, closed in pairs if len(some) > 5])
