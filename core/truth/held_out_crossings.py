"""Families with crossings and junctions that no method was tuned with, random ones among them."""

from __future__ import annotations

from collections.abc import Callable, Container

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist, pdist

from core.truth.crossing_families import looped_polygon
from core.truth.curves import ParametricCurve, Term, cos, harmonic, power, sin, spline
from core.truth.families import Curves, Family, ellipse
from core.truth.intersections import Crossings, arc_lengths, crossings

__all__ = ["HELD_OUT_CROSSING"]

Floats = NDArray[np.float64]
TURN = (0.0, 2 * np.pi)

# of random curves; lengths in diagonals
_MOST = 6  # crossings of a closed curve
_STEEPEST = np.cos(np.radians(40.0))  # of the angle between two branches that cross
_APART = 0.15  # two crossings, and a crossing and an open end
_CLEARANCE = 0.12  # two branches that do not cross near by
_NEAR = 0.25  # of arc length on both branches: there, a crossing is the reason why they are close
_TIGHTEST = 0.05  # radius of curvature


def _bow() -> Curves:
    x, y = [power(1.0, 1), sin(2.3)], [cos(2.3), power(0.1, 2)]
    return (harmonic(x, y, interval=(-1.75 * np.pi, 1.75 * np.pi), closed=False),)


def _trifolium_ribbon() -> Curves:
    return (looped_polygon(3, 0.45),)


def _pentagram() -> Curves:
    return (harmonic([cos(1.0, 2), cos(0.3, 3)], [sin(1.0, 2), sin(-0.3, 3)], interval=TURN, closed=True),)


def _linked_ellipses() -> Curves:
    return ellipse(2.0, 0.9), ellipse(2.0, 0.9, (0.1, -0.05), np.radians(80.0))


def _theta() -> Curves:
    ring = ellipse(1.5, 1.1)
    left, right = ring.evaluate([0.46, 0.06])
    middle = (left + right) / 2 + (0.1, -0.35)
    return ring, spline([left, middle, right], closed=False)


def _fork() -> Curves:
    stem = harmonic([power(1.0, 1)], [sin(0.3)], interval=(-2.5, 2.5), closed=False)
    foot = stem.evaluate([0.4])[0]
    return stem, spline(foot + np.array([(0.0, 0.0), (0.7, 0.9), (1.7, 1.6)]), closed=False)


def _closed_candidate(rng: np.random.Generator) -> ParametricCurve:
    """Draw two or three circular motions, with a little of others; or two independent coordinates."""
    if rng.uniform() < 0.5:
        orders = np.array([1.0, 2.0])
        x, y = (_terms(rng, rng.normal(size=2) / orders, orders) for _ in range(2))
        return harmonic(x, y, interval=TURN, closed=True)
    orders = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
    amplitude = 0.1 * rng.rayleigh(size=8)
    main = rng.choice(8, size=rng.integers(2, 4), replace=False)
    amplitude[main] = rng.rayleigh(size=len(main))
    x = _terms(rng, amplitude / np.abs(orders), orders)
    y = [one._replace(phase=one.phase - np.pi / 2) for one in x]
    return harmonic(x, y, interval=TURN, closed=True)


def _terms(rng: np.random.Generator, amplitude: Floats, orders: Floats) -> list[Term]:
    phase = rng.uniform(0, 2 * np.pi, size=len(orders))
    return [Term(*row) for row in zip(amplitude, orders, phase, strict=True)]


def _open_candidate(rng: np.random.Generator) -> ParametricCurve:
    """Draw a walk of even steps whose turns are alike from one to the next."""
    turns = rng.normal(scale=0.3) + rng.normal(size=24)
    for k in range(1, 24):
        turns[k] = 0.7 * turns[k - 1] + 0.3 * turns[k]
    heading = np.cumsum(turns)
    steps = np.column_stack((np.cos(heading), np.sin(heading)))
    return spline(np.vstack((np.zeros((1, 2)), np.cumsum(steps, axis=0))), closed=False)


