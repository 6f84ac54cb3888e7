"""Families with sharp corners, fine detail beside long smooth parts, or curves of very different size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from core.truth.curves import ParametricCurve, Term, chain, cos, harmonic, polar, polygon, power, sin
from core.truth.families import Curves, Family, ellipse

__all__ = ["HARD"]

_TURN = (0.0, 2 * np.pi)


def _arc(
    centre: tuple[float, float], radius: float, first: float, last: float, closed: bool = False
) -> ParametricCurve:
    """Make an arc of a circle from one angle to another, in radians."""
    x, y = centre
    return harmonic([power(x), cos(radius)], [power(y), sin(radius)], interval=(first, last), closed=closed)


def _naca() -> Curves:
    """Return NACA 2412 thickened to 18 %, camber added upright, with a closed trailing edge."""
    camber = [power(0.08, 2), power(-0.08, 4)]
    thickness = 0.9 * np.array([0.2969, -0.1260, -0.3516, 0.2843, -0.1036])

    def side(sign: float, interval: tuple[float, float]) -> ParametricCurve:
        # x = t^2: the profile's square root is then a polynomial
        y = [power(sign * a, k) for a, k in zip(thickness, (1, 2, 4, 6, 8), strict=True)]
        flipped = interval[0] < 0
        y = [one._replace(amplitude=-one.amplitude) if flipped and one.power == 1 else one for one in y]
        return harmonic([power(1.0, 2)], [*y, *camber], interval=interval, closed=False)

    return (chain((side(-1.0, (-1.0, 0.0)), side(1.0, (0.0, 1.0))), closed=True),)


def _gear() -> Curves:
    """Return a disc whose lower half has twelve trapezoid teeth."""
    teeth, low, high = 12, 1.0, 1.12
    step = np.pi / teeth
    rim: list[tuple[float, float]] = []
    for k in range(teeth):
        for share, radius in ((0.25, low), (0.35, high), (0.75, high), (0.85, low)):
            angle = np.pi + (k + share) * step
            rim.append((radius * np.cos(angle), radius * np.sin(angle)))
    smooth = _arc((0.0, 0.0), low, -0.15 * step, np.pi + 0.25 * step)
    return (chain((smooth, *_sides(polygon(rim, closed=False))), closed=True),)


def _sides(line: ParametricCurve) -> list[ParametricCurve]:
    """Cut an open polygonal curve at its corners."""
    stops = line.evaluate([0.0, *line.corners, 1.0])
    return [polygon(stops[k : k + 2], closed=False) for k in range(len(stops) - 1)]


def _half_gear() -> Curves:
    # r = 1 + 0.05 ((1 + cos t) / 2)^4 cos 20 t, the power written as a sum of cosines
    window = np.array([70, 112, 56, 16, 2]) / 256
    radius: list[Term] = [power(1.0), cos(0.05 * window[0], 20)]
    for k in range(1, 5):
        radius += [cos(0.025 * window[k], 20 + k), cos(0.025 * window[k], 20 - k)]
    return (polar(radius, _TURN, closed=True),)


def _key() -> Curves:
    """Return the outline of a key: a round bow, a long straight shank and five small teeth."""
    half, radius, end = 0.35, 1.0, 6.0
    opening = np.arcsin(half / radius)
    neck = radius * np.cos(opening)
    tips = [(end, -half), (end, half), (neck, half)]
    bits = [(4.0, -half)]
    for k in range(5):
        x = 4.0 + 0.36 * k
        bits += [(x + 0.12, -half - 0.3), (x + 0.24, -half - 0.3), (x + 0.36, -half)]
    outline = polygon([(neck, -half), *bits, *tips], closed=False)
    bow = _arc((0.0, 0.0), radius, opening, 2 * np.pi - opening)
    return (chain((bow, *_sides(outline)), closed=True),)


def _planets() -> Curves:
    """Return closed and open curves whose largest is thirty times as long as the smallest."""
    return (
        ellipse(3.0, 3.0),
        ellipse(0.1, 0.1, (-0.9, -0.9)),
        _arc((0.3, 0.2), 1.6, 0.2 * np.pi, 0.75 * np.pi),
        ellipse(0.5, 0.35, (1.3, -0.9), 0.4),
        _arc((-0.2, -0.2), 0.5, -0.2 * np.pi, 0.4 * np.pi),
    )


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    return lambda _seed: build()


HARD = (
    Family("naca", "an airfoil with a sharp trailing edge", _only(_naca), smooth=False, sigma=0.0025),
    Family(
        "gear",
        "a disc with twelve small teeth along one half: 48 corners and a smooth arc",
        _only(_gear),
        smooth=False,
        size=6000,
        sigma=0.002,
    ),
    Family(
        "half_gear",
        "a disc whose rim ripples finely on one side and is smooth on the other",
        _only(_half_gear),
        size=4000,
        sigma=0.0025,
    ),
    Family(
        "key",
        "a key: a round bow, a long straight shank, and small teeth",
        _only(_key),
        smooth=False,
        size=5000,
        sigma=0.002,
    ),
    Family(
        "planets",
        "closed and open curves of very different size, equally dense",
        _only(_planets),
        size=6000,
        sigma=0.0015,
    ),
    Family(
        "planets_equal",
        "closed and open curves of very different size, with equal numbers of samples",
        _only(_planets),
        size=3000,
        sigma=0.0015,
        equal_numbers=True,
    ),
)
