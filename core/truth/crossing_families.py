"""The built-in families whose curves cross themselves, cross each other, or end on each other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from core.truth.curves import ParametricCurve, bezier, cos, harmonic, polar, polygon, power, sin, spline
from core.truth.families import Curves, Family, ellipse

__all__ = ["CROSSING", "looped_polygon"]

TURN = (0.0, 2 * np.pi)


def looped_polygon(corners: int, radius: float) -> ParametricCurve:
    """Make a regular polygon of circumradius 1 that passes each corner and comes back in a round loop.

    The sides cross at the corners, so that the crossing angle is the polygon's own.

    Parameters
    ----------
    corners : int
    radius : float
        Radius of the loops.
    """
    turn = 2 * np.pi / corners
    overrun = radius / np.tan((np.pi - turn) / 2)  # where the loop's circle touches the prolonged sides
    points = []
    for k in range(corners):
        corner = np.array([np.cos(k * turn), np.sin(k * turn)])
        heading = (k - 0.5) * turn + np.pi / 2
        along = np.array([np.cos(heading), np.sin(heading)])
        centre = corner + overrun * along + radius * np.array([along[1], -along[0]])
        angle = heading + np.pi / 2 - np.linspace(0.0, 2 * np.pi - turn, 9)
        loop = centre + radius * np.column_stack((np.cos(angle), np.sin(angle)))
        points += [corner, *loop, corner]
    middles = [(points[11 * k - 1] + points[11 * k]) / 2 for k in range(corners)]
    chain = [row for k in range(corners) for row in (middles[k], *points[11 * k : 11 * k + 11])]
    return spline(chain, closed=True)


def _ribbon() -> Curves:
    x, y = [power(1.0, 3), power(-3.0, 1)], [power(1.6, 2)]
    return (harmonic(x, y, interval=(-2.2, 2.2), closed=False),)


def _limacon_loop() -> Curves:
    return (polar([power(1.0), cos(2.2)], TURN, closed=True),)


def _looped_square() -> Curves:
    return (looped_polygon(4, 0.55),)


def _two_circles() -> Curves:
    return ellipse(1.0, 1.0), ellipse(0.85, 0.85, (1.15, 0.35))


def _pretzel() -> Curves:
    return (harmonic([sin(1.0), sin(1.6, 2)], [cos(1.0), cos(-1.6, 2)], interval=TURN, closed=True),)


def _wave_line() -> Curves:
    wave = harmonic([power(1.0, 1)], [sin(1.5)], interval=(-2.2, 8.5), closed=False)
    return wave, polygon([(-2.9, 0.0), (9.2, 0.0)], closed=False)


def _t_junction() -> Curves:
    bar = harmonic([power(1.0, 1)], [power(-0.15, 2)], interval=(-2.0, 2.0), closed=False)
    foot = bar.evaluate([0.55])[0]
    return bar, bezier(foot + np.array([(0.0, 0.0), (0.1, -1.2), (-0.5, -2.4)]), closed=False)


def _y_junction() -> Curves:
    def arm(angle: float) -> ParametricCurve:
        c, s = np.cos(angle), np.sin(angle)
        bow = bezier([(0.0, 0.0), (0.9, 0.0), (1.8, 0.3)], closed=False)
        return bow.moved([[c, -s], [s, c]], (0.0, 0.0))

    return tuple(arm(np.pi / 2 + k * 2 * np.pi / 3) for k in range(3))


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    return lambda _seed: build()


CROSSING = (
    Family("ribbon", "an open ribbon with one loop", _only(_ribbon), non_crossing=False),
    Family(
        "limacon_loop",
        "a limacon: its inner loop touches the outer one where it crosses",
        _only(_limacon_loop),
        non_crossing=False,
        size=2000,
    ),
    Family(
        "looped_square",
        "a square with a loop at each corner: four crossings",
        _only(_looped_square),
        non_crossing=False,
        size=3000,
    ),
    Family(
        "two_circles",
        "two circles that cross each other twice",
        _only(_two_circles),
        non_crossing=False,
        size=2000,
    ),
    Family(
        "pretzel",
        "the plane shadow of a trefoil knot: three crossings",
        _only(_pretzel),
        non_crossing=False,
        size=3000,
    ),
    Family(
        "wave_line",
        "an open wave and a straight line through it",
        _only(_wave_line),
        non_crossing=False,
        size=2500,
    ),
    Family("t_junction", "an open curve that ends on another one", _only(_t_junction), non_crossing=False),
    Family("y_junction", "three open arms that meet at 120 degrees", _only(_y_junction), non_crossing=False),
)
