"""Families that no method was tuned with: only tests and benchmarks use them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from core.truth.curves import ParametricCurve, Term, cos, harmonic, polar, power, sin, spline
from core.truth.families import Family
from core.truth.intersections import crossings, separation

__all__ = ["HELD_OUT"]

Floats = NDArray[np.float64]
Curves = tuple[ParametricCurve, ...]
TURN = (0.0, 2 * np.pi)

_CLEARANCE = 0.125  # of the diagonal: more than six standard deviations of the largest noise tested
_TIGHTEST = 0.06  # smallest radius of curvature, of the diagonal


def _egg() -> Curves:
    return (harmonic([cos(1.3), cos(0.15, 2)], [sin(1.0), sin(0.06, 2)], interval=TURN, closed=True),)


def _hypotrochoid() -> Curves:
    # R = 4, r = 1: four rounded sides without loops for arm lengths below 1
    return (harmonic([cos(3.0), cos(0.25, 3)], [sin(3.0), sin(-0.25, 3)], interval=TURN, closed=True),)


def _bean() -> Curves:
    x = [cos(1.0), cos(0.06, 2)]
    y = [sin(0.7), cos(0.2, 2)]
    return (harmonic(x, y, interval=TURN, closed=True),)


def _archimedean() -> Curves:
    return (polar([power(2.0), power(0.8, 1)], (0.0, 4 * np.pi), closed=False),)


def _c_arc() -> Curves:
    return (harmonic([cos(1.0)], [sin(1.0)], interval=(np.pi / 6, 11 * np.pi / 6), closed=False),)


def _cubic() -> Curves:
    return (harmonic([power(1.0, 1)], [power(1.0, 3), power(-0.9, 1)], interval=(-1.3, 1.3), closed=False),)


def _parallel_waves() -> Curves:
    def wave(height: float) -> ParametricCurve:
        x, y = [power(1.0, 1)], [sin(0.5), power(height)]
        return harmonic(x, y, interval=(0.0, 3 * np.pi), closed=False)

    return wave(0.0), wave(2.0)


def _saddle() -> Curves:
    return (harmonic([cos(1.0)], [sin(1.0)], [cos(0.4, 2)], interval=TURN, closed=True),)


def _closed_candidate(rng: np.random.Generator) -> ParametricCurve:
    def coordinate() -> list[Term]:
        orders = np.arange(1, 6)
        amplitude = rng.normal(size=5) / orders**2.2
        phase = rng.uniform(0, 2 * np.pi, size=5)
        return [Term(*row) for row in zip(amplitude, orders.astype(float), phase, strict=True)]

    return harmonic(coordinate(), coordinate(), interval=TURN, closed=True)


def _open_candidate(rng: np.random.Generator) -> ParametricCurve:
    heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(scale=0.8, size=9))
    steps = np.column_stack((np.cos(heading), np.sin(heading)))
    return spline(np.vstack((np.zeros((1, 2)), np.cumsum(steps, axis=0))), closed=False)


def _is_clear(curve: ParametricCurve) -> bool:
    """Tell whether a curve keeps its distance from itself and bends gently."""
    vertices = curve.polyline(240)
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    if curve.curvature(np.linspace(0, 1, 400)).max() * diagonal > 1 / _TIGHTEST:
        return False
    line = [(vertices, curve.closed)]
    return bool(separation(line) > _CLEARANCE * diagonal) and not len(crossings(line).locations)


def _random(
    candidate: Callable[[np.random.Generator], ParametricCurve], stream: int
) -> Callable[[int], Curves]:
    """Make a builder that draws candidates until one is clear; the same seed, the same curve."""

    def build(seed: int) -> Curves:
        rng = np.random.default_rng([stream, seed])
        while True:
            curve = candidate(rng)
            if _is_clear(curve):
                return (curve,)

    return build


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    return lambda _seed: build()


HELD_OUT = (
    Family("egg", "a smooth asymmetric oval", _only(_egg)),
    Family("hypotrochoid", "a rounded square without loops", _only(_hypotrochoid)),
    Family("bean", "a closed curve with one shallow bay", _only(_bean)),
    Family("archimedean", "an open spiral of two turns", _only(_archimedean)),
    Family("c_arc", "300 degrees of a circle, open", _only(_c_arc)),
    Family("cubic", "the graph of a cubic, open", _only(_cubic)),
    Family("parallel_waves", "two open waves side by side", _only(_parallel_waves)),
    Family("saddle", "a closed curve in space that lies in no plane", _only(_saddle)),
    Family(
        "random_closed",
        "a random closed Fourier curve, another for each seed",
        _random(_closed_candidate, 1),
        varies=True,
    ),
    Family(
        "random_open", "a random open spline, another for each seed", _random(_open_candidate, 2), varies=True
    ),
)
