"""Random draws from exact curves: positions, noise, outliers, copies and rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0, ndtri, stdtrit

from core.errors import InvalidParameter
from core.truth.conditions import Conditions
from core.truth.curves import ParametricCurve
from core.truth.families import Family, Scans

__all__ = ["Box", "Draw", "draw", "t_scale"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Curves = Sequence[ParametricCurve]
Profile = Callable[[Floats], Floats]

_MARGIN = 0.1  # outliers come from the bounding box enlarged by this much of the diagonal on each side
_GRID = 4096  # intervals on which a density is integrated
_STREAM = 5  # of the random numbers that conditions draw, beside those of the plain sample

# clustered outliers; lengths in units of the noise
_BLOB = 40  # points in a blob, on average
_WIDTH = (1.5, 4.0)  # standard deviation of a blob
_NEAR = (8.0, 16.0)  # distance of a blob near a curve from the place of the curve that it is beside
_LEAST = 0.0025  # of the diagonal: the unit when there is next to no noise


@dataclass(frozen=True, slots=True, eq=False)
class Draw:
    """Drawn points; see :class:`core.truth.point_sets.PointSet` for the attributes."""

    points: Floats
    curve_of: Ints
    u: Floats
    noise: Floats

    def taken(self, order: Ints) -> Draw:
        """Return the points of the given numbers, which may repeat."""
        return Draw(self.points[order], self.curve_of[order], self.u[order], self.noise[order])

    def joined(self, stray: Floats) -> Draw:
        """Return these points and outliers after them."""
        none = np.full(len(stray), np.nan)
        return Draw(
            np.vstack((self.points, stray)),
            np.concatenate((self.curve_of, np.full(len(stray), -1))),
            np.concatenate((self.u, none)),
            np.concatenate((self.noise, none)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """The bounding box of the exact curves."""

    low: Floats
    high: Floats

    @property
    def diagonal(self) -> float:
        """Length of the diagonal."""
        return float(np.linalg.norm(self.high - self.low))

    def uniform(self, count: int, rng: np.random.Generator) -> Floats:
        """Return places from the enlarged box."""
        margin = _MARGIN * self.diagonal
        return rng.uniform(self.low - margin, self.high + margin, size=(count, len(self.low)))


def draw(
    chosen: Family,
    curves: Curves,
    box: Box,
    n: int,
    sigma: float,
    outliers: float,
    conditions: Conditions,
    seed: int,
) -> Draw:
    """Draw ``n`` noisy samples of exact curves, with outliers and copies on top.

    Parameters
    ----------
    chosen : Family
        Says how the samples are spread over the curves.
    curves : sequence of ParametricCurve
    box : Box
        Of the curves.
    n : int
    sigma : float
        In units of the curves.
    outliers : float
        As a fraction of n.
    conditions : Conditions
    seed : int

    Raises
    ------
    InvalidParameter
        When the family comes from scans, whose positions are their own, and the conditions move them.
    """
    rng, more = np.random.default_rng(seed), np.random.default_rng([_STREAM, seed])
    if chosen.scans is not None and conditions.moves_positions:
        raise InvalidParameter("Samples of scans lie where the scans see them.", ("conditions",))
    drawn = _samples(chosen, curves, n, sigma, conditions, rng, more)
    count = round(outliers * n)
    if count:
        if conditions.outliers == "uniform":
            stray = box.uniform(count, rng)
        else:
            stray = _blobs(curves, box, count, sigma, more)
        drawn = drawn.joined(stray).taken(rng.permutation(n + count))
    if conditions.duplicates:
        drawn = drawn.taken(_with_copies(len(drawn.u), conditions.duplicates, more))
    step = conditions.quantum * sigma
    if step:
        drawn = Draw(np.round(drawn.points / step) * step, drawn.curve_of, drawn.u, drawn.noise)
    return drawn


def t_scale(degrees_of_freedom: float) -> float:
    """Return the scale of a Student t distribution whose quartiles are those of the standard normal one.

    Examples
    --------
    >>> round(t_scale(3.0), 4), t_scale(float("inf"))
    (0.8818, 1.0)
    """
    if np.isinf(degrees_of_freedom):
        return 1.0
    return float(ndtri(0.75) / stdtrit(degrees_of_freedom, 0.75))


def _samples(
    chosen: Family,
    curves: Curves,
    n: int,
    sigma: float,
    conditions: Conditions,
    rng: np.random.Generator,
    more: np.random.Generator,
) -> Draw:
    """Draw curve numbers, fractions of arc length, and noisy points."""
    profiles = [_Profiles.of(one, conditions, more) for one in curves]
    curve_of, u = _places(chosen, curves, n, conditions, rng, more)
    shift: Floats | float = 0.0
    dimension = curves[0].evaluate([0.0]).shape[1]
    if chosen.scans is not None:
        u, shift = _scanned(chosen.scans, n, sigma, dimension, rng)
    points, noise = np.empty((n, dimension)), np.full(n, sigma)
    for k, one in enumerate(curves):
        here = curve_of == k
        u[here] = profiles[k].spread(u[here], chosen.density)
        points[here] = one.at(u[here])
        noise[here] *= profiles[k].noise(u[here])
    deviates = rng.standard_normal(points.shape)
    if not np.isinf(conditions.degrees_of_freedom):
        nu = conditions.degrees_of_freedom
        deviates *= t_scale(nu) / np.sqrt(more.chisquare(nu, size=(n, 1)) / nu)
    return Draw(points + shift + noise[:, None] * deviates, curve_of, u, noise)


def _places(
    chosen: Family,
    curves: Curves,
    n: int,
    conditions: Conditions,
    rng: np.random.Generator,
    more: np.random.Generator,
) -> tuple[Ints, Floats]:
    """Curve number of each sample, and how large a share of its curve's samples comes before it."""
    weights = [1.0 if chosen.equal_numbers else one.length for one in curves]
    ends = np.cumsum(weights)
    if conditions.spacing == "random":
        curve_of = np.searchsorted(ends, rng.uniform(0, ends[-1], n), side="right")
        u = np.zeros(n) if chosen.scans is not None else rng.uniform(size=n)
    else:
        place = (more.permutation(n) + more.uniform(size=n)) / n * ends[-1]
        curve_of = np.minimum(np.searchsorted(ends, place, side="right"), len(ends) - 1)
        u = 1.0 - (ends[curve_of] - place) / np.asarray(weights)[curve_of]
    return curve_of.astype(np.int64), u


