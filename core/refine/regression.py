"""Local polynomial regression of binned samples along arc length.

Order four inside, order two near open ends, where order four would explode; the
bandwidth minimises Mallows' C_p.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = [
    "AT_ENDS",
    "INSIDE",
    "Bandwidths",
    "Bins",
    "Fit",
    "bin_samples",
    "blend_of",
    "local_fit",
    "merged",
    "offset_of",
    "one_order",
    "polynomial_at",
    "reach_of",
    "select_bandwidths",
    "solve",
]


INSIDE, AT_ENDS = 4, 2  # orders
BINS_A_BANDWIDTH = 16.0  # wider bins would add their own share to the curvature bias
BINS_TO_JUDGE = 8.0
JUDGED_BINS = 200
PENALTY = 3.0  # Mallows has 2; the noise of C_p itself then picks too narrow a band too often


@dataclass(frozen=True, slots=True, eq=False)
class Bins:
    """Samples summed over equal intervals of arc length.

    Attributes
    ----------
    station : (B,) array
        Mean arc length of the samples of each bin (its middle where it is empty).
    count : (B,) array
    mean : (B, 3) array
        Mean position.
    length : float
        Length that the bins cover.
    closed : bool
    """

    station: NDArray[np.float64]
    count: NDArray[np.float64]
    mean: NDArray[np.float64]
    length: float
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A local polynomial at given stations.

    Attributes
    ----------
    value, second : (K, 3) array
        Position and second derivative.
    leverage : (K,) array
        Weight of one sample at the station in its own fit: what the fit spends of freedom there.
    """

    value: NDArray[np.float64]
    second: NDArray[np.float64]
    leverage: NDArray[np.float64]


def bin_samples(
    points: NDArray[np.float64],
    station: NDArray[np.float64],
    length: float,
    count: int,
    closed: bool,
    weight: NDArray[np.float64] | None = None,
) -> Bins:
    """Share samples among ``count`` equal bins of arc length.

    A sample counts for the two bins whose middles enclose it, in proportion: the sums
    are continuous in the samples' places, and rounding cannot move a sample's whole weight.

    Parameters
    ----------
    points : (N, 3) array
    station : (N,) array
        Arc length of each sample's foot, in [0, length].
    weight : (N,) array, optional
        How much each sample counts; one by default.
    """
    n, place, mean = _share_out(
        points, station, np.empty(0) if weight is None else weight, length, count, closed
    )
    middle = (np.arange(count) + 0.5) * (length / count)
    full = np.where(n > 0, n, 1.0)
    return Bins(np.where(n > 0, middle + place / full, middle), n, mean / full[:, None], length, closed)


@njit(cache=True)
def _share_out(points, station, weight, length, count, closed):  # type: ignore[no-untyped-def]
    """Weights, first moments about the bins' middles, and weighted sums of positions."""
    n, place, total = np.zeros(count), np.zeros(count), np.zeros((count, 3))
    width = length / count
    weighted = weight.shape[0] > 0
    for i in range(station.shape[0]):
        u = station[i] / width - 0.5
        b = int(np.floor(u))
        for side in range(2):
            share = u - b if side == 1 else 1.0 - (u - b)
            share *= weight[i] if weighted else 1.0
            c = b + side
            c = c % count if closed else min(max(c, 0), count - 1)
            offset = (u - b - side) * width if closed else (u - c) * width
            n[c] += share
            place[c] += share * offset
            for k in range(3):
                total[c, k] += share * points[i, k]
    return n, place, total


@dataclass(frozen=True, slots=True)
class Bandwidths:
    """Half-widths of the windows: of order four inside, of order two at open ends."""

    inside: float
    ends: float


def local_fit(bins: Bins, at: NDArray[np.float64], bandwidths: Bandwidths) -> Fit:
    """Fit local polynomials at each station of ``at`` (K,): order four inside, two at open ends."""
    inside = one_order(bins, at, bandwidths.inside, INSIDE)
    if bins.closed:
        return inside
    ends = one_order(bins, at, bandwidths.ends, AT_ENDS)
    share = blend_of(bins, at, bandwidths)
    blend = share[:, None]
    return Fit(
        blend * inside.value + (1.0 - blend) * ends.value,
        blend * inside.second + (1.0 - blend) * ends.second,
        share * inside.leverage + (1.0 - share) * ends.leverage,
    )


