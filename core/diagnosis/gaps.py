"""Stretches of a curve without samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["Gap", "expected_gap", "longest_gap", "widest_gap"]

Floats = NDArray[np.float64]

AROUND = 30  # spacings on either side of a gap that say how dense samples are there
LEAST_AROUND = 8
MANY = 10_000  # gaps: of more only those are looked at that may be the widest
CHANCE = 0.01  # that the largest gap of independent samples is longer


@dataclass(frozen=True, slots=True, eq=False)
class Gap:
    """A stretch of curve without samples.

    Attributes
    ----------
    middle, length : float
        Arc length of its middle, and how long it is.
    spacings : float
        Its length in mean distances between the samples about it.
    expected : float
        What the largest gap of independent samples exceeds once in a hundred sets, in the same unit.
    """

    middle: float
    length: float
    spacings: float
    expected: float


def longest_gap(line: Polyline, station: NDArray[np.float64]) -> tuple[float, float]:
    """Find the longest stretch of a curve without a sample.

    Parameters
    ----------
    line : Polyline
    station : (n,) array
        Arc lengths of the samples' feet on it.

    Returns
    -------
    (middle, length)
        Arc length of the stretch's middle, and how long it is; the whole curve without samples.
    """
    if not len(station):
        return 0.5 * line.length, line.length
    ordered = np.sort(station)
    ends = (ordered[-1] - line.length, ordered[0] + line.length) if line.closed else (0.0, line.length)
    ways = np.concatenate([ends[:1], ordered, ends[1:]])
    gaps = np.diff(ways)
    k = int(np.argmax(gaps))
    return float(ways[k] + 0.5 * gaps[k]) % max(line.length, 1e-300), float(gaps[k])


def expected_gap(total: int, around: float) -> float:
    """Gap that the largest of independent samples exceeds once in a hundred sets, in mean spacings.

    With the density known it is ln N + c, c = -ln(-ln 0.99) = 4.6: of N spacings, each exponential,
    the largest has a Gumbel distribution. A density that comes from ``around`` spacings makes ratios of the
    gap to their mean follow Pareto's law (1 + x / around)^-around instead.

    Parameters
    ----------
    total : int
        Number of samples.
    around : float
        Number of spacings that the density comes from.

    Examples
    --------
    >>> round(expected_gap(1000, 1e9), 1), round(expected_gap(1000, 60), 1)
    (11.5, 12.7)
    """
    nats = np.log(max(total, 1)) - np.log(-np.log1p(-CHANCE))
    return float(around * np.expm1(nats / around))


def widest_gap(line: Polyline, ordered: Floats, total: int) -> Gap | None:
    """Find the gap between samples that is longest in distances between the samples about it.

    A density that changes along the curve makes no gap: a gap is measured by the sparser of its sides.

    Parameters
    ----------
    line : Polyline
    ordered : (n,) array
        Ascending arc lengths of the samples' feet on it.
    total : int
        Number of samples of all curves, among which it is the largest.

    Returns
    -------
    Gap or None
        None for a curve with too few samples to tell.
    """
    n = len(ordered)
    if n < 2 * LEAST_AROUND:
        return None
    m = min(AROUND, n // 3)
    ways = ordered
    if line.closed:  # one way round and a little more
        ways = np.concatenate([ordered[-m - 1 :] - line.length, ordered, ordered[: m + 1] + line.length])
    gaps = np.diff(ways)
    rank = np.arange(m, len(gaps) - m) if line.closed else np.arange(len(gaps))
    if n > MANY:
        rank = rank[_may_be_widest(gaps)[rank]]
    left, right = np.maximum(rank - m, 0), np.minimum(rank + 1 + m, len(ways) - 1)
    before, after = rank - left, right - rank - 1
    least = min(LEAST_AROUND, m)
    mean_before = (ways[rank] - ways[left]) / np.maximum(before, 1)
    mean_after = (ways[right] - ways[rank + 1]) / np.maximum(after, 1)
    mean = np.maximum(np.where(before >= least, mean_before, 0.0), np.where(after >= least, mean_after, 0.0))
    # Repeated samples have no distances: there the curve's own density holds.
    ratio = gaps[rank] / np.maximum(mean, 0.1 * line.length / n)
    k = int(np.argmax(ratio))
    where = rank[k]
    middle = float(0.5 * (ways[where] + ways[where + 1])) % max(line.length, 1e-300)
    around = float(np.where(before[k] >= least, before[k], 0) + np.where(after[k] >= least, after[k], 0))
    return Gap(middle, float(gaps[where]), float(ratio[k]), expected_gap(total, max(around, 1.0)))


def _may_be_widest(gaps: Floats) -> NDArray[np.bool_]:
    """Which gaps are, in means of the blocks next to them, at least a third as wide as any."""
    blocks = -(-len(gaps) // AROUND)
    means = np.pad(gaps, (0, blocks * AROUND - len(gaps)), mode="edge").reshape(blocks, AROUND).mean(axis=1)
    sides = np.maximum(np.roll(means, 1), np.roll(means, -1))  # a wide gap makes its own block's mean large
    ratio = gaps / np.repeat(np.maximum(sides, 0.1 * means.mean()), AROUND)[: len(gaps)]
    return np.asarray(ratio >= ratio.max() / 3.0)
