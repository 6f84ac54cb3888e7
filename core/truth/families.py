"""The built-in families of curves: the shapes of the paper's figures and their kin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.truth.curves import (
    ParametricCurve,
    bezier,
    cos,
    harmonic,
    polar,
    polygon,
    power,
    sin,
    spline,
)

__all__ = ["BUILT_IN", "Curves", "Family", "Scans", "ellipse"]

Floats = NDArray[np.float64]
Curves = tuple[ParametricCurve, ...]
TURN = (0.0, 2 * np.pi)


@dataclass(frozen=True, slots=True)
class Scans:
    """One curve seen by several registered scans (§5.1.1).

    Attributes
    ----------
    arcs : tuple of (float, float)
        First and last fraction of arc length that each scan sees; may run past 1 on a closed curve.
    misfit : float
        Standard deviation of each scan's registration error, in units of the noise.
    """

    arcs: tuple[tuple[float, float], ...]
    misfit: float


@dataclass(frozen=True, slots=True)
class Family:
    """A named set of exact curves and how it is sampled unless the caller says otherwise.

    Attributes
    ----------
    build : callable
        From a seed to the exact curves; families of one shape ignore the seed.
    smooth, non_crossing : bool
        Whether the curves are free of corners, and of self- and mutual crossings.
    size, sigma : int, float
        Default number of samples, and default noise as a fraction of the diagonal.
    density : callable or None
        Relative density of the samples over the fraction of arc length; None is uniform.
    varies : bool
        Whether the shape depends on the seed.
    equal_numbers : bool
        Whether every curve has as many samples as the next on average, whatever its length.
    """

    name: str
    description: str
    build: Callable[[int], Curves]
    smooth: bool = True
    non_crossing: bool = True
    size: int = 1500
    sigma: float = 0.01
    density: Callable[[Floats], Floats] | None = None
    scans: Scans | None = None
    varies: bool = False
    equal_numbers: bool = False


def ellipse(
    a: float, b: float, centre: tuple[float, float] = (0.0, 0.0), angle: float = 0.0
) -> ParametricCurve:
    """Make an ellipse with semi-axes a and b, turned by ``angle`` radians."""
    c, s = np.cos(angle), np.sin(angle)
    upright = harmonic([cos(a)], [sin(b)], interval=TURN, closed=True)
    return upright.moved([[c, -s], [s, c]], centre)


def _circle() -> Curves:
    return (ellipse(1.0, 1.0),)


def _ellipse() -> Curves:
    return (ellipse(2.5, 1.0),)


def _s_shape() -> Curves:
    upper = np.radians(np.linspace(10, 270, 9))
    arc = np.column_stack((np.cos(upper), 1 + np.sin(upper)))
    return (spline(np.vstack((arc, -arc[-2::-1])), closed=False),)


def _spiral() -> Curves:
    return (polar([power(1.0, 1)], (3.0, 3.0 + 6 * np.pi), closed=False),)


def _limacon() -> Curves:
    return (polar([power(1.0), cos(0.4)], TURN, closed=True),)


def _eight_to_one(fraction: Floats) -> Floats:
    return np.asarray(8.0 ** (0.5 * np.cos(2 * np.pi * fraction)))


def _square() -> Curves:
    return (polygon([(-1, -1), (1, -1), (1, 1), (-1, 1)], closed=True),)


def _star() -> Curves:
    angle = np.pi / 2 + np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, 1.0, 0.5)
    return (polygon(np.column_stack((radius * np.cos(angle), radius * np.sin(angle))), closed=True),)


def _wasp_waist() -> Curves:
    # y = sin t (0.28 + cos^2 t): a gentle waist of width 0.56 on a body of length 4
    return (harmonic([cos(2.0)], [sin(0.53), sin(0.25, 3)], interval=TURN, closed=True),)


def _figure_8() -> Curves:
    return (harmonic([cos(1.0)], [sin(0.5, 2)], interval=TURN, closed=True),)


def _double_8() -> Curves:
    t = np.arange(16) * 2 * np.pi / 16 + np.pi / 16
    return (spline(np.column_stack((3.0 * np.cos(t), 0.9 * np.sin(4 * t))), closed=True),)


def _lissajous() -> Curves:
    return (harmonic([cos(1.2, 3)], [sin(1.0, 2)], interval=TURN, closed=True),)


def _nested() -> Curves:
    return ellipse(1.0, 0.9), ellipse(0.65, 0.55, (0.0, 0.0), 0.1), ellipse(0.3, 0.22)


def _disjoint() -> Curves:
    wave = harmonic([power(1.0, 1)], [sin(0.4, 2.0), power(-1.5)], interval=(-2.6, 2.6), closed=False)
    arc = harmonic(
        [cos(0.75), power(0.1)], [sin(0.75), power(0.4)], interval=(-0.15 * np.pi, 1.1 * np.pi), closed=False
    )
    return ellipse(0.65, 0.65, (-2.1, 0.5)), ellipse(0.75, 0.45, (2.2, 0.4), 1.2), arc, wave


def _tilted() -> Curves:
    x, y = (np.array([2.0, 1.0, 0.5]), np.array([-1.0, 1.5, 1.0]))
    x /= np.linalg.norm(x)
    y -= (y @ x) * x
    y /= np.linalg.norm(y)
    flat = harmonic([cos(1.6)], [sin(1.0), cos(0.25, 2)], interval=TURN, closed=True)
    return (flat.moved(np.column_stack((x, y)), [0.5, -1.0, 2.0]),)


def _helix() -> Curves:
    z = [power(0.2, 1)]
    return (harmonic([cos(1.0)], [sin(1.0)], z, interval=(0.0, 6 * np.pi), closed=False),)


def _trefoil() -> Curves:
    x, y, z = [sin(1.0), sin(2.0, 2)], [cos(1.0), cos(-2.0, 2)], [sin(-1.2, 3)]
    return (harmonic(x, y, z, interval=TURN, closed=True),)


def _arc() -> Curves:
    return (harmonic([power(1.0, 1)], [power(1.0, 2)], interval=(-1.2, 1.2), closed=False),)


def _wave() -> Curves:
    return (harmonic([power(1.0, 1)], [sin(1.0)], interval=(0.0, 4 * np.pi), closed=False),)


def _flower() -> Curves:
    return (polar([power(1.0), cos(0.15, 5)], TURN, closed=True),)


def _airfoil() -> Curves:
    control = [(1, 0), (0.6, 0.18), (0.1, 0.42), (-0.3, 0.3), (-0.3, -0.25), (0.2, -0.22), (0.6, 0.0), (1, 0)]
    return (bezier(control, closed=True, corners=(0.0,)),)


def _bust() -> Curves:
    radius = [power(1.0), cos(0.13), sin(0.05), cos(0.11, 2), cos(-0.05, 3), sin(0.035, 4), cos(0.025, 5)]
    return (polar(radius, TURN, closed=True),)


_BUST_SCANS = Scans(
    ((0.0, 0.31), (0.12, 0.45), (0.38, 0.55), (0.52, 0.84), (0.6, 0.79), (0.8, 1.04), (0.9, 1.18)), misfit=0.6
)


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    """Make a builder of one shape from a function without a seed."""
    return lambda _seed: build()


BUILT_IN = (
    Family("circle", "a circle", _only(_circle)),
    Family("ellipse", "an ellipse with axes 2.5 to 1", _only(_ellipse)),
    Family("s_shape", "an open S (Fig. 5)", _only(_s_shape)),
    Family("spiral", "an open Archimedean spiral of three turns", _only(_spiral)),
    Family(
        "non_uniform",
        "a limacon sampled eight times more densely on one side than on the other (Fig. 6a)",
        _only(_limacon),
        density=_eight_to_one,
    ),
    Family("square", "a square: four corners", _only(_square), smooth=False),
    Family("star", "a five-pointed star: ten corners", _only(_star), smooth=False),
    Family(
        "wasp_waist", "a closed curve with a narrow waist that does not touch (Fig. 11c)", _only(_wasp_waist)
    ),
    Family(
        "figure_8", "a closed curve that crosses itself once (Fig. 6)", _only(_figure_8), non_crossing=False
    ),
    Family(
        "double_8",
        "a closed chain of Bezier cubics with three crossings (Fig. 10)",
        _only(_double_8),
        non_crossing=False,
        size=3000,
        sigma=0.008,
    ),
    Family(
        "lissajous",
        "a closed Lissajous curve with seven crossings",
        _only(_lissajous),
        non_crossing=False,
        size=4000,
        sigma=0.005,
    ),
    Family("nested", "three closed curves, one inside another", _only(_nested), size=2500),
    Family("disjoint", "two closed and two open curves beside each other", _only(_disjoint), size=3000),
    Family("tilted", "a closed planar curve in a tilted plane of space", _only(_tilted)),
    Family("helix", "three turns of a helix in space", _only(_helix), size=2000),
    Family("trefoil", "a trefoil knot in space", _only(_trefoil), size=2500),
    Family("arc", "an open arc of a parabola", _only(_arc), size=800),
    Family("wave", "two periods of a sine, open", _only(_wave)),
    Family("flower", "a rounded flower with five lobes", _only(_flower)),
    Family(
        "airfoil",
        "a smooth profile with a corner at its trailing edge",
        _only(_airfoil),
        smooth=False,
        sigma=0.005,
    ),
    Family(
        "multi_scan",
        "the outline of a bust as several registered scans see it (Fig. 3a)",
        _only(_bust),
        size=3000,
        sigma=0.006,
        scans=_BUST_SCANS,
    ),
)
