"""Branches so near each other that one curve stands for both: only the residuals show them.

Noise about one branch is Gaussian, or has heavier tails; about two branches side by side it has a flat
top or two humps: the mean deviation is larger, in standard deviations, and the excess kurtosis negative.
Outliers, heavy tails and noise that varies along the curve do the opposite. The mean deviation is tested
(R. C. Geary, Biometrika 27, 1935: its distribution is known better than that of the kurtosis, whose lower
tail is far too long for tests as strict as these), on the whole curve and on ever shorter stretches of
it, each with its share of one chance of error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, ndtr

from core.diagnosis.across import Across

__all__ = ["Hidden", "hidden_branches", "separation"]

Floats = NDArray[np.float64]

CHANCE = 0.003  # that a sound set has any stretch that is told to hide branches
WHOLE = 0.6  # of it for the curve as a whole
LEAST_SAMPLES = 60  # in a stretch
LEVELS = 6  # of halving
MATERIAL = -0.25  # excess kurtosis: branches 1.5 sigma apart; a grid of half a sigma makes -0.13
SKEWED = 1.0  # a stretch that is more skewed is not two branches side by side
TAILS = 6.5  # median distances, 4.4 standard deviations, beyond which an offset is an outlier
RIM = 0.85  # of the reach of the curve: where more of the samples lie beyond it
CUT_OFF = 0.004  # than this, the reach has cut noise off
MOST = 4  # stretches told of one curve
SKEWNESS = -1.75  # of the mean deviation, times the root of the number of samples


@dataclass(frozen=True, slots=True, eq=False)
class Hidden:
    """A stretch of curve that hides two branches.

    Attributes
    ----------
    low, high : float
        Stations between which it lies.
    gap : float
        Distance of the branches, in units of the curve.
    sigma : float
        Noise about each of them.
    chance : float
        How rarely one branch looks so.
    """

    low: float
    high: float
    gap: float
    sigma: float
    chance: float


def hidden_branches(across: Across, share: float = 1.0) -> list[Hidden]:
    """Find stretches of a curve that stand for two branches, the clearest first.

    Parameters
    ----------
    across : Across
    share : float
        Of all samples, by which the chance of error is divided among curves.
    """
    offset, station = across.offset, across.station
    if len(station) < LEAST_SAMPLES or not across.sigma > 0.0:
        return []
    low, high, level = _stretches(len(station))
    shapes = [_shape(offset[i:j], across.reach) for i, j in zip(low, high, strict=True)]
    variance, kurtosis, chance = np.array(shapes).T
    found = np.flatnonzero(chance * offset.shape[1] < CHANCE * share * level)
    out: list[Hidden] = []
    for k in found[np.argsort(chance[found] / level[found], kind="stable")]:
        first, last = float(station[low[k]]), float(station[high[k] - 1])
        if len(out) < MOST and all(last < one.low or first > one.high for one in out):
            gap, sigma = separation(float(variance[k]), float(kurtosis[k]))
            out.append(Hidden(first, last, gap, sigma, float(chance[k])))
    return out


def separation(variance: float, kurtosis: float) -> tuple[float, float]:
    """Distance and noise of two equal branches whose mixture has these moments.

    With a = gap^2 / 4 sigma^2 the variance is sigma^2 (1 + a), and the excess kurtosis -2 (a / (1 + a))^2.

    Parameters
    ----------
    variance : float
        Of the offsets.
    kurtosis : float
        Their excess kurtosis, negative.

    Examples
    --------
    >>> gap, sigma = separation(2.0, -0.5)
    >>> round(gap, 6), round(sigma, 6)
    (2.0, 1.0)
    """
    share = min(float(np.sqrt(max(-kurtosis, 0.0) / 2.0)), 0.9)
    return 2.0 * float(np.sqrt(share * variance)), float(np.sqrt((1.0 - share) * variance))


def _stretches(count: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """First and last ranks of the stretches, and each one's share of the chance of error."""
    levels = min(LEVELS, int(np.log2(count / LEAST_SAMPLES)))
    low, high, share = [np.array([0])], [np.array([count])], [np.array([WHOLE if levels else 1.0])]
    for level in range(1, levels + 1):
        pieces = 2 ** (level + 1) - 1  # half of each is in the next one
        edges = np.linspace(0, count, pieces + 2).astype(np.int64)
        low.append(edges[:-2])
        high.append(edges[2:])
        share.append(np.full(pieces, (1.0 - WHOLE) / levels / pieces))
    return np.concatenate(low), np.concatenate(high), np.concatenate(share)


def _shape(offset: Floats, reach: float) -> tuple[float, float, float]:
    """Variance and excess kurtosis in the direction of the least chance, and that chance; 1 for no verdict.

    Where noise is cut off by the reach of the curve it has a flat top, and outliers may hide anything.
    """
    middle = np.median(offset, axis=0)
    away = np.abs(offset - middle)
    kept = away <= TAILS * np.median(away, axis=0)
    cut = np.mean(away > RIM * reach, axis=0) > CUT_OFF
    best = 1.0, 0.0, 1.0
    for k in np.flatnonzero(~cut):
        own = offset[kept[:, k], k]
        if len(own) < 0.5 * LEAST_SAMPLES:
            continue
        own = own - own.mean()
        square = own * own
        c2, c3, c4 = (float(x) for x in (np.mean(square), np.mean(square * own), np.mean(square * square)))
        if not c2 > 0.0 or abs(c3) > SKEWED * c2**1.5 or c4 / c2**2 - 3.0 > MATERIAL:
            continue
        flatness = float(np.mean(np.abs(own))) / np.sqrt(c2)
        chance = float(ndtr(-_normal_score(flatness, len(own))))
        best = min(best, (c2, c4 / c2**2 - 3.0, chance), key=lambda each: each[2])
    return best


def _normal_score(flatness: float, n: int) -> float:
    """Standard normal score of the mean deviation of n Gaussian numbers, in their own standard deviations.

    The mean and the variance are exact; the third moment is taken out by Cornish and Fisher's first term.
    """
    spread = np.sqrt(2.0 / n) * np.exp(gammaln(0.5 * n) - gammaln(0.5 * (n - 1)))  # mean standard deviation
    mean = np.sqrt(2.0 / np.pi * (n - 1) / n) / spread
    shared = 1.0 / (n - 1)  # correlation of two deviations from the same mean, but for its sign
    pair = 2.0 / np.pi * (np.sqrt(1.0 - shared**2) + shared * np.arcsin(shared))
    variance = (1.0 + (n - 1) * pair) / n - mean**2
    score = (flatness - mean) / np.sqrt(variance)
    return float(score - SKEWNESS / np.sqrt(n) / 6.0 * (score**2 - 1.0))
