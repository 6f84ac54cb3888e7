"""How much room the noise and the spacing of a point set leave to its true curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from core.truth.curves import ParametricCurve
from core.truth.intersections import arc_lengths
from core.truth.point_sets import PointSet

__all__ = ["Clearance", "clearance"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_VERTICES = 800  # of each curve
_PLACES = 4096  # of each curve where its curvature is looked at
_DETOUR = 2.0  # way over chord from which on two places are on different branches: pi / 2 on a circle
_WEDGE = 2.0  # chords from a crossing within which its arms are near each other because of it


@dataclass(frozen=True, slots=True)
class Clearance:
    """Room left to the true curves; infinite where there is nothing to come near.

    Attributes
    ----------
    separation : float
        Smallest distance between two branches, in units of sigma: between two curves, or two places
        of one curve that are more than twice as far apart along it as in a straight line. The arms of
        crossings and junctions at 30 degrees or more are left out; a corner sharper than 60 degrees counts
        as branches that meet.
    radius : float
        Smallest radius of curvature, in units of sigma; 0 where there are corners.
    gap : float
        Largest way between neighbouring samples along a true curve, in units of that curve's mean spacing.
    """

    separation: float
    radius: float
    gap: float


def clearance(sample: PointSet) -> Clearance:
    """Return the room that a point set leaves to its true curves.

    Examples
    --------
    >>> from core.truth.point_sets import point_set
    >>> room = clearance(point_set("circle", n=100, sigma=0.01))  # its radius is 35 % of its diagonal
    >>> room.separation, round(room.radius, 2)
    (inf, 35.36)
    """
    exact = tuple(one.exact for one in sample.curves)
    places = np.concatenate((sample.crossings, sample.junctions))
    unit = sample.sigma or np.finfo(float).tiny
    near = _separation(exact, tuple(map(tuple, places.tolist())))
    return Clearance(near / unit, _radius(exact) / unit, _gap(sample))


@lru_cache(maxsize=64)
def _separation(curves: Sequence[ParametricCurve], places: Sequence[tuple[float, ...]]) -> float:
    """Return the smallest distance between branches, in the units of the curves."""
    lines = [one.polyline(_VERTICES) for one in curves]
    smallest = np.inf
    for k, (one, line) in enumerate(zip(curves, lines, strict=True)):
        chord = cdist(line, line)
        apart = (arc_lengths(line, one.closed) > _DETOUR * chord) & ~_excused(line, line, chord, places)
        np.fill_diagonal(apart, False)
        smallest = min(smallest, float(chord[apart].min(initial=np.inf)))
        for other in lines[k + 1 :]:
            chord = cdist(line, other)
            apart = ~_excused(line, other, chord, places)
            smallest = min(smallest, float(chord[apart].min(initial=np.inf)))
    return smallest


def _excused(one: Floats, other: Floats, chord: Floats, places: Sequence[tuple[float, ...]]) -> Bools:
    """Tell which pairs of vertices are near each other because their branches meet close by."""
    result = np.zeros(chord.shape, bool)
    for place in places:
        first, second = (np.linalg.norm(line - place, axis=1) for line in (one, other))
        result |= np.maximum(first[:, None], second) <= _WEDGE * chord
    return result


@lru_cache(maxsize=64)
def _radius(curves: Sequence[ParametricCurve]) -> float:
    """Return the smallest radius of curvature, in the units of the curves."""
    if any(one.corners for one in curves):
        return 0.0
    u = np.linspace(0.0, 1.0, _PLACES)
    sharpest = max(float(one.curvature(u).max()) for one in curves)
    return 1.0 / sharpest if sharpest else np.inf


def _gap(sample: PointSet) -> float:
    """Return the largest gap on any curve, in mean spacings of its samples; infinite without two of them."""
    largest = 0.0
    for k, one in enumerate(sample.curves):
        u = np.sort(sample.u[sample.curve_of == k])
        if len(u) < 2:
            return np.inf
        steps = np.diff(u, append=u[0] + 1.0) if one.closed else np.diff(u)
        largest = max(largest, float(steps.max()) * len(u))
    return largest
