"""Refinement: each curve becomes the local regression of its samples (Hastie & Stuetzle 1989).

Averages of samples with a common foot lie outside a bend, by kappa sigma^2 / 2: isotropic
noise meets more curve length inside than outside. The second derivative of the fit gives
that bias, and it is taken out; more samples would never do so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.refine.branches import Branches, near_branches
from core.refine.corners import find_corners
from core.refine.course import Rules, fit_course
from core.refine.ends import ends_of, prolonged
from core.refine.junctions import meeting
from core.refine.local_noise import LocalNoise
from core.refine.noise import mean_square
from core.refine.pieces import Cornered, cornered, fit_pieces
from core.refine.polyline import Polyline
from core.refine.project import Feet, project
from core.refine.regression import Bandwidths
from core.refine.shares import Share, groups_of, shares_of
from core.refine.uncertainty import sigma_error

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
        Pointwise standard error at the vertices, normal to the curve; NaN where no fit holds it.
    sigma_errors : (C,) array
        Standard error of each of the sigmas; empty where nobody asked.
    noises : tuple of LocalNoise
        Noise along each curve; empty where it is taken for the same everywhere.
    """

    curves: tuple[Polyline, ...]
    feet: Feet
    sigma: float
    sigmas: Floats
    errors: tuple[Floats, ...]
    sigma_errors: Floats = field(default_factory=lambda: np.zeros(0))
    noises: tuple[LocalNoise, ...] = ()


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
    rules = Rules(1 if flat else 2, cut, None, final=False)
    states = [_State(line, line, sigma, np.nan, _unknown(line), None) for line in curves]
    for _ in range(passes):
        states = _one_pass(sample.few, states, rules)
    rules = replace(rules, spacing=spacing, final=True)
    states = _one_pass(sample.points, states, rules)
    if corners:
        states = _with_corners(sample, states, rules)
    lines = [state.line for state in states]
    sigmas = np.array([state.sigma for state in states])
    noises = tuple(state.noise(0.0, state.line.length) for state in states)
    largest = np.array([noise.largest for noise in noises])
    feet = project(sample.points, lines, _reach(largest, max(cut, SEEN)))
    return Refined(
        curves=tuple(lines),
        feet=feet,
        sigma=_noise(feet, sigmas),
        sigmas=sigmas,
        errors=tuple(state.error for state in states),
        sigma_errors=np.array([state.sigma_error for state in states]),
        noises=noises,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """A curve between passes: course and noise with their standard errors, last bandwidths.

    ``wide`` is the course as windows of eight sigma show it, which round corners off alike; ``along``
    the noise where it varies.
    """

    line: Polyline
    wide: Polyline
    sigma: float
    sigma_error: float
    error: Floats
    bandwidths: Bandwidths | None
    along: LocalNoise | None = None

    def noise(self, low: float, high: float) -> LocalNoise:
        """Noise between two stations; beyond the curve's ends theirs goes on."""
        if self.along is None or not self.along.varies:
            return LocalNoise.constant(self.sigma, high - low)
        return self.along.stretched(self.line.length).between(low, high)


def _unknown(line: Polyline) -> Floats:
    """No standard error at a curve's vertices."""
    return np.full(len(line.vertices), np.nan)


def _reach(sigmas: Floats, cut: float) -> float:
    return max(float(sigmas.max()) * cut, 1e-9)


def _one_pass(samples: Floats, states: list[_State], rules: Rules) -> list[_State]:
    """Project all samples, and refit every curve to its own."""
    sigmas = np.array([state.sigma for state in states])
    lines = [prolonged(state.line, PROLONGED * state.sigma) for state in states]
    before = [0.0 if state.line.closed else PROLONGED * state.sigma for state in states]
    along = [
        state.noise(-by, line.length - by) for state, line, by in zip(states, lines, before, strict=True)
    ]
    largest = np.array([noise.largest for noise in along])
    feet = project(samples, lines, _reach(largest, rules.cut))
    branches = near_branches(lines, largest, rules.cut)
    ends = np.array([_ends(state.line, PROLONGED * state.sigma) for state in states])
    shares = shares_of(samples, feet, sigmas, rules.cut, branches, ends, rules.normals, along)
    out = []
    for k, (share, state, line) in enumerate(zip(shares, states, lines, strict=True)):
        span = 0.0, line.length
        if not line.closed and len(share.index):
            span = ends_of(share.station, line.length, state.sigma, share.weight)
            if branches is not None:
                span = _held(line, k, span, branches, ends)
        out.append(_refit(samples, share, span, replace(state, line=line, along=along[k]), rules))
    return out


def _held(
    line: Polyline, k: int, span: tuple[float, float], branches: Branches, ends: Floats
) -> tuple[float, float]:
    """Ends of a curve, those that stop on another branch being there."""
    low, high = (meeting(line, k, station, branches, ends) for station in span)
    return span[0] if low is None else low, span[1] if high is None else high


def _ends(line: Polyline, by: float) -> tuple[float, float]:
    """Stations of a curve's ends once it is prolonged."""
    return (-np.inf, np.inf) if line.closed else (by, by + line.length)


def _with_corners(sample: Sample, states: list[_State], rules: Rules) -> list[_State]:
    """Find the corners of every curve with a few samples, and fit the pieces between them with all."""
    smooth, states = states, [replace(state, line=state.wide) for state in states]
    found = [
        find_corners(sample.few[mine], station, state.line, state.sigma)
        for state, (mine, station) in zip(states, _own_samples(sample.few, states, rules), strict=True)
    ]
    if not any(found):
        return smooth
    sharp = [
        cornered(state.line, corners) if corners else None
        for state, corners in zip(states, found, strict=True)
    ]
    shares = _shares_of_pieces(sample.points, states, sharp, rules)
    out = list(smooth)
    for k, (state, curve, share) in enumerate(zip(states, sharp, shares, strict=True)):
        if curve is not None:
            line, error = fit_pieces(sample.points, share, curve, state.sigma, rules)
            out[k] = replace(state, line=line, error=error)
    return out


def _shares_of_pieces(
    samples: Floats, states: list[_State], sharp: list[Cornered | None], rules: Rules
) -> list[Share]:
    """Each curve's samples with their feet on it once its corners are sharp."""
    sigmas = np.array([state.sigma for state in states])
    lines = [state.line if curve is None else curve.line for state, curve in zip(states, sharp, strict=True)]
    branches = near_branches(lines, sigmas, rules.cut)
    if branches is None:
        own = _own_samples(samples, states, rules)
        return [
            _on_one(samples, mine, line, float(sigma), rules)
            for (mine, _), line, sigma in zip(own, lines, sigmas, strict=True)
        ]
    feet = project(samples, lines, _reach(sigmas, rules.cut))
    ends = np.array([_ends(line, 0.0) for line in lines])
    return shares_of(samples, feet, sigmas, rules.cut, branches, ends, rules.normals)


def _on_one(samples: Floats, mine: NDArray[np.int64], line: Polyline, sigma: float, rules: Rules) -> Share:
    """A curve's samples with their feet on it, whatever else is near."""
    feet = project(samples[mine], [line], rules.cut * sigma)
    near = feet.curve == 0
    return Share(mine[near], feet.station[near], feet.distance[near], None)


def _own_samples(
    samples: Floats, states: list[_State], rules: Rules
) -> list[tuple[NDArray[np.int64], Floats]]:
    """Indices of each curve's samples and the stations of their feet."""
    sigmas = np.array([state.sigma for state in states])
    feet = project(samples, [state.line for state in states], _reach(sigmas, rules.cut))
    return [(mine, feet.station[mine]) for mine in groups_of(feet.curve, feet.curve >= 0, len(states))]


def _refit(samples: Floats, share: Share, span: tuple[float, float], state: _State, rules: Rules) -> _State:
    """Regress one curve, between two stations, on the arc length of its samples' feet."""
    line, sigma = state.line, state.sigma
    stay = replace(state, wide=line, error=_unknown(line))
    low, high = span
    if share.mass < LEAST_SAMPLES:
        return stay
    if not line.closed:
        share = share.only((share.station >= low) & (share.station <= high))
    if high <= low or share.mass < LEAST_SAMPLES:
        return stay
    along = state.noise(low, high)
    course = fit_course(
        samples[share.index], share.station - low, share.distance, high - low, line.closed, sigma, rules,
        state.bandwidths, share.weight, along,
    )  # fmt: skip
    fitted = Polyline(course.vertices, line.closed)
    if _has_run_away(fitted, line, max(rules.cut * along.largest, 0.05 * (high - low))):
        return stay
    wide = fitted if course.wide is course.vertices else Polyline(course.wide, line.closed)
    return _State(
        fitted, wide, course.noise, course.noise_error, course.error, course.bandwidths, course.along
    )


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
    normals = 1 if flat else 2
    given = np.full(len(lines), sigma)
    branches = near_branches(lines, given, cut)
    groups = groups_of(feet.curve, feet.curve >= 0, len(lines))
    shares = [Share(mine, feet.station[mine], feet.distance[mine], None) for mine in groups]
    if branches is not None:
        ends = np.array([_ends(line, 0.0) for line in lines])
        shares = shares_of(sample.points, feet, given, cut, branches, ends, normals)
    sigmas = np.array([_spread(share, sigma, normals) for share in shares])
    errors = tuple(_unknown(line) for line in lines)
    sigma_errors = np.array(
        [
            sigma_error(share.distance, share.weight, 0.0, float(own), normals)
            for share, own in zip(shares, sigmas, strict=True)
        ]
    )
    return Refined(tuple(lines), feet, _noise(feet, sigmas), sigmas, errors, sigma_errors)


def _spread(share: Share, sigma: float, normals: int) -> float:
    """Noise about one curve from its samples' distances."""
    return float(np.sqrt(mean_square(share.distance, share.weight) / normals)) if share.mass else sigma
