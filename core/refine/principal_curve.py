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
from core.refine.corners import find_corners
from core.refine.course import Rules, fit_course
from core.refine.ends import ends_of, prolonged
from core.refine.pieces import fit_pieces
from core.refine.polyline import Polyline
from core.refine.project import Feet, project
from core.refine.regression import Bandwidths

__all__ = ["CUT", "Refined", "as_they_are", "refine_curves"]

Floats = NDArray[np.float64]

CUT = 4.0  # in sigma: farther samples take no part
SEEN = 6.0  # in sigma: farther samples have no foot in the end
PROLONGED = 3.0  # in sigma: how far an open curve may grow in one pass
LEAST_SAMPLES = 8
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
    corners: bool = True,
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
    corners : bool
        Whether to keep corners sharp.
    """
    rules = Rules(1 if flat else 2, cut, None)
    states = [_State(line, sigma, np.zeros(len(line.vertices)), None) for line in curves]
    for _ in range(passes):
        states = _one_pass(sample.few, states, rules)
    states = _one_pass(sample.points, states, replace(rules, spacing=spacing))
    if corners:
        states = _with_corners(sample, states, replace(rules, spacing=spacing))
    lines = [state.line for state in states]
    sigmas = np.array([state.sigma for state in states])
    feet = project(sample.points, lines, _reach(sigmas, max(cut, SEEN)))
    return Refined(tuple(lines), feet, _noise(feet, sigmas), sigmas, tuple(state.error for state in states))


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """A curve between passes: course, noise, standard error at its vertices, last bandwidths."""

    line: Polyline
    sigma: float
    error: Floats
    bandwidths: Bandwidths | None


def _reach(sigmas: Floats, cut: float) -> float:
    return max(float(sigmas.max()) * cut, 1e-9)


def _one_pass(samples: Floats, states: list[_State], rules: Rules) -> list[_State]:
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


def _with_corners(sample: Sample, states: list[_State], rules: Rules) -> list[_State]:
    """Find the corners of every curve with a few samples, and fit the pieces between them with all."""
    found = [
        find_corners(sample.few[mine], station, state.line, state.sigma)
        for state, (mine, station) in zip(states, _own_samples(sample.few, states, rules), strict=True)
    ]
    if not any(found):
        return states
    out = list(states)
    for k, (mine, _) in enumerate(_own_samples(sample.points, states, rules)):
        if found[k]:
            line, error = fit_pieces(sample.points[mine], states[k].line, found[k], states[k].sigma, rules)
            out[k] = replace(states[k], line=line, error=error)
    return out


def _own_samples(
    samples: Floats, states: list[_State], rules: Rules
) -> list[tuple[NDArray[np.int64], Floats]]:
    """Indices of each curve's samples and the stations of their feet."""
    sigmas = np.array([state.sigma for state in states])
    feet = project(samples, [state.line for state in states], _reach(sigmas, rules.cut))
    groups = _groups(feet.curve, feet.curve >= 0, len(states))
    return [(mine, feet.station[mine]) for mine in groups]


def _groups(curve: NDArray[np.int64], near: NDArray[np.bool_], count: int) -> list[NDArray[np.int64]]:
    """Indices of the near samples of each curve."""
    if count == 1:
        return [np.flatnonzero(near)]
    order = np.argsort(curve, kind="stable")
    order = order[near[order]]
    bounds = np.searchsorted(curve[order], np.arange(count + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(count)]


def _refit(points: Floats, station: Floats, distance: Floats, state: _State, rules: Rules) -> _State:
    """Regress one curve on the arc length of its samples' feet."""
    line, sigma = state.line, state.sigma
    stay = replace(state, error=np.zeros(len(line.vertices)))
    if len(points) < LEAST_SAMPLES:
        return stay
    low, high = (0.0, line.length) if line.closed else ends_of(station, line.length, sigma)
    span = high - low
    keep = np.ones(len(points), np.bool_) if line.closed else (station >= low) & (station <= high)
    if span <= 0.0 or np.count_nonzero(keep) < LEAST_SAMPLES:
        return stay
    course = fit_course(
        points[keep], station[keep] - low, distance[keep], span, line.closed, sigma, rules, state.bandwidths
    )
    fitted = Polyline(course.vertices, line.closed)
    if _has_run_away(fitted, line, max(rules.cut * sigma, 0.05 * span)):
        return stay
    return _State(fitted, course.noise, course.error, course.bandwidths)


def _has_run_away(line: Polyline, last: Polyline, reach: float) -> bool:
    """Whether a fit left the last course: a polynomial that too few samples hold may go anywhere."""
    if not np.all(np.isfinite(line.vertices)):
        return True
    return bool(np.any(project(line.vertices, [last], reach).curve < 0))


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
