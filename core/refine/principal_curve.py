"""Refinement: each curve becomes the local regression of its samples (Hastie & Stuetzle 1989).

Averages of samples with a common foot lie outside a bend, by kappa sigma^2 / 2: isotropic
noise meets more curve length inside than outside. The second derivative of the fit gives
that bias, and it is taken out; more samples would never do so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erf

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.refine.polyline import Polyline
from core.refine.project import Feet, project
from core.refine.regression import Bandwidths, Bins, Fit, bin_samples, local_fit, select_bandwidths

__all__ = ["Refined", "refine_curves"]

Floats = NDArray[np.float64]

LEAST_BANDWIDTH = 8.0  # in sigma: below, wiggles reinforce themselves
CUT = 4.0  # in sigma: farther samples take no part
END_MASS = 0.3989  # E max(0, X) of a standard normal X: share of rho sigma beyond an open end
PASSES = 3


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
    rounds = [sample.few] * passes + [sample.points]
    lines = list(curves)
    sigmas = np.full(len(lines), sigma)
    errors: list[Floats] = [np.zeros(len(line.vertices)) for line in lines]
    for number, samples in enumerate(rounds):
        lines, sigmas, errors = _one_pass(
            samples, lines, sigmas, flat, cut, spacing if number == len(rounds) - 1 else None
        )
    feet = project(sample.points, lines, _reach(sigmas, cut))
    return Refined(tuple(lines), feet, _noise(feet, sigmas), sigmas, tuple(errors))


def _reach(sigmas: Floats, cut: float) -> float:
    return max(float(sigmas.max()) * cut, 1e-9)


def _one_pass(
    samples: Floats, lines: list[Polyline], sigmas: Floats, flat: bool, cut: float, spacing: float | None
) -> tuple[list[Polyline], Floats, list[Floats]]:
    """Project all samples, and refit every curve to its own."""
    extended = [_extended(line, 3.0 * s) for line, s in zip(lines, sigmas, strict=True)]
    feet = project(samples, extended, _reach(sigmas, cut))
    near = feet.distance < cut * np.append(np.maximum(sigmas, 1e-12), 0.0)[feet.curve]
    groups = _groups(feet.curve, near, len(lines))
    out: list[Polyline] = []
    noise = sigmas.copy()
    errors: list[Floats] = []
    for k, line in enumerate(extended):
        mine = groups[k]
        refined, noise[k], error = _refit(
            samples[mine], feet.station[mine], feet.distance[mine], line, sigmas[k], flat, cut, spacing
        )
        out.append(refined)
        errors.append(error)
    return out, noise, errors


def _groups(curve: NDArray[np.int64], near: NDArray[np.bool_], count: int) -> list[NDArray[np.int64]]:
    """Indices of the near samples of each curve."""
    if count == 1:
        return [np.flatnonzero(near)]
    order = np.argsort(curve, kind="stable")
    order = order[near[order]]
    bounds = np.searchsorted(curve[order], np.arange(count + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(count)]


def _extended(line: Polyline, by: float) -> Polyline:
    """An open curve prolonged straight at both ends, so that samples beyond them have a foot."""
    if line.closed or by <= 0.0:
        return line
    x = line.vertices
    span = min(by, 0.25 * line.length)
    head = x[0] - line.at(np.array([max(span, line.length * 0.02)]))[0]
    tail = x[-1] - line.at(np.array([line.length - max(span, line.length * 0.02)]))[0]
    first = x[0] + head * (by / max(float(np.linalg.norm(head)), 1e-300))
    last = x[-1] + tail * (by / max(float(np.linalg.norm(tail)), 1e-300))
    return Polyline(np.concatenate([first[None], x, last[None]]), False)


def _refit(
    points: Floats,
    station: Floats,
    distance: Floats,
    line: Polyline,
    sigma: float,
    flat: bool,
    cut: float,
    spacing: float | None,
) -> tuple[Polyline, float, Floats]:
    """One curve's regression on the arc length of its samples' feet."""
    if len(points) < 8:
        return line, sigma, np.zeros(len(line.vertices))
    length = line.length
    low, high = (0.0, length) if line.closed else _ends(station, length, sigma)
    span = high - low
    if span <= 0.0:
        return line, sigma, np.zeros(len(line.vertices))
    inside = np.clip(station - low, 0.0, span)
    keep = np.ones(len(points), np.bool_) if line.closed else (station >= low) & (station <= high)
    bins = bin_samples(points[keep], inside[keep], span, _bin_count(span, sigma, len(points)), line.closed)
    normals = 1 if flat else 2
    h = _bandwidths(bins, sigma, distance[keep], normals)
    return _evaluate(bins, h, normals, distance[keep], cut, spacing)


def _bin_count(span: float, sigma: float, samples: int) -> int:
    """Bins a twelfth of the least bandwidth wide, at least 100, never many more than samples."""
    wished = 12.0 * span / max(LEAST_BANDWIDTH * sigma, 1e-6 * span)
    count = min(max(wished, 100.0), 4000.0, max(samples / 2.0, 8.0))
    # Multiples of powers of two merge well.
    unit = 1 << max(int(np.log2(count)) - 4, 0)
    return int(max(count // unit, 1)) * unit


def _bandwidths(bins: Bins, sigma: float, distance: Floats, normals: int) -> Bandwidths:
    """Least C_p over a geometric range, from eight sigma or eight samples to half the curve."""
    samples = float(bins.count.sum())
    low = max(LEAST_BANDWIDTH * sigma, 8.0 * bins.length / samples, 2.5 * bins.length / len(bins.station))
    high = max(0.5 * bins.length, 1.01 * low)
    candidates = np.geomspace(low, high, max(int(np.log(high / low) / np.log(1.25)) + 1, 2))
    variance = float(np.mean(distance**2)) / normals
    return select_bandwidths(bins, candidates, variance, normals)


def _ends(station: Floats, length: float, sigma: float) -> tuple[float, float]:
    """Where an open curve begins and ends: the mass beyond an end is 0.4 rho sigma."""
    near = max(0.2 * length, 20.0 * sigma)
    if len(station) < 200 or near > 0.5 * length:
        near = length
    return (
        _end(np.sort(station[station <= near]), sigma),
        length - _end(np.sort(length - station[station >= length - near]), sigma),
    )


def _end(ordered: Floats, sigma: float) -> float:
    """Station that leaves 0.4 rho sigma samples before it.

    Noise blurs an end symmetrically: half the density marks it roughly, and samples far
    before that mark belong to something else.
    """
    n = len(ordered)
    if n < 8:
        return float(ordered[0]) if n else 0.0
    # The density beside the end, but clear of its blur.
    first, last = n // 4, max(n // 2, min(n - 1, 10))
    between = ordered[last] - ordered[first]
    density = (last - first) / between if between > 0.0 else n / max(ordered[-1] - ordered[0], 1e-300)
    window = max(2.0 * sigma, 6.0 / density)
    some = np.arange(0, last + 1, max(1, last // 2000))
    inside = np.searchsorted(ordered, ordered[some] + window) - some
    dense = some[inside >= 0.5 * density * window]
    mark = ordered[dense[0]] if len(dense) else ordered[0]
    ordered = ordered[np.searchsorted(ordered, mark - 1.5 * sigma) :]
    beyond = min(END_MASS * density * sigma, 0.25 * len(ordered))
    k = int(beyond)
    previous = ordered[0] - 1.0 / density if k == 0 else ordered[k - 1]
    return float(previous + (beyond - k) * (ordered[k] - previous))


def _evaluate(
    bins: Bins, h: Bandwidths, normals: int, distance: Floats, cut: float, spacing: float | None
) -> tuple[Polyline, float, Floats]:
    """The fitted curve at equidistant stations, its noise and its standard error."""
    fitted = local_fit(bins, bins.station, h)
    spent = float(np.sum(bins.count * fitted.leverage))
    samples = float(bins.count.sum())
    noise = np.sqrt(float(np.sum(distance**2)) / normals / max(samples - spent, 1.0)) / _truncation(
        cut, normals
    )
    count = _vertex_count(bins, fitted, noise, h.inside, spacing)
    pieces = count if bins.closed else count - 1
    at = np.linspace(0.0, bins.length, pieces + 1)[:count]
    fit = local_fit(bins, at, h)
    vertices = fit.value + 0.5 * noise**2 * fit.second
    error = noise * np.sqrt(np.maximum(fit.leverage, 0.0))
    return Polyline(vertices, bins.closed), float(noise), error


def _vertex_count(bins: Bins, fit: Fit, noise: float, h: float, spacing: float | None) -> int:
    """Chords deviate by at most a fifth of the standard error, within 64 to 4000 vertices."""
    if spacing is not None:
        return int(min(max(np.ceil(bins.length / spacing), 3), 1_000_000)) + (0 if bins.closed else 1)
    curvature = float(np.quantile(np.linalg.norm(fit.second, axis=1), 0.95))
    error = noise * np.sqrt(max(float(np.median(fit.leverage)), 0.0))
    chord = np.sqrt(8.0 * 0.2 * max(error, 1e-9 * bins.length) / max(curvature, 1e-9 / bins.length))
    return int(min(max(bins.length / min(chord, 0.25 * h), 64.0), 4000.0))


def _truncation(cut: float, normals: int) -> float:
    """Standard deviation, per direction, of unit Gaussian noise cut at ``cut``."""
    if normals == 1:
        density = np.exp(-0.5 * cut * cut) / np.sqrt(2.0 * np.pi)
        return float(np.sqrt(1.0 - 2.0 * cut * density / erf(cut / np.sqrt(2.0))))
    tail = np.exp(-0.5 * cut * cut)
    return float(np.sqrt(1.0 - 0.5 * cut * cut * tail / (1.0 - tail)))


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
