"""The pointwise standard error of a fitted course.

The fit is linear in its samples, ``f(s) = sum l_i(s) w_i x_i`` with w_i the share of sample i that is
this curve's. Its variance is the sandwich ``sum (l_i w_i)^2 v_i`` (White 1980; Fan & Gijbels, Local
Polynomial Modelling, 1996, ch. 4) with v the mean square of the residuals about. Three things that it
does not hold are put in: samples shared between branches, or cut off, hold the curve less (Louis
1982); a course that bends a little takes the samples' feet along with it, and so bends a little more;
and the bandwidth of least C_p leaves a bias in proportion to the variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.refine.noise import mass, mean_square
from core.refine.regression import (
    AT_ENDS,
    BINS_TO_JUDGE,
    INSIDE,
    PENALTY,
    Bandwidths,
    Bins,
    blend_of,
    merged,
    offset_of,
    one_order,
    polynomial_at,
    reach_of,
)

__all__ = ["Residuals", "residuals_of", "sigma_error", "standard_error", "with_plane"]

Floats = NDArray[np.float64]

# With a bias of h^6 and a variance of 1/h, the least C_p of that penalty leaves so much of the variance.
BIAS = (PENALTY - 1.0) / 12.0
FEEDBACK = -0.5  # in sigma^2 times the second derivative: what the feet give back, less the correction
STATIONS = 3.0  # to a bandwidth
MOST_STATIONS = 1000
LOCAL = 50.0  # samples either side that the local noise is averaged over, at least
CERTAIN = 2.0  # times its sampling variance: the noise's variation below is taken for chance
SHELL = 0.9  # in cuts: samples farther out tell the density at the cut
LEAST_HELD = 0.2  # share of the samples' information that the worst assignment leaves
TUBE = 1.2430  # half of the length that a standard normal vector in a plane exceeds in 4.55 % of cases


@dataclass(frozen=True, slots=True, eq=False)
class Residuals:
    """What the samples of each of B bins tell of noise and assignment.

    Attributes
    ----------
    squares : (B,) array
        Sum of the squared shares of the samples.
    held : (B,) array
        Samples' worth of information on where the curve is.
    variation : (B,) array
        Noise variance as a multiple of its mean, smooth along the curve.
    mean : float
        Mean square of the residuals in one normal direction, what outliers add to it with it.
    """

    squares: Floats
    held: Floats
    variation: Floats
    mean: float


def residuals_of(
    bins: Bins,
    station: Floats,
    distance: Floats,
    relative: Floats,
    weight: Floats | None,
    spent: float,
    cut: float,
    normals: int,
    width: float,
) -> Residuals:
    """Sum up noise and assignment along a curve.

    Parameters
    ----------
    bins : Bins
        Of these samples.
    station, distance : (N,) array
        Of the samples' feet.
    relative : (N,) array
        Distances in units of the noise by which samples were cut.
    weight : (N,) array or None
        Shares of the samples that are this curve's.
    spent : float
        Degrees of freedom of the fit.
    cut : float
        From this relative distance on samples took no part.
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    width : float
        Half-width of the windows that noise is averaged over, at least.
    """
    sums = _summed(
        station, distance, np.empty(0) if weight is None else weight, bins.length, len(bins.count), normals
    )
    count, squares, rest, fourth, lost = sums
    mean = max(float(rest.sum()) / max(float(count.sum()) - spent, 1.0), 1e-300)
    variation = _variation(bins, count, rest, fourth, width)
    kept = np.clip(1.0 - lost / (mean * variation * np.maximum(count, 1e-12)), LEAST_HELD, 1.0)
    return Residuals(
        squares, bins.count * kept * _held_by_all(relative, weight, cut, normals), variation, mean
    )


@njit(cache=True)
def _summed(station, distance, weight, length, count, normals):  # type: ignore[no-untyped-def]
    """Sum shares and their squares, squared and fourth-power residuals, and those of doubtful shares."""
    out = np.zeros((5, count))
    weighted = weight.shape[0] > 0
    for i in range(station.shape[0]):
        b = min(int(station[i] / length * count), count - 1)
        w = weight[i] if weighted else 1.0
        square = distance[i] ** 2 / normals
        out[0, b] += w
        out[1, b] += w * w
        out[2, b] += w * square
        out[3, b] += w * square * square
        out[4, b] += w * (1.0 - w) * square
    return out


def _held_by_all(relative: Floats, weight: Floats | None, cut: float, normals: int) -> float:
    """Share of the information that is left where the cut falls among samples.

    Were the curve elsewhere, others would be cut off: with the density f of distances at the cut, a
    mean of what is not cut tells ``1 - cut f / normals`` of it (Huber's skipped mean).
    """
    far = relative > SHELL * cut
    shell = float(np.count_nonzero(far) if weight is None else weight[far].sum()) / (1.0 - SHELL)
    return max(1.0 - shell / (normals * max(mass(len(relative), weight), 1e-300)), LEAST_HELD)


def _variation(bins: Bins, count: Floats, rest: Floats, fourth: Floats, width: float) -> Floats:
    """Noise variance along the curve as a multiple of its mean, as far as it is no chance."""
    samples = float(count.sum())
    width = max(width, LOCAL * bins.length / max(samples, 1.0))
    if width >= 0.5 * bins.length:
        return np.ones(len(count))
    ratio = rest / np.maximum(count, 1e-12) * (samples / float(max(rest.sum(), 1e-300)))
    means = Bins(bins.station, count, np.repeat(ratio[:, None], 3, axis=1), bins.length, bins.closed)
    at = np.linspace(0.0, bins.length, int(STATIONS * bins.length / width) + 2)
    local = one_order(means, at, width, 0)
    found = local.value[:, 0]
    spread = max(samples * float(fourth.sum()) / float(max(rest.sum(), 1e-300)) ** 2 - 1.0, 0.0)
    chance = CERTAIN * spread * float(np.mean(local.leverage))
    sure = max(1.0 - chance / max(float(np.mean((found - 1.0) ** 2)), 1e-300), 0.0)
    return np.asarray(np.interp(bins.station, at, 1.0 + sure * (found - 1.0)))


def standard_error(
    bins: Bins, at: Floats, bandwidths: Bandwidths, residuals: Residuals, sigma: float, normals: int
) -> Floats:
    """Compute the standard error of a fitted course normal to it.

    In space the truth lies anywhere around: there, as in a plane, two standard errors are the radius
    that it exceeds once in 22 times.

    Parameters
    ----------
    bins : Bins
    at : (K,) array
        Stations.
    bandwidths : Bandwidths
        Of the fit.
    residuals : Residuals
    sigma : float
        Noise that blurs the feet.
    normals : int

    Returns
    -------
    (K,) array
    """
    narrowest = min(bandwidths.inside, bandwidths.ends)
    places = np.linspace(0.0, bins.length, int(min(STATIONS * bins.length / narrowest, MOST_STATIONS)) + 2)
    coarse = merged(bins, narrowest, BINS_TO_JUDGE)
    parts = len(coarse.count), -1
    held = residuals.held.reshape(parts).sum(axis=1)
    noise = residuals.mean * (residuals.squares * residuals.variation).reshape(parts).sum(axis=1)
    error = _errors(
        coarse.station, held, noise, bins.length, bins.closed, places, blend_of(bins, places, bandwidths),
        _half_round(bins, bandwidths.inside), _half_round(bins, bandwidths.ends), FEEDBACK * sigma**2,
    )  # fmt: skip
    factor = np.sqrt(1.0 + BIAS) * (TUBE if normals == 2 else 1.0)
    return np.asarray(factor * np.interp(at, places, error))


def _half_round(bins: Bins, bandwidth: float) -> float:
    return min(bandwidth, 0.5 * bins.length) if bins.closed else bandwidth


@njit(cache=True)
def _errors(station, held, noise, length, closed, places, blend, inside, ends, feedback):  # type: ignore[no-untyped-def]
    """Standard deviation of the blended fit at each place, given the sums of ``noise`` in each bin."""
    bins = station.shape[0]
    weight, none = np.zeros(bins), np.zeros((bins, 3))
    moments, target = np.empty(9), np.empty((5, 3))
    m, rhs = np.empty((5, 5)), np.empty((5, 4))
    out = np.zeros(places.shape[0])
    for i in range(places.shape[0]):
        s, low, high = places[i], bins, -1
        for part in range(2):
            share = blend[i] if part == 0 else 1.0 - blend[i]
            if share == 0.0:
                continue
            order, h = polynomial_at(
                station, held, none, length, closed, s, inside if part == 0 else ends,
                INSIDE if part == 0 else AT_ENDS, feedback, moments, target, m, rhs,
            )  # fmt: skip
            first, last, whole = reach_of(s, h, length, bins, closed)
            for j in range(first, last + 1):
                b, u = offset_of(j, station, s, h, length, whole)
                if abs(u) < 1.0:
                    total = 0.0
                    for p in range(order, -1, -1):
                        total = total * u + rhs[p, 3]
                    weight[b] += share * (1.0 - u * u) * total
            low, high = min(low, first), max(high, last)
        for j in range(low, high + 1):
            b = j % bins
            out[i] += weight[b] ** 2 * noise[b]
            weight[b] = 0.0
        out[i] = np.sqrt(out[i])
    return out


def sigma_error(distance: Floats, weight: Floats | None, spent: float, sigma: float, normals: int) -> float:
    """Compute the standard error of a curve's noise from the spread of its samples' squared distances.

    Of Gaussian noise it is ``sigma / sqrt(2 nu)`` with nu degrees of freedom; heavier tails make it larger.

    Parameters
    ----------
    distance : (N,) array
        Distances of the samples that took part, in any unit: in that of the local noise where it varies.
    weight : (N,) array or None
        Shares of the samples that are this curve's.
    spent : float
        Degrees of freedom of the fit.
    sigma : float
        The noise.
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    """
    samples = mass(len(distance), weight)
    if samples == 0.0:
        return sigma
    # Only their proportions count; in units of a noise that is nothing but rounding squares would overflow.
    square = (distance / max(float(distance.max()), 1e-300)) ** 2
    fourth = mean_square(square, weight)
    mean = float(np.average(square, weights=weight))
    # The squared length of a normal vector has a variance of 2 / normals of its mean's square.
    excess = normals * (fourth / max(mean**2, 1e-300) - 1.0) / 2.0
    return sigma * float(np.sqrt(max(excess, 1.0) / (2.0 * normals * max(samples - spent, 1.0))))


def with_plane(error: Floats, vertices: Floats, samples: Floats, sigma: float) -> Floats:
    """Add what is not known of the plane that a curve in space was projected on (§3.1).

    The plane of least squares has the error of a regression on two coordinates: ``sigma^2 / N`` times
    one plus the squared Mahalanobis distance from the centre.

    Parameters
    ----------
    error : (M,) array
        Standard errors in the plane.
    vertices : (M, 3) array
    samples : (N, 3) array
        In the plane z = 0, all that determined it.
    sigma : float
        Noise across the plane.
    """
    centre = samples[:, :2].mean(axis=0)
    offset, away = samples[:, :2] - centre, vertices[:, :2] - centre
    covariance = np.einsum("ni,nj->ij", offset, offset) / len(samples)
    covariance += 1e-12 * max(float(np.trace(covariance)), 1e-300) * np.eye(2)
    lever = 1.0 + np.einsum("mi,ij,mj->m", away, np.linalg.inv(covariance), away)
    # Of two independent errors, the lesser one adds this much of its square to that of the tube.
    return np.asarray(np.sqrt(error**2 + (TUBE**2 - 1.0) * sigma**2 * lever / len(samples)))