def blend_of(bins: Bins, at: NDArray[np.float64], bandwidths: Bandwidths) -> NDArray[np.float64]:
    """How far the fit at each station of ``at`` (K,) is of the order inside: one, but near open ends."""
    if bins.closed:
        return np.ones(len(at))
    return np.clip(2.0 * np.minimum(at, bins.length - at) / bandwidths.inside - 1.0, 0.0, 1.0)


def one_order(
    bins: Bins, at: NDArray[np.float64], bandwidth: float, order: int, detail: float = BINS_A_BANDWIDTH
) -> Fit:
    """Fit local polynomials of one order at each station of ``at`` (K,)."""
    if bins.closed:  # beyond half way round, rounding would tell on which side a far bin counts
        bandwidth = min(bandwidth, 0.5 * bins.length)
    coarse = merged(bins, bandwidth, detail)
    return Fit(
        *_fit_all(
            coarse.station, coarse.count, coarse.mean, coarse.length, coarse.closed, at, bandwidth, order
        )
    )


def merged(bins: Bins, bandwidth: float, detail: float) -> Bins:
    """Bins merged as far as the bandwidth allows: every window then costs the same."""
    size = len(bins.count)
    # Windows wider than the curve still need bins to tell its shape.
    factor = int(min(bandwidth / bins.length, 0.5) * size / detail)
    while factor > 1 and size % factor:
        factor -= 1
    if factor <= 1:
        return bins
    count = bins.count.reshape(-1, factor)
    n = count.sum(axis=1)
    weight = np.where(n[:, None] > 0, count, 1.0) / np.where(n > 0, n, factor)[:, None]
    station = np.sum(bins.station.reshape(-1, factor) * weight, axis=1)
    mean = np.einsum("bfk,bf->bk", bins.mean.reshape(-1, factor, 3), weight)
    return Bins(station, n, mean, bins.length, bins.closed)


def select_bandwidths(bins: Bins, candidates: NDArray[np.float64], variance: float) -> Bandwidths:
    """Choose the bandwidths of least C_p, order by order.

    Parameters
    ----------
    bins : Bins
    candidates : (H,) array
    variance : float
        Noise variance, all normal directions together.
    """
    inside = _least_cp(bins, candidates, variance, INSIDE)
    ends = inside if bins.closed else _least_cp(bins, candidates, variance, AT_ENDS)
    return Bandwidths(inside, ends)


