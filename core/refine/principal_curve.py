"""Refinement: each curve becomes the local regression of its samples (Hastie & Stuetzle 1989).

Averages of samples with a common foot lie outside a bend, by kappa sigma^2 / 2: isotropic
noise meets more curve length inside than outside. The second derivative of the fit gives
that bias, and it is taken out; more samples would never do so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.refine.ends import ends_of, prolonged
from core.refine.noise import noise_of
from core.refine.polyline import Polyline
from core.refine.project import Feet, project
from core.refine.regression import Bandwidths, Bins, Fit, bin_samples, local_fit, select_bandwidths

__all__ = ["CUT", "Refined", "as_they_are", "refine_curves"]

Floats = NDArray[np.float64]

LEAST_BANDWIDTH = 8.0  # in sigma: below, wiggles reinforce themselves
CUT = 4.0  # in sigma: farther samples take no part
PROLONGED = 3.0  # in sigma: how far an open curve may grow in one pass
LEAST_SAMPLES = 8
PASSES = 3
RATIO = 1.25  # of neighbouring bandwidths
NARROW = 2.0  # later passes look for the bandwidth within this factor of the last


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """Refined curves and the samples' feet on them.

    Attributes
    ----------
    curves : tuple of Polyline
    feet : Feet
        Of all samples.
    sigma : float
        Noise estimate from the residuals of all curves together.
    sigmas : (C,) array
        The same, curve by curve.
    errors : tuple of (M,) arrays
        Pointwise standard error at the vertices.
    """

    curves: tuple[Polyline, ...]
    feet: Feet
    sigma: float
    sigmas: Floats
    errors: tuple[Floats, ...]


def refine_curves(
    sample: Sample,
    curves: Sequence[Polyline],
    sigma: float,
    flat: bool,
    cut: float = CUT,
    spacing: float | None = None,
    passes: int = PASSES,
) -> Refined:
    """Iterate projection and regression, on a subsample first, on all samples last.

    Parameters
    ----------
    sample : Sample
    curves : sequence of Polyline
        First approximations, from the march or from a skeleton.
    sigma : float
        Noise estimate.
    flat : bool
        Whether there is one normal direction (a plane) or two.
    cut : float
        Samples farther than this many sigma take no part.
    spacing : float, optional
        Spacing of the result's vertices; by default fine enough for the standard error.
    passes : int
        Iterations over the subsample; one over all samples follows.
    """
    rules = _Rules(1 if flat else 2, cut, None)
    states = [_State(line, sigma, np.zeros(len(line.vertices)), None) for line in curves]
    for _ in range(passes):
        states = _one_pass(sample.few, states, rules)
    states = _one_pass(sample.points, states, replace(rules, spacing=spacing))
    lines = [state.line for state in states]
    sigmas = np.array([state.sigma for state in states])
    feet = project(sample.points, lines, _reach(sigmas, cut))
    return Refined(tuple(lines), feet, _noise(feet, sigmas), sigmas, tuple(state.error for state in states))


@dataclass(frozen=True, slots=True)
class _Rules:
    """Number of normal directions, cut in sigma, and the wished spacing of vertices."""

    normals: int
    cut: float
    spacing: float | None


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """A curve between passes: course, noise, standard error at its vertices, last bandwidths."""

    line: Polyline
    sigma: float
    error: Floats
    bandwidths: Bandwidths | None


def _reach(sigmas: Floats, cut: float) -> float:
    return max(float(sigmas.max()) * cut, 1e-9)


def _one_pass(samples: Floats, states: list[_State], rules: _Rules) -> list[_State]:
    """Project all samples, and refit every curve to its own."""
    sigmas = np.array([state.sigma for state in states])
    lines = [prolonged(state.line, PROLONGED * state.sigma) for state in states]
    feet = project(samples, lines, _reach(sigmas, rules.cut))
    near = feet.distance < rules.cut * np.append(np.maximum(sigmas, 1e-12), 0.0)[feet.curve]
    groups = _groups(feet.curve, near, len(lines))
    return [
        _refit(samples[mine], feet.station[mine], feet.distance[mine], replace(state, line=line), rules)
        for mine, state, line in zip(groups, states, lines, strict=True)
    ]


def _groups(curve: NDArray[np.int64], near: NDArray[np.bool_], count: int) -> list[NDArray[np.int64]]:
    """Indices of the near samples of each curve."""
    if count == 1:
        return [np.flatnonzero(near)]
    order = np.argsort(curve, kind="stable")
    order = order[near[order]]
    bounds = np.searchsorted(curve[order], np.arange(count + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(count)]


def _refit(points: Floats, station: Floats, distance: Floats, state: _State, rules: _Rules) -> _State:
    """Regress one curve on the arc length of its samples' feet."""
    line, sigma = state.line, state.sigma
    if len(points) < LEAST_SAMPLES:
        return replace(state, error=np.zeros(len(line.vertices)))
    low, high = (0.0, line.length) if line.closed else ends_of(station, line.length, sigma)
    span = high - low
    keep = np.ones(len(points), np.bool_) if line.closed else (station >= low) & (station <= high)
    if span <= 0.0 or np.count_nonzero(keep) < LEAST_SAMPLES:
        return replace(state, error=np.zeros(len(line.vertices)))
    points, station, distance = points[keep], station[keep] - low, distance[keep]
    bins = bin_samples(points, station, span, _bin_count(span, sigma, len(points)), line.closed)
    variance = float(np.mean(distance**2))
    h = select_bandwidths(bins, _candidates(bins, sigma, state.bandwidths), variance)
    refitted = _evaluate(bins, h, distance, sigma, rules)
    if _has_run_away(refitted.line, line, max(rules.cut * sigma, 0.05 * span)):
        return replace(state, error=np.zeros(len(line.vertices)))
    return refitted


