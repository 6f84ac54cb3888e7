"""Families kept apart: only final figures are measured with them, and no method is tuned with them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from core.truth.curves import ParametricCurve, Term, chain, cos, harmonic, polar, power, sin, spline
from core.truth.families import Curves, Family, ellipse
from core.truth.intersections import crossings, separation

__all__ = ["APART"]

Floats = NDArray[np.float64]

_TURN = (0.0, 2 * np.pi)
_CLEARANCE = 0.1  # of the diagonal, between branches of random curves
_TIGHTEST = 0.05  # radius of curvature of random curves, of the diagonal


def _cardioid() -> Curves:
    # r = 1 + 0.62 cos t: the dimple of a limacon that stays short of a cusp
    return (polar([power(1.0), cos(0.62)], _TURN, closed=True),)


def _clothoid() -> Curves:
    """Return a double Euler spiral: curvature proportional to the way from its middle."""
    s = np.linspace(-3.0, 3.0, 241)
    fine = np.linspace(-3.0, 3.0, 24001)
    heading = 0.5 * fine**2
    velocity = np.column_stack((np.cos(heading), np.sin(heading)))
    way = np.vstack((np.zeros((1, 2)), np.cumsum((velocity[1:] + velocity[:-1]) / 2, axis=0)))
    return (spline(way[:: len(fine) // (len(s) - 1)] * (fine[1] - fine[0]), closed=False),)


def _plectrum() -> Curves:
    x = [cos(1.4), cos(0.15, 2), sin(0.12, 2)]
    y = [sin(0.9), cos(0.2, 2), cos(-0.03, 3)]
    return (harmonic(x, y, interval=_TURN, closed=True),)


def _chirp() -> Curves:
    # sin(t + 0.06 t^2) has no such form in t: a spline through it, dense enough to be the curve itself
    t = np.linspace(0.0, 12.0, 361)
    return (spline(np.column_stack((t, 0.5 * np.sin(t + 0.06 * t**2))), closed=False),)


def _catenaries() -> Curves:
    """Return a chain of hanging spans, rounded where they are held: three open garlands."""

    def garland(height: float) -> ParametricCurve:
        x = np.linspace(-3.6, 3.6, 289)
        span = np.cosh(1.3 * (np.mod(x, 2.4) - 1.2)) / np.cosh(1.3 * 1.2)
        window = np.exp(-0.5 * (np.arange(-36, 37) * (x[1] - x[0]) / 0.3) ** 2)
        held = np.convolve(np.pad(span, 36, mode="reflect"), window / window.sum(), mode="valid")
        return spline(np.column_stack((x, 1.4 * held + height)), closed=False)

    return garland(0.0), garland(1.2), garland(2.4)


def _parallel_arcs() -> Curves:
    """Return four open arcs of circles about one centre."""
    return tuple(
        harmonic([cos(r)], [sin(r)], interval=(0.15 * np.pi + 0.1 * k, 1.05 * np.pi - 0.15 * k), closed=False)
        for k, r in enumerate((1.0, 1.5, 2.0, 2.5))
    )


def _horseshoe() -> Curves:
    """Return a closed band bent into a horseshoe: long parallel sides and round ends."""

    def half(radius: float, first: float, last: float, centre: tuple[float, float]) -> ParametricCurve:
        x, y = [power(centre[0]), cos(radius)], [power(centre[1]), sin(radius)]
        return harmonic(x, y, interval=(first, last), closed=False)

    a, b, turn = 1.0, 1.5, 1.35 * np.pi
    start, end = 1.5 * np.pi - turn / 2 + np.pi, 1.5 * np.pi + turn / 2 + np.pi
    middle, cap = (a + b) / 2, (b - a) / 2
    tip, foot = ((middle * np.cos(at), middle * np.sin(at)) for at in (end, start))
    pieces = (
        half(b, start, end, (0.0, 0.0)),
        half(cap, end, end + np.pi, tip),
        half(a, end, start, (0.0, 0.0)),
        half(cap, start + np.pi, start + 2 * np.pi, foot),
    )
    return (chain(pieces, closed=True),)


def _tilted_rose() -> Curves:
    x, y = np.array([1.0, 2.0, -1.0]), np.array([1.0, 0.0, 1.0])
    axes = np.column_stack((x / np.linalg.norm(x), y / np.linalg.norm(y)))
    flat = polar([power(1.0), cos(0.22, 3), sin(0.06, 2)], _TURN, closed=True)
    return (flat.moved(axes, (3.0, 1.0, -2.0)),)


def _tilted_pair() -> Curves:
    """Return a closed and an open curve in one tilted plane."""
    axes = np.array([(0.6, 0.0), (0.0, 1.0), (0.8, 0.0)])
    wave = harmonic([power(1.0, 1)], [sin(0.35, 2.0), power(1.6)], interval=(-2.0, 2.0), closed=False)
    return ellipse(1.6, 0.7, (0.0, 0.0), 0.2).moved(axes, (0, 0, 0)), wave.moved(axes, (0, 0, 0))


def _torus_winding() -> Curves:
    x = [cos(2.0), cos(0.35, 4), cos(0.35, 2)]
    y = [sin(2.0), sin(0.35, 4), sin(-0.35, 2)]
    return (harmonic(x, y, [sin(0.7, 3)], interval=_TURN, closed=True),)


def _gently_closed(rng: np.random.Generator) -> ParametricCurve:
    """Draw a blob: a polar curve whose radius is a random Fourier series."""
    orders = np.arange(1, 8)
    amplitude = 0.5 * rng.normal(size=7) / orders**1.4
    phase = rng.uniform(0, 2 * np.pi, size=7)
    radius = [Term(*one) for one in zip(amplitude, orders.astype(float), phase, strict=True)]
    return polar([power(1.0), *radius], _TURN, closed=True)


def _fourier_open(rng: np.random.Generator) -> ParametricCurve:
    """Draw an arc of a random Fourier curve that drifts to one side."""
    orders = np.arange(1, 6)

    def coordinate() -> list[Term]:
        amplitude, phase = rng.normal(size=5) / orders**2.2, rng.uniform(0, 2 * np.pi, size=5)
        return [Term(*one) for one in zip(amplitude, orders.astype(float), phase, strict=True)]

    drift = [power(rng.uniform(0.3, 0.8), 1)]
    return harmonic([*drift, *coordinate()], coordinate(), interval=(0.0, 1.8 * np.pi), closed=False)


def _drawn(
    candidate: Callable[[np.random.Generator], ParametricCurve], rng: np.random.Generator
) -> ParametricCurve:
    """Draw candidates until one bends gently and keeps clear of itself."""
    while True:
        curve = candidate(rng)
        vertices = curve.polyline(240)
        diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
        line = [(vertices, curve.closed)]
        if curve.curvature(np.linspace(0.0, 1.0, 400)).max() * diagonal * _TIGHTEST > 1.0:
            continue
        if separation(line) > _CLEARANCE * diagonal and not len(crossings(line).locations):
            return curve


def _blob(seed: int) -> Curves:
    return (_drawn(_gently_closed, np.random.default_rng([6, seed])),)


def _meander(seed: int) -> Curves:
    return (_drawn(_fourier_open, np.random.default_rng([7, seed])),)


def _nested_blobs(seed: int) -> Curves:
    """Return three copies of one kind of blob, each star-shaped about the centre, one inside another."""
    rng = np.random.default_rng([8, seed])
    orders = np.arange(2, 6)
    curves = []
    for size in (1.0, 0.64, 0.3):
        amplitude = size * np.clip(rng.normal(size=4), -1.0, 1.0) * 0.1 / orders
        phase = rng.uniform(0, 2 * np.pi, size=4)
        ripple = [Term(*one) for one in zip(amplitude, orders.astype(float), phase, strict=True)]
        curves.append(polar([power(size), *ripple], _TURN, closed=True))
    return tuple(curves)


def _trochoid_loops() -> Curves:
    # R = 4, r = 1, arm 2.2: four loops outside, which cross at right angles or nearly so
    return (harmonic([cos(3.0), cos(2.2, 3)], [sin(3.0), sin(-2.2, 3)], interval=_TURN, closed=True),)


def _interlocked() -> Curves:
    """Return five rings, each of which crosses its neighbours, as on the flag of the games."""
    centres = ((-2.3, 0.5), (0.0, 0.5), (2.3, 0.5), (-1.15, -0.6), (1.15, -0.6))
    return tuple(ellipse(1.0, 1.0, one) for one in centres)


def _only(build: Callable[[], Curves]) -> Callable[[int], Curves]:
    return lambda _seed: build()


APART = (
    Family("cardioid", "a dimpled limacon", _only(_cardioid)),
    Family("clothoid", "a double Euler spiral, open", _only(_clothoid), size=2000),
    Family("plectrum", "a rounded triangle of uneven sides", _only(_plectrum)),
    Family("chirp", "a wave whose frequency grows, open", _only(_chirp), size=2500, sigma=0.005),
    Family("catenaries", "three garlands of hanging chains, open", _only(_catenaries), size=3000),
    Family("parallel_arcs", "four open arcs about one centre", _only(_parallel_arcs), size=2500),
    Family("horseshoe", "a closed band bent round, with long parallel sides", _only(_horseshoe), size=2000),
    Family("tilted_rose", "a closed curve with three lobes in a tilted plane", _only(_tilted_rose)),
    Family("tilted_pair", "a closed and an open curve in one tilted plane", _only(_tilted_pair), size=2000),
    Family("torus_winding", "a closed curve that winds about a torus", _only(_torus_winding), size=2500),
    Family("blob", "a random closed polar curve, another for each seed", _blob, varies=True),
    Family("meander", "a random open Fourier curve, another for each seed", _meander, varies=True),
    Family(
        "nested_blobs",
        "three random closed curves inside each other, others for each seed",
        _nested_blobs,
        size=2500,
        varies=True,
    ),
    Family(
        "trochoid_loops",
        "a closed hypotrochoid that crosses itself at four loops",
        _only(_trochoid_loops),
        non_crossing=False,
        size=3000,
    ),
    Family(
        "interlocked",
        "five rings that cross their neighbours",
        _only(_interlocked),
        non_crossing=False,
        size=5000,
        sigma=0.005,
    ),
)
