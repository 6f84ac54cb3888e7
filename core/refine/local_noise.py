"""Noise that varies along a curve: its standard deviation as a smooth function of arc length.

Whether it varies is asked of the ranks of the distances first (Kruskal and Wallis 1952): outliers
and heavy tails do not make a constant noise look variable. Where it does, sigma follows from the
likelihood of the distances in a window about each station, truncated where samples were cut, with
a uniform background of outliers beside the noise (local likelihood, Tibshirani and Hastie 1987).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from core.refine.noise import noise_of

__all__ = ["LocalNoise", "sigma_along"]

Floats = NDArray[np.float64]

PLACES, SLICES = 256, 64  # bins along the curve, and of distances up to the cut
NODES = 64  # stations at which sigma is estimated
BLOCKS = 12  # at most, in which ranks are compared, of
LEAST_BLOCK = 40.0  # samples each
CHANCE = 1e-4  # how rarely a constant noise may be told to vary
MATERIAL = 1.35  # largest sigma over least: a lesser variation makes no difference
WINDOW = 0.08  # half-width of a window, of the length, at least; a blob of outliers must not fill one
LEAST_WINDOW = 120.0  # samples that a window holds
ROUNDS = 40  # of expectation and maximisation
LEAST, MOST = 0.1, 2.5  # factors by which sigma may change at once
PRIOR = 20.0  # samples for which the curve's own share of outliers counts in a window
MOST_BACKGROUND = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class LocalNoise:
    """Noise standard deviation along one curve.

    Attributes
    ----------
    stations : (K,) array
        Arc lengths, ascending from 0 to the curve's length; a closed curve's last repeats its first.
    sigma : (K,) array
        There, per normal direction; linear in between.
    """

    stations: Floats
    sigma: Floats

    @classmethod
    def constant(cls, sigma: float, length: float) -> LocalNoise:
        """The same noise everywhere."""
        return cls(np.array([0.0, length]), np.array([sigma, sigma]))

    @property
    def varies(self) -> bool:
        """Whether there is any difference along the curve."""
        return bool(np.ptp(self.sigma) > 0.0)

    @property
    def length(self) -> float:
        """Of the curve."""
        return float(self.stations[-1])

    @property
    def largest(self) -> float:
        """The largest standard deviation."""
        return float(self.sigma.max())

    @property
    def mean(self) -> float:
        """Root of the variance's mean over arc length."""
        if not self.varies:
            return float(self.sigma[0])
        a, b = self.sigma[:-1], self.sigma[1:]
        return float(np.sqrt(np.sum(np.diff(self.stations) * (a * a + a * b + b * b)) / (3.0 * self.length)))

    def at(self, station: Floats) -> Floats:
        """Standard deviations at stations of any shape; beyond the ends those of the ends."""
        if not self.varies:
            return np.full(np.shape(station), self.sigma[0])
        return np.interp(station, self.stations, self.sigma)

    def scaled(self, factor: float) -> LocalNoise:
        """The same course of a noise that is larger by a factor."""
        return replace(self, sigma=self.sigma * factor)

    def between(self, low: float, high: float) -> LocalNoise:
        """The noise on a part of the curve, or on one that is longer.

        Parameters
        ----------
        low, high : float
            Stations where it begins and ends; beyond this curve's ends their noise goes on.
        """
        if not self.varies:
            return LocalNoise.constant(float(self.sigma[0]), high - low)
        at = np.linspace(0.0, high - low, len(self.stations))
        return LocalNoise(at, self.at(at + low))

    def stretched(self, length: float) -> LocalNoise:
        """The same course of the noise on a curve of another length."""
        return replace(self, stations=self.stations * (length / self.length))


def sigma_along(
    station: Floats,
    distance: Floats,
    length: float,
    closed: bool,
    before: LocalNoise | float,
    cut: float,
    normals: int = 1,
    weight: Floats | None = None,
    spent: float = 0.0,
) -> LocalNoise:
    """Estimate the noise along a curve from its samples' distances.

    Parameters
    ----------
    station : (N,) array
        Arc lengths of the samples' feet, in [0, length].
    distance : (N,) array
        Distances to their feet, none farther than ``cut`` times the noise before.
    length : float
        Of the curve.
    closed : bool
    before : LocalNoise or float
        Estimate by which the samples were cut; a number is the same everywhere.
    cut : float
        In units of it.
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    weight : (N,) array, optional
        Shares of the samples that are this curve's.
    spent : float
        Degrees of freedom of the fit.

    Returns
    -------
    LocalNoise
        Constant, the answer of :func:`core.refine.noise.noise_of`, unless the samples say clearly
        that it is not.

    Notes
    -----
    O(N), with no more than a fixed number of operations besides. After a large change cut the samples
    anew and ask again: of what was cut away nothing can be learnt.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> s = rng.uniform(0.0, 10.0, 4000)
    >>> noise = sigma_along(s, np.abs(rng.normal(0.0, 0.1 + 0.03 * s)), 10.0, False, 0.5, 4.0)
    >>> noise.varies, noise.at(np.array([1.0, 9.0])).round(1).tolist()
    (True, [0.1, 0.4])
    """
    before = before if isinstance(before, LocalNoise) else LocalNoise.constant(before, length)
    if not (len(station) and length > 0.0 and before.sigma.min() > 0.0):
        return before
    relative = distance / before.at(station)
    table = _table(station, relative, length, cut, weight)
    alike = _as_one(station, distance, length, before, cut, normals, weight, spent)
    if not _varies(table if not before.varies else _common(station, distance, length, before, cut, weight)):
        return alike
    nodes = np.linspace(0.0, length, NODES + 1)
    factor = _likeliest(_windows(table, closed), cut, normals)
    factor = np.append(factor, factor[0]) if closed else factor
    found = LocalNoise(nodes, factor * before.at(nodes))
    if found.sigma.max() < MATERIAL * found.sigma.min():
        return alike
    # Windows say how the noise varies, all samples together how large it is.
    relative = distance / found.at(station)
    inside = relative <= cut
    share = None if weight is None else weight[inside]
    return found.scaled(min(max(noise_of(relative[inside], spent, 1.0, cut, normals, share), LEAST), MOST))