def _has_run_away(line: Polyline, last: Polyline, reach: float) -> bool:
    """Whether a fit left the last course: a polynomial that too few samples hold may go anywhere."""
    if not np.all(np.isfinite(line.vertices)):
        return True
    return bool(np.any(project(line.vertices, [last], reach).curve < 0))


def _bin_count(span: float, sigma: float, samples: int) -> int:
    """Bins a twelfth of the least bandwidth wide, at least 100, never many more than samples."""
    wished = 12.0 * span / max(LEAST_BANDWIDTH * sigma, 1e-6 * span)
    count = min(max(wished, 100.0), 4000.0, max(samples / 2.0, 8.0))
    # Multiples of powers of two merge well.
    unit = 1 << max(int(np.log2(count)) - 4, 0)
    return int(max(count // unit, 1)) * unit


def _candidates(bins: Bins, sigma: float, last: Bandwidths | None) -> Floats:
    """Bandwidths from eight sigma or eight samples to half the curve, or about the last ones."""
    samples = float(bins.count.sum())
    low = max(LEAST_BANDWIDTH * sigma, 8.0 * bins.length / samples, 2.5 * bins.length / len(bins.station))
    high = max(0.5 * bins.length, 1.01 * low)
    if last is not None:
        low = min(max(low, min(last.inside, last.ends) / NARROW), high / 1.01)
        high = max(min(high, max(last.inside, last.ends) * NARROW), 1.01 * low)
    return np.geomspace(low, high, max(int(np.log(high / low) / np.log(RATIO)) + 1, 2))


def _evaluate(bins: Bins, h: Bandwidths, distance: Floats, sigma: float, rules: _Rules) -> _State:
    """Put the fitted curve at equidistant stations, with its noise and its standard error."""
    fitted = local_fit(bins, bins.station, h)
    spent = float(np.sum(bins.count * fitted.leverage))
    noise = noise_of(distance, spent, sigma, rules.cut, rules.normals)
    count = _vertex_count(bins, fitted, noise, h.inside, rules.spacing)
    at = np.linspace(0.0, bins.length, count + (1 if bins.closed else 0))[:count]
    fit = local_fit(bins, at, h)
    vertices = fit.value + 0.5 * noise**2 * fit.second
    error = noise * np.sqrt(np.maximum(fit.leverage, 0.0))
    return _State(Polyline(vertices, bins.closed), noise, error, h)


def _vertex_count(bins: Bins, fit: Fit, noise: float, h: float, spacing: float | None) -> int:
    """Chords deviate by at most a fifth of the standard error, within 64 to 4000 vertices."""
    if spacing is not None:
        return int(min(max(np.ceil(bins.length / spacing), 3), 1_000_000)) + (0 if bins.closed else 1)
    curvature = float(np.quantile(np.linalg.norm(fit.second, axis=1), 0.95))
    error = noise * np.sqrt(max(float(np.median(fit.leverage)), 0.0))
    chord = np.sqrt(8.0 * 0.2 * max(error, 1e-9 * bins.length) / max(curvature, 1e-9 / bins.length))
    return int(min(max(bins.length / min(chord, 0.25 * h), 64.0), 4000.0))


def _noise(feet: Feet, sigmas: Floats) -> float:
    """Noise over all curves: the mean variance, weighted by samples."""
    counts = np.bincount(feet.curve[feet.curve >= 0], minlength=len(sigmas)).astype(np.float64)
    return float(np.sqrt(np.sum(counts * sigmas**2) / max(float(counts.sum()), 1.0)))


def as_they_are(
    sample: Sample,
    curves: Sequence[Polyline],
    sigma: float,
    flat: bool,
    cut: float = CUT,
    spacing: float | None = None,
) -> Refined:
    """Keep curves where they are, with the arguments and the answer of :func:`refine_curves`."""
    lines = [line if spacing is None else line.resampled(spacing, 3) for line in curves]
    feet = project(sample.points, lines, max(sigma * cut, 1e-9))
    sigmas = np.array([_spread(feet, k, sigma, flat) for k in range(len(lines))])
    errors = tuple(np.zeros(len(line.vertices)) for line in lines)
    return Refined(tuple(lines), feet, _noise(feet, sigmas), sigmas, errors)


def _spread(feet: Feet, k: int, sigma: float, flat: bool) -> float:
    """Noise about one curve from its samples' distances."""
    distance = feet.distance[feet.curve == k]
    return float(np.sqrt(np.mean(distance**2) / (1 if flat else 2))) if len(distance) else sigma