def _least_cp(bins: Bins, candidates: NDArray[np.float64], variance: float, order: int) -> float:
    """The candidate of least C_p, judged away from open ends, where one-sided windows rule."""
    some = np.flatnonzero(bins.count)
    some = some[:: max(1, len(some) // JUDGED_BINS)]
    station, count, mean = bins.station[some], bins.count[some], bins.mean[some]
    scores = np.empty(len(candidates))
    for k, h in enumerate(candidates):
        fit = one_order(bins, station, float(h), order, BINS_TO_JUDGE)
        residual = np.einsum("ij,ij->i", mean - fit.value, mean - fit.value)
        scores[k] = np.sum(count * (residual + PENALTY * variance * fit.leverage))
    return _lowest(np.log(candidates), scores)


def _lowest(log_h: NDArray[np.float64], scores: NDArray[np.float64]) -> float:
    """Bandwidth at the vertex of the parabola through the least score and its neighbours.

    The choice then varies continuously with the samples.
    """
    k = int(np.argmin(scores))
    if not 0 < k < len(scores) - 1:
        return float(np.exp(log_h[k]))
    step = log_h[k + 1] - log_h[k]
    rise = scores[k - 1] - 2.0 * scores[k] + scores[k + 1]
    shift = 0.5 * (scores[k - 1] - scores[k + 1]) / rise if rise > 0.0 else 0.0
    return float(np.exp(log_h[k] + shift * step))


@njit(cache=True)
def solve(m, rhs, size):  # type: ignore[no-untyped-def]
    """Solve the leading ``size`` rows in place by Cholesky; False when not positive definite."""
    for i in range(size):
        for j in range(i + 1):
            total = m[i, j]
            for k in range(j):
                total -= m[i, k] * m[j, k]
            if i == j:
                if total <= 1e-11 * m[i, i] or total <= 0.0:
                    return False
                m[i, i] = np.sqrt(total)
            else:
                m[i, j] = total / m[j, j]
    for c in range(rhs.shape[1]):
        for i in range(size):
            total = rhs[i, c]
            for k in range(i):
                total -= m[i, k] * rhs[k, c]
            rhs[i, c] = total / m[i, i]
        for i in range(size - 1, -1, -1):
            total = rhs[i, c]
            for k in range(i + 1, size):
                total -= m[k, i] * rhs[k, c]
            rhs[i, c] = total / m[i, i]
    return True


@njit(cache=True, inline="always")
def reach_of(s, h, length, bins, closed):  # type: ignore[no-untyped-def]
    """First and last bin of the window around ``s``, and whether it goes all the way round."""
    width = length / bins
    first, last = int(np.floor((s - h) / width)) - 1, int(np.floor((s + h) / width)) + 1
    if closed and last - first >= bins:
        return 0, bins - 1, True
    return (first, last, False) if closed else (max(first, 0), min(last, bins - 1), False)


@njit(cache=True, inline="always")
def offset_of(j, station, s, h, length, whole):  # type: ignore[no-untyped-def]
    """Bin ``j``, counted beyond the seam, as one on the curve, and its place in the window, -1 to 1."""
    bins = station.shape[0]
    b, shift = j, 0.0
    if b < 0:
        b += bins
        shift = -length
    elif b >= bins:
        b -= bins
        shift = length
    away = station[b] + shift - s
    if whole:  # each bin counts once, on the side where it is nearer
        away -= length * np.round(away / length)
    return b, away / h


@njit(cache=True)
def _window(station, count, mean, length, closed, s, h, moments, target):  # type: ignore[no-untyped-def]
    """Moments of the window around ``s``; returns the number of bins with samples in it."""
    first, last, whole = reach_of(s, h, length, station.shape[0], closed)
    moments[:] = 0.0
    target[:] = 0.0
    used = 0
    for j in range(first, last + 1):
        b, u = offset_of(j, station, s, h, length, whole)
        if count[b] == 0.0 or abs(u) >= 1.0:
            continue
        used += 1
        w = count[b] * (1.0 - u * u)
        x, y, z = mean[b, 0], mean[b, 1], mean[b, 2]
        for p in range(9):
            moments[p] += w
            if p < 5:
                target[p, 0] += w * x
                target[p, 1] += w * y
                target[p, 2] += w * z
            w *= u
    return used


@njit(cache=True)
def polynomial_at(  # type: ignore[no-untyped-def]
    station, count, mean, length, closed, s, h, highest, feedback, moments, target, m, rhs
):  # fmt: skip
    """Solve for the local polynomial of the highest order that the window's samples allow.

    Leaves in the columns of ``rhs`` its coefficients for x, y and z, and those of the polynomial that
    gives the weights of samples in its value plus ``feedback`` times its second derivative. Returns the
    order, -1 without samples, and the half-width of the window.
    """
    used = _window(station, count, mean, length, closed, s, h, moments, target)
    while used < highest + 2 and h < length:
        h *= 1.3
        used = _window(station, count, mean, length, closed, s, h, moments, target)
    for order in range(highest, -1, -1):
        if used <= order + 1 and order > 0:
            continue
        for a in range(order + 1):
            for b in range(order + 1):
                m[a, b] = moments[a + b]
            for k in range(3):
                rhs[a, k] = target[a, k]
            rhs[a, 3] = 1.0 if a == 0 else 0.0
        if order >= 2:
            rhs[2, 3] = 2.0 * feedback / (h * h)
        if solve(m, rhs, order + 1):
            return order, h
    return -1, h


@njit(cache=True)
def _fit_all(station, count, mean, length, closed, at, bandwidth, highest):  # type: ignore[no-untyped-def]
    """Local polynomials at each station of ``at``."""
    n = at.shape[0]
    value, second, leverage = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    moments, target = np.empty(9), np.empty((5, 3))
    m, rhs = np.empty((5, 5)), np.empty((5, 4))
    for i in range(n):
        order, h = polynomial_at(
            station, count, mean, length, closed, at[i], bandwidth, highest, 0.0, moments, target, m, rhs
        )  # fmt: skip
        if order < 0:
            continue
        for k in range(3):
            value[i, k] = rhs[0, k]
            second[i, k] = 2.0 * rhs[2, k] / (h * h) if order >= 2 else 0.0
        leverage[i] = rhs[0, 3]
    return value, second, leverage