@dataclass(frozen=True, slots=True, eq=False)
class _Profiles:
    """How noise and density run along one curve; both relative, over the fraction of arc length."""

    noise: Profile
    density: Profile | None

    @classmethod
    def of(cls, curve: ParametricCurve, conditions: Conditions, more: np.random.Generator) -> _Profiles:
        first, second = more.uniform(size=2)
        wide, dense = conditions.noise_ratio, conditions.density_ratio
        level = 1.0 / np.sqrt(i0(np.log(wide)))  # the mean of exp(a cos x) over a turn is I0(a)
        run = _run(wide, curve.closed, first)
        density = None
        if dense != 1.0:
            blocks = conditions.blocks
            density = _in_blocks(dense, blocks) if blocks else _run(dense, curve.closed, second)
        return cls(lambda u: level * run(u), density)

    def spread(self, share: Floats, own: Profile | None) -> Floats:
        """Return fractions of arc length from shares of the samples, also by the family's own density."""
        factors = [one for one in (own, self.density) if one is not None]
        if not factors:
            return share
        grid = np.linspace(0, 1, _GRID + 1)
        middle = (grid[:-1] + grid[1:]) / 2
        mass = np.concatenate(([0.0], np.cumsum(np.prod([one(middle) for one in factors], axis=0))))
        return np.interp(share, mass / mass[-1], grid)


def _run(ratio: float, closed: bool, phase: float) -> Profile:
    """Return a profile from ratio^-1/2 to ratio^1/2 whose logarithm is a cosine."""
    if closed:
        return lambda u: np.asarray(ratio ** (0.5 * np.cos(2 * np.pi * (u - phase))))
    sign = 1.0 if phase < 0.5 else -1.0  # which end has more
    return lambda u: np.asarray(ratio ** (0.5 * sign * np.cos(np.pi * u)))


def _in_blocks(ratio: float, count: int) -> Profile:
    return lambda u: np.where(np.floor(u * count) % 2 == 0, ratio, 1.0)


def _scanned(
    scans: Scans, n: int, noise: float, dimension: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Fractions of arc length as several scans see them, and the registration error of each point."""
    first, last = np.array(scans.arcs).T
    scan = rng.choice(len(first), size=n, p=(last - first) / (last - first).sum())
    u = (first[scan] + (last - first)[scan] * rng.uniform(size=n)) % 1.0
    misfit = scans.misfit * noise * rng.standard_normal((len(first), dimension))
    return u, misfit[scan]


def _blobs(curves: Curves, box: Box, count: int, sigma: float, more: np.random.Generator) -> Floats:
    """Draw outliers in round blobs: every other one beside a curve, the rest anywhere in the box."""
    unit = max(sigma, _LEAST * box.diagonal)
    blobs = max(1, round(count / _BLOB))
    centre = box.uniform(blobs, more)
    beside = np.flatnonzero(np.arange(blobs) % 2 == 0)
    lengths = np.array([one.length for one in curves])
    owner = more.choice(len(curves), size=len(beside), p=lengths / lengths.sum())
    away = more.standard_normal((len(beside), centre.shape[1]))
    away *= unit * more.uniform(*_NEAR, size=(len(beside), 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    for one, k, offset in zip(beside, owner, away, strict=True):
        centre[one] = curves[k].at([more.uniform()])[0] + offset
    blob = more.integers(blobs, size=count)
    width = unit * more.uniform(*_WIDTH, size=blobs)
    return np.asarray(centre[blob] + width[blob, None] * more.standard_normal((count, centre.shape[1])))


def _with_copies(count: int, share: float, more: np.random.Generator) -> Ints:
    """Return all numbers below ``count`` and a share of them once more, shuffled."""
    every = np.arange(count)
    again = more.choice(every, size=round(share * count), replace=False)
    return np.asarray(more.permutation(np.concatenate((every, again))), np.int64)
