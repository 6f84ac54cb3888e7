"""The sampling block: what the data say of themselves, in the user's units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.points import LARGEST
from core.cloud.working_frame import WorkingFrame
from core.diagnosis.across import Across, samples_across
from core.diagnosis.branches import LEAST_GAP
from core.diagnosis.facing import facing_ends
from core.diagnosis.neighbours import approaches
from core.diagnosis.noise import noise_along, noise_error
from core.diagnosis.nyquist import Findings, findings_of
from core.diagnosis.verdict import verdict_of
from core.diagnosis.wording import facing, near
from core.refine.polyline import Polyline
from core.results import (
    ComponentSampling,
    Curve,
    CurveGap,
    Nyquist,
    Partition,
    Sampling,
    SigmaAlong,
    Violation,
)
from core.solved import Solved

__all__ = ["sampling_of", "verdict_of"]

Floats = NDArray[np.float64]

PLACES = 65  # of one curve at which its noise is told


def sampling_of(curves: Sequence[Curve], solved: Sequence[Solved], parts: Partition) -> Sampling:
    """Tell noise, density, gaps and Nyquist compliance.

    Parameters
    ----------
    curves : sequence of Curve
        Of all components, in the user's frame.
    solved : sequence of Solved
        The components.
    parts : Partition
    """
    across = [_across(one) for one in solved]
    total = sum(len(each.stations) for samples in across for each in samples)
    findings = [findings_of(one, samples, total) for one, samples in zip(solved, across, strict=True)]
    components = _components(curves, solved, across)
    sigma, error = _together(components)
    return Sampling(
        sigma=sigma,
        density=_density(curves),
        epsilon=parts.epsilon,
        nyquist=_nyquist(findings, _Together.of(solved, across), total),
        sigma_error=error,
        sigma_along=tuple(_sigma_along(solved, across)),
        largest_gap=_largest_gap(solved, across, findings),
        components=components,
    )


def _across(one: Solved) -> list[Across]:
    refined = one.refined
    return samples_across(
        one.points,
        refined.curves,
        refined.feet,
        refined.sigmas,
        one.frame.flat,
        one.frame.axes[:, : one.frame.dimension],
    )


def _density(curves: Sequence[Curve]) -> float:
    """Samples a unit of length; of coordinates near the smallest doubles more than doubles can say."""
    samples, length = sum(c.samples for c in curves), sum(c.length for c in curves)
    return min(samples / length, LARGEST) if length > 0 else 0.0


def _components(
    curves: Sequence[Curve], solved: Sequence[Solved], across: Sequence[Sequence[Across]]
) -> tuple[ComponentSampling, ...]:
    out = []
    for one, samples in zip(solved, across, strict=True):
        label = one.component.label
        error = noise_error(one.refined, samples, 1 if one.frame.flat else 2)
        out.append(
            ComponentSampling(
                label=label,
                size=len(one.members),
                sigma=min(one.refined.sigma * one.frame.scale, LARGEST),
                sigma_error=None if error is None else min(error * one.frame.scale, LARGEST),
                density=_density([curve for curve in curves if curve.component == label]),
            )
        )
    return tuple(out)


def _together(components: Sequence[ComponentSampling]) -> tuple[float, float | None]:
    """Noise of all components, the mean variance weighted by samples, and its standard error."""
    weight = np.array([one.size for one in components], np.float64)
    weight /= weight.sum()
    sigmas = np.array([one.sigma for one in components])
    largest = max(float(sigmas.max()), float(np.finfo(np.float64).tiny))  # squares of huge ones overflow
    sigmas = sigmas / largest
    sigma = float(np.sqrt(np.sum(weight * sigmas**2)))
    if sigma == 0.0 or any(one.sigma_error is None for one in components):
        return sigma * largest, None
    errors = np.array([one.sigma_error or 0.0 for one in components]) / largest
    error = float(np.sqrt(np.sum((weight * sigmas * errors) ** 2))) / sigma
    return sigma * largest, min(error * largest, LARGEST)


@dataclass(frozen=True, slots=True, eq=False)
class _Together:
    """The curves of all components in the working frame of the largest one."""

    frame: WorkingFrame
    lines: list[Polyline]
    counts: list[int]
    groups: list[int]
    sigmas: list[float]

    @classmethod
    def of(cls, solved: Sequence[Solved], across: Sequence[Sequence[Across]]) -> _Together:
        frame = max(solved, key=lambda one: len(one.members)).frame
        together = cls(frame, [], [], [], [])
        for k, (one, samples) in enumerate(zip(solved, across, strict=True)):
            for each in samples:
                places = frame.way.apply(one.frame.restore(each.line.vertices))
                flat = np.pad(places, ((0, 0), (0, 3 - places.shape[1])))
                together.lines.append(Polyline(flat, each.line.closed))
                together.counts.append(len(each.stations))
                together.groups.append(k)
                together.sigmas.append(one.refined.sigma * (one.frame.scale / frame.scale))
        return together

    def place(self, x: Floats) -> Floats:
        """(d,) user's coordinates of a place (3,)."""
        return np.asarray(self.frame.way.restore(x[None, : self.frame.dimension])[0])

    def near(self) -> list[Findings]:
        """Components that come near each other."""
        out = []
        for each in approaches(self.lines, self.groups, self.sigmas):
            place, gap, sigma = self.place(each.place), each.gap, each.sigma
            told = [near(place, gap, sigma, self.frame.scale)] if gap < LEAST_GAP * sigma else []
            out.append(Findings(tuple(told), gap / sigma, place))
        return out

    def faced(self, total: int) -> tuple[Violation, ...]:
        """Ends of curves of any components that face each other over a gap."""
        sigma = max(self.sigmas, default=0.0)
        return tuple(
            facing(
                self.place(each.place),
                min(each.gap / sigma, LARGEST) if sigma > 1e-300 else LARGEST,
                min(each.gap * self.frame.scale, LARGEST),
                each.spacings,
                each.expected,
            )
            for each in facing_ends(self.lines, self.counts, sigma, total)
        )


