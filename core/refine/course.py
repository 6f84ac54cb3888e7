"""One regression: samples with known stations along a stretch of curve become its fitted course."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.local_noise import LocalNoise, sigma_along
from core.refine.noise import mass, mean_square, noise_of
from core.refine.regression import Bandwidths, Bins, Fit, bin_samples, local_fit, select_bandwidths
from core.refine.uncertainty import residuals_of, sigma_error, standard_error

__all__ = ["Course", "Rules", "fit_course"]

Floats = NDArray[np.float64]

LEAST_BANDWIDTH = 8.0  # in sigma: below, wiggles reinforce themselves from pass to pass
LAST_BANDWIDTH = 5.0  # in sigma: the last pass is not followed by another
RATIO = 1.25  # of neighbouring bandwidths
NARROW = 2.0  # later passes look for the bandwidth within this factor of the last


@dataclass(frozen=True, slots=True)
class Rules:
    """What is the same for all fits.

    Attributes
    ----------
    normals : int
        Number of normal directions: 1 in a plane, 2 in space.
    cut : float
        Samples farther than this many sigma take no part.
    spacing : float or None
        Spacing of the vertices; None: fine enough for the standard error.
    final : bool
        Whether this is the last pass, of which standard errors are wanted.
    """

    normals: int
    cut: float
    spacing: float | None
    final: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A fitted stretch: vertices (M, 3) and noise with their standard errors, and the bandwidths.

    The standard errors are NaN where they were not wanted. ``wide`` (M, 3) is the course with windows of
    eight sigma at least, as all passes but the last see the curve;
    ``along`` is the noise as it varies, ``noise`` its mean.
    """

    vertices: Floats
    wide: Floats
    error: Floats
    noise: float
    noise_error: float
    along: LocalNoise
    bandwidths: Bandwidths


def fit_course(
    points: Floats,
    station: Floats,
    distance: Floats,
    span: float,
    closed: bool,
    sigma: float,
    rules: Rules,
    last: Bandwidths | None = None,
    weight: Floats | None = None,
    along: LocalNoise | None = None,
) -> Course:
    """Regress samples on their stations, free of the bias that curvature gives.

    Parameters
    ----------
    points : (N, 3) array
    station : (N,) array
        Arc lengths of their feet, in [0, span].
    distance : (N,) array
        Distances to their feet.
    span : float
        Length of the stretch.
    closed : bool
    sigma : float
        Noise estimate.
    rules : Rules
    last : Bandwidths, optional
        Of the pass before, to search about.
    weight : (N,) array, optional
        Shares of the samples that are this curve's.
    along : LocalNoise, optional
        Noise along the stretch by which samples were cut; the same everywhere by default.
    """
    before = LocalNoise.constant(sigma, span) if along is None else along
    least = (LAST_BANDWIDTH if rules.final else LEAST_BANDWIDTH) * sigma
    count = _bin_count(span, least, mass(len(points), weight))
    bins = bin_samples(points, station, span, count, closed, weight)
    variance = mean_square(distance, weight)
    h = select_bandwidths(bins, _candidates(bins, least, last), variance)
    fitted = local_fit(bins, bins.station, h)
    spent = float(np.sum(bins.count * fitted.leverage))
    along = _noise_along(station, distance, span, closed, before, rules, weight, spent, last is None)
    noise = along.mean
    count = _vertex_count(bins, fitted, noise, h.inside, rules.spacing)
    at = np.linspace(0.0, span, count + (1 if closed else 0))[:count]
    blur = along.at(at) ** 2
    vertices = _unbiased(bins, at, h, blur)
    if not rules.final:
        return Course(vertices, vertices, np.full(count, np.nan), noise, np.nan, along, h)
    wide = Bandwidths(*(max(width, LEAST_BANDWIDTH * sigma) for width in (h.inside, h.ends)))
    seen = vertices if wide == h else _unbiased(bins, at, wide, blur)
    relative = distance / np.maximum(before.at(station), 1e-300)
    residuals = residuals_of(
        bins, station, distance, relative, weight, spent, rules.cut, rules.normals, h.inside
    )
    error = standard_error(bins, at, h, residuals, noise, rules.normals)
    noise_error = sigma_error(relative, weight, spent, noise, rules.normals)
    return Course(vertices, seen, error, noise, noise_error, along, h)


def _noise_along(
    station: Floats,
    distance: Floats,
    span: float,
    closed: bool,
    before: LocalNoise,
    rules: Rules,
    weight: Floats | None,
    spent: float,
    first: bool,
) -> LocalNoise:
    """Noise along a stretch: how it varies is asked in the passes between the first and the last."""
    if not rules.final and not first:
        return sigma_along(station, distance, span, closed, before, rules.cut, rules.normals, weight, spent)
    if not before.varies:
        noise = noise_of(distance, spent, float(before.sigma[0]), rules.cut, rules.normals, weight)
        return LocalNoise.constant(noise, span)
    relative = distance / before.at(station)
    return before.scaled(noise_of(relative, spent, 1.0, rules.cut, rules.normals, weight))


def _unbiased(bins: Bins, at: Floats, h: Bandwidths, blur: Floats) -> Floats:
    """The fit, free of the bias that curvature gives where noise blurs the feet by a variance ``blur``."""
    fit = local_fit(bins, at, h)
    return fit.value + 0.5 * blur[:, None] * fit.second


def _bin_count(span: float, least: float, samples: float) -> int:
    """Bins a twelfth of the least bandwidth wide, at least 100, never many more than samples."""
    wished = 12.0 * span / max(least, 1e-6 * span)
    count = min(max(wished, 100.0), 4000.0, max(samples / 2.0, 8.0))
    # Multiples of powers of two merge well.
    unit = 1 << max(int(np.log2(count)) - 4, 0)
    return int(max(count // unit, 1)) * unit


def _candidates(bins: Bins, least: float, last: Bandwidths | None) -> Floats:
    """Bandwidths from the least, or from eight samples, to half the curve, or about the last ones."""
    samples = float(bins.count.sum())
    low = max(least, 8.0 * bins.length / samples, 2.5 * bins.length / len(bins.station))
    high = max(0.5 * bins.length, 1.01 * low)
    if last is not None:
        low = min(max(low, min(last.inside, last.ends) / NARROW), high / 1.01)
        high = max(min(high, max(last.inside, last.ends) * NARROW), 1.01 * low)
    return np.geomspace(low, high, max(int(np.log(high / low) / np.log(RATIO)) + 1, 2))


def _vertex_count(bins: Bins, fit: Fit, noise: float, h: float, spacing: float | None) -> int:
    """Chords deviate by at most a fifth of the standard error, within 64 to 4000 vertices."""
    if spacing is not None:
        return int(min(max(np.ceil(bins.length / spacing), 3), 1_000_000)) + (0 if bins.closed else 1)
    curvature = float(np.quantile(np.linalg.norm(fit.second, axis=1), 0.95))
    error = noise * np.sqrt(max(float(np.median(fit.leverage)), 0.0))
    chord = np.sqrt(8.0 * 0.2 * max(error, 1e-9 * bins.length) / max(curvature, 1e-9 / bins.length))
    chord = max(min(chord, 0.25 * h), 1e-9 * bins.length, 1e-300)
    return int(min(max(bins.length / chord, 64.0), 4000.0))