def _is_fit(curve: ParametricCurve, wanted: Container[int]) -> bool:
    """Tell whether a curve crosses itself as often as wanted, and does so clearly."""
    u = np.linspace(0.0, 1.0, 240, endpoint=not curve.closed)
    vertices = curve.evaluate(u)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if curve.curvature(u).max() * diagonal * _TIGHTEST > 1.0:
        return False
    found = crossings([(vertices, curve.closed)])
    return (
        len(found.locations) in wanted
        and _are_steep(curve, found, len(vertices))
        and _are_apart(vertices, curve.closed, found.locations, _APART * diagonal)
        and _is_clear(vertices, curve.closed, found.positions, diagonal)
    )


def _are_steep(curve: ParametricCurve, found: Crossings, count: int) -> bool:
    u = found.positions / (count - (not curve.closed))
    first, second = curve.tangent(u[:, 0]), curve.tangent(u[:, 1])
    return bool(np.abs(np.einsum("ij,ij->i", first, second)).max() < _STEEPEST)


def _are_apart(vertices: Floats, closed: bool, places: Floats, distance: float) -> bool:
    """Tell whether crossings keep their distance from each other and from open ends."""
    ends = vertices[:0] if closed else vertices[[0, -1]]
    nearest = min(pdist(places).min(initial=np.inf), cdist(places, ends).min(initial=np.inf))
    return bool(nearest > distance)


def _is_clear(vertices: Floats, closed: bool, positions: Floats, diagonal: float) -> bool:
    """Tell whether branches keep their distance wherever they do not cross near by."""
    way = arc_lengths(vertices, closed)
    chord = cdist(vertices, vertices)
    excused = way <= 2 * chord
    for place in np.round(positions).astype(int) % len(vertices):
        first, second = (way[k] < _NEAR * diagonal for k in place)
        excused |= np.outer(first, second) | np.outer(second, first)
    return bool(chord[~excused].min(initial=np.inf) > _CLEARANCE * diagonal)


def _random_closed(seed: int) -> Curves:
    rng = np.random.default_rng([3, seed])
    wanted = [(1,), range(2, _MOST + 1)][rng.integers(2)]
    return _drawn(rng, _closed_candidate, wanted)


def _random_open(seed: int) -> Curves:
    rng = np.random.default_rng([4, seed])
    return _drawn(rng, _open_candidate, (int(rng.integers(1, 3)),))


def _drawn(
    rng: np.random.Generator,
    candidate: Callable[[np.random.Generator], ParametricCurve],
    wanted: Container[int],
) -> Curves:
    """Draw candidates until one is fit."""
    while True:
        curve = candidate(rng)
        if _is_fit(curve, wanted):
            return (curve,)


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    return lambda _seed: build()


def _crossing(
    name: str, description: str, build: Callable[[int], Curves], *, size: int = 2000, varies: bool = False
) -> Family:
    return Family(name, description, build, non_crossing=False, size=size, varies=varies)


HELD_OUT_CROSSING = (
    _crossing("bow", "an open bow with two loops", _only(_bow)),
    _crossing("trifolium_ribbon", "a triangle with a loop at each corner", _only(_trifolium_ribbon)),
    _crossing("pentagram", "a rounded five-pointed star that crosses itself five times", _only(_pentagram)),
    _crossing("linked_ellipses", "two ellipses that cross four times", _only(_linked_ellipses)),
    _crossing("theta", "a closed curve with an open one across, which ends on it", _only(_theta)),
    _crossing("fork", "an open curve that leaves another one at a slant", _only(_fork)),
    _crossing(
        "random_crossing",
        "a random closed Fourier curve that crosses itself, another for each seed",
        _random_closed,
        size=3000,
        varies=True,
    ),
    _crossing(
        "random_open_crossing",
        "a random open spline that crosses itself, another for each seed",
        _random_open,
        size=3000,
        varies=True,
    ),
)