def _nyquist(findings: Sequence[Findings], together: _Together, total: int) -> Nyquist:
    """The least distance between branches, and every place where the samples do not suffice."""
    findings = [*findings, *together.near(), Findings(together.faced(total))]
    violations = sorted((v for one in findings for v in one.violations), key=lambda v: v.gap_sigmas)
    near = [one for one in findings if one.margin is not None]
    if not near:
        return Nyquist(not violations, None, tuple(violations))
    least = min(near, key=lambda one: one.margin or 0.0)
    return Nyquist(not violations, least.margin, tuple(violations), least.margin_location)


def _sigma_along(solved: Sequence[Solved], across: Sequence[Sequence[Across]]) -> list[SigmaAlong]:
    out, first = [], 0
    for one, samples in zip(solved, across, strict=True):
        for k, each in enumerate(samples):
            found = noise_along(each, 1 if one.frame.flat else 2)
            if found is not None:
                at = np.linspace(0.0, each.line.length, PLACES, endpoint=not each.line.closed)
                with np.errstate(over="ignore"):
                    sigma = np.minimum(found.at(at) * one.frame.scale, LARGEST)
                out.append(SigmaAlong(first + k, one.frame.restore(each.line.at(at)), sigma))
        first += len(samples)
    return out


def _largest_gap(
    solved: Sequence[Solved], across: Sequence[Sequence[Across]], findings: Sequence[Findings]
) -> CurveGap | None:
    best: CurveGap | None = None
    first = 0
    for one, samples, found in zip(solved, across, findings, strict=True):
        if found.gap is not None and (best is None or found.gap[1].spacings > best.spacings):
            k, gap = found.gap
            place = one.frame.restore(samples[k].line.at(np.array([gap.middle])))[0]
            length = min(gap.length * one.frame.scale, LARGEST)
            best = CurveGap(place, first + k, length, gap.spacings, gap.expected)
        first += len(samples)
    return best