def _as_one(
    station: Floats,
    distance: Floats,
    length: float,
    before: LocalNoise,
    cut: float,
    normals: int,
    weight: Floats | None,
    spent: float,
) -> LocalNoise:
    """The same noise everywhere."""
    if not before.varies:
        return LocalNoise.constant(
            noise_of(distance, spent, float(before.sigma[0]), cut, normals, weight), length
        )
    # Cut by what varied: only within the least cut is nothing missing.
    relative = distance / before.at(station)
    level = noise_of(relative, spent, 1.0, cut, normals, weight)
    return LocalNoise.constant(level * before.mean, length)


def _table(station: Floats, relative: Floats, length: float, cut: float, weight: Floats | None) -> Floats:
    """(PLACES, SLICES) number of samples by station and distance."""
    place = np.clip((station * (PLACES / length)).astype(np.int64), 0, PLACES - 1)
    slot = (relative * (SLICES / cut)).astype(np.int64)
    inside = slot < SLICES
    cell = (place * SLICES + slot)[inside]
    share = None if weight is None else weight[inside]
    counts = np.bincount(cell, share, PLACES * SLICES)
    return counts.reshape(PLACES, SLICES).astype(np.float64)


def _common(
    station: Floats, distance: Floats, length: float, before: LocalNoise, cut: float, weight: Floats | None
) -> Floats:
    """The table of distances in one unit, up to the nearest cut."""
    return _table(station, distance / float(before.sigma.min()), length, cut, weight)


def _varies(table: Floats) -> bool:
    """Whether the ranks of the distances differ between blocks of samples."""
    total = float(table.sum())
    blocks = int(min(total / LEAST_BLOCK, BLOCKS))
    if blocks < 2:
        return False
    pooled = table.sum(axis=0)
    rank = (np.cumsum(pooled) - 0.5 * pooled) / total
    spread = float(np.sum(pooled * rank**2)) / total - (float(np.sum(pooled * rank)) / total) ** 2
    held = table.sum(axis=1)
    block = np.minimum(((np.cumsum(held) - 0.5 * held) * (blocks / total)).astype(np.int64), blocks - 1)
    count = np.bincount(block, held, blocks)
    mean = np.bincount(block, table @ rank, blocks) / np.maximum(count, 1e-300)
    overall = float(np.sum(pooled * rank)) / total
    statistic = float(np.sum(count * (mean - overall) ** 2)) / max(spread, 1e-300)
    return bool(gammaincc(0.5 * (blocks - 1), 0.5 * statistic) < CHANCE)


def _windows(table: Floats, closed: bool) -> Floats:
    """(K, SLICES) number of samples by distance in a tapered window about each node."""
    nodes = np.arange(NODES + (0 if closed else 1)) * (PLACES / NODES)
    away = np.abs(np.arange(PLACES) + 0.5 - nodes[:, None])
    away = np.minimum(away, PLACES - away) if closed else away
    held = table.sum(axis=1)
    order = np.argsort(away, axis=1, kind="stable")
    enough = np.argmax(np.cumsum(held[order], axis=1) >= min(LEAST_WINDOW, held.sum()), axis=1)
    width = np.take_along_axis(away, order, axis=1)[np.arange(len(nodes)), enough]
    width = np.maximum(width, WINDOW * PLACES) + 1.0
    return np.asarray(np.maximum(1.0 - (away / width[:, None]) ** 2, 0.0) @ table)


def _likeliest(counts: Floats, cut: float, normals: int) -> Floats:
    """(K,) standard deviations in each window, by expectation and maximisation."""
    x = (np.arange(SLICES) + 0.5) * (cut / SLICES)
    shell = x ** (normals - 1)
    flat = shell / shell.sum()
    total = np.maximum(counts.sum(axis=1, keepdims=True), 1e-300)
    typical = np.sqrt(counts @ x**2 / total[:, 0] / normals)
    scale, stray = np.clip(typical, LEAST, 1.0), np.full((len(counts), 1), 0.02)
    for _ in range(ROUNDS):
        core = shell * np.exp(-0.5 * (x / scale[:, None]) ** 2)
        core /= core.sum(axis=1, keepdims=True)
        own = (1.0 - stray) * core
        own = counts * own / (own + stray * flat)
        held = np.maximum(own.sum(axis=1), 1e-300)
        # The truncated noise has this variance already; what differs from it moves the scale.
        scale = np.clip(scale * np.sqrt((own @ x**2 / held) / (core @ x**2)), LEAST, MOST)
        outside = total[:, 0] - own.sum(axis=1)
        pooled = float(outside.sum() / total.sum())
        stray = np.clip((outside + PRIOR * pooled) / (total[:, 0] + PRIOR), 1e-6, MOST_BACKGROUND)[:, None]
    return np.asarray(scale)
