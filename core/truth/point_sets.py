"""Noisy samples of the built-in curves, with the truth that they come from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from core.errors import InvalidParameter
from core.truth.catalogue import family
from core.truth.conditions import PLAIN, Conditions
from core.truth.curves import ParametricCurve
from core.truth.intersections import crossings
from core.truth.junctions import TOUCH, apart, diagonal, junctions
from core.truth.sampling import Box, draw

__all__ = ["PointSet", "TrueCurve", "family", "point_set"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MAX_POINTS = 5_000_000
MAX_SIGMA = 0.2
MAX_OUTLIERS = 0.9
_VERTICES = 2000  # of an exact polyline: the chords of a circle sag by 4e-7 of its diagonal


@dataclass(frozen=True, slots=True, eq=False)
class TrueCurve:
    """An exact curve as a dense polyline; a closed one does not repeat its first vertex.

    Attributes
    ----------
    vertices : (M, d) array
        Points of the exact curve, equidistant in arc length; corners are vertices.
    closed : bool
    length : float
        Exact arc length.
    exact : ParametricCurve
        The curve itself.
    """

    vertices: Floats
    closed: bool
    length: float
    exact: ParametricCurve


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """A noisy, unorganised sample and its truth.

    Attributes
    ----------
    name : str
    points : (N, d) array
    curves : tuple of TrueCurve
    sigma : float
        Standard deviation of the noise in each coordinate, in units of the points: the root of its mean
        square along the curves where it varies, the central width where its tails are heavy.
    curve_of : (N,) integer array
        The curve that each point was drawn from, -1 for an outlier.
    u : (N,) array
        Fraction of arc length where it was drawn; NaN for an outlier.
    crossings : (K, d) array
        Where the exact curves cross themselves and each other.
    smooth, non_crossing : bool
        Whether the curves are free of corners, and of crossings and junctions.
    junctions : (K, d) array
        Where open curves end on other curves; no crossing counts there.
    noise : (N,) array
        The noise at each sample, in the sense of ``sigma``; NaN for an outlier.
    conditions : Conditions
        What makes the sample harder than a plain one.
    """

    name: str
    points: Floats
    curves: tuple[TrueCurve, ...]
    sigma: float
    curve_of: Ints
    u: Floats
    crossings: Floats
    smooth: bool
    non_crossing: bool
    junctions: Floats
    noise: Floats
    conditions: Conditions = PLAIN


def point_set(
    name: str,
    n: int | None = None,
    sigma: float | None = None,
    outliers: float = 0.0,
    seed: int = 0,
    conditions: Conditions = PLAIN,
) -> PointSet:
    """Draw a noisy sample of a family of exact curves.

    Parameters
    ----------
    name : str
        Any name in :mod:`core.truth.catalogue`.
    n : int, optional
        Number of samples, 1 to 5 000 000; the family's own number by default.
    sigma : float, optional
        Standard deviation of the isotropic Gaussian noise, as a fraction (0 to 0.2) of the diagonal
        of the exact curves' bounding box.
    outliers : float
        Number of outliers, uniform in the enlarged bounding box unless the conditions say otherwise, as
        a fraction (0 to 0.9) of n. They come on top of the n samples, at random places of the order.
    seed : int
        The same arguments give the same points.
    conditions : Conditions
        Noise and density that vary, clustered outliers, heavy tails, rounding, copies, even spacing.

    Raises
    ------
    InvalidParameter
        For an unknown name or a value out of range, with its place in ``loc``.

    Examples
    --------
    >>> sample = point_set("circle", n=100, sigma=0.0)
    >>> sample.points.shape, len(sample.curves), sample.curves[0].closed
    ((100, 2), 1, True)
    """
    chosen = family(name)
    n = chosen.size if n is None else n
    fraction = chosen.sigma if sigma is None else sigma
    _check(n, fraction, outliers, seed)
    truth, crossing, junction = _truth(name, seed if chosen.varies else 0)
    box = _box(truth)
    noise = fraction * box.diagonal
    drawn = draw(chosen, [one.exact for one in truth], box, n, noise, outliers, conditions, seed)
    flags = chosen.smooth, chosen.non_crossing
    return PointSet(
        name,
        drawn.points,
        truth,
        noise,
        drawn.curve_of,
        drawn.u,
        crossing,
        *flags,
        junction,
        drawn.noise,
        conditions,
    )


def _check(n: int, sigma: float, outliers: float, seed: int) -> None:
    if not 1 <= n <= MAX_POINTS:
        raise InvalidParameter(f"The number of samples must be between 1 and {MAX_POINTS}.", ("n",))
    if not 0 <= sigma <= MAX_SIGMA:
        raise InvalidParameter(f"sigma is a fraction of the diagonal, between 0 and {MAX_SIGMA}.", ("sigma",))
    if not 0 <= outliers <= MAX_OUTLIERS:
        raise InvalidParameter(f"outliers is a fraction of n, between 0 and {MAX_OUTLIERS}.", ("outliers",))
    if seed < 0:
        raise InvalidParameter("The seed must not be negative.", ("seed",))


@lru_cache(maxsize=64)
def _truth(name: str, seed: int) -> tuple[tuple[TrueCurve, ...], Floats, Floats]:
    """Build the exact curves, their crossings and their junctions."""
    chosen = family(name)
    exact = chosen.build(seed)
    truth = tuple(TrueCurve(one.polyline(_VERTICES), one.closed, one.length, one) for one in exact)
    for one in truth:
        one.vertices.setflags(write=False)  # shared between point sets
    none = np.zeros((0, truth[0].vertices.shape[1]))
    ends = none if chosen.non_crossing else junctions([(one.vertices, one.closed) for one in truth])
    places = none if chosen.non_crossing else _exact_crossings(truth, ends)
    places.setflags(write=False)
    ends.setflags(write=False)
    return truth, places, ends


def _box(truth: tuple[TrueCurve, ...]) -> Box:
    everything = np.concatenate([one.vertices for one in truth])
    return Box(everything.min(axis=0), everything.max(axis=0))


def _exact_crossings(truth: tuple[TrueCurve, ...], ends: Floats) -> Floats:
    """Find crossings on the polylines and polish them on the exact curves by Newton's method.

    What touches at the ``ends`` does not cross there.
    """
    lines = [(one.vertices, one.closed) for one in truth]
    found = crossings(lines)
    proper = apart(found.locations, ends, TOUCH * diagonal(lines))
    places = []
    for (i, j), (p, q) in zip(found.curves[proper], found.positions[proper], strict=True):
        a, b = truth[i].exact, truth[j].exact
        u = a.parameter([_fraction(truth[i], p)])
        v = b.parameter([_fraction(truth[j], q)])
        for _ in range(4):
            gap = (a.evaluate(u) - b.evaluate(v))[0]
            jacobian = np.column_stack((a.derivative(u, 1)[0], -b.derivative(v, 1)[0]))
            du, dv = np.linalg.solve(jacobian, -gap)
            u, v = u + du, v + dv
        places.append(a.evaluate(u)[0])
    return np.array(places).reshape(-1, 2)


def _fraction(curve: TrueCurve, position: float) -> float:
    """Fraction of arc length at a position (edge number plus fraction) of an equidistant polyline."""
    return position / (len(curve.vertices) - (not curve.closed))
