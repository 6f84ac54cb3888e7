"""From refined curves in working frames to the answer in the user's frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from core.cloud.points import LARGEST
from core.diagnosis.sampling import sampling_of, verdict_of
from core.march.strip import N_ALL
from core.march.walk import RADIUS
from core.refine.crossings import Meeting, crossings
from core.refine.shares import noise_at
from core.refine.uncertainty import with_plane
from core.results import (
    Ball,
    Crossing,
    Curve,
    Diagnosis,
    Evidence,
    Partition,
    Reconstruction,
    SkeletonStages,
    Stages,
    Warn,
)
from core.skeleton_report import containment_of, graph_of, skeleton_stages, skeleton_warnings, tape_of
from core.solved import Solved

__all__ = ["diagnosis_of", "report"]

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

STRICT = 3.0  # in sigma: what "reject" leaves out
HARDLY = 5.0  # nats that hardly tell one result from another
BLUR = 3.0  # in sigma: how far beyond a junction an end may go


def report(
    method: str, reason: str, points: Floats, parts: Partition, solved: Sequence[Solved], stages: bool
) -> Reconstruction:
    """Assemble the answer.

    Parameters
    ----------
    method, reason : str
    points : (N, d) array
    parts : Partition
    solved : sequence of Solved
    stages : bool
        Whether to add the intermediate results.
    """
    found = _assembled(points, parts, solved)
    taped = any(one.tape is not None for one in solved) or method == "skeleton"
    decisions, alternatives = _evidence(solved)
    return Reconstruction(
        method=method,
        reason=reason,
        curves=found.curves,
        crossings=found.crossings,
        outliers=found.outliers,
        sampling=sampling_of(found.curves, solved, parts),
        frames=tuple(one.component.frame for one in solved),
        warnings=_warnings(method, parts, solved),
        tape=tape_of(solved) if taped else None,
        containment=containment_of(solved) if taped else None,
        graph=graph_of(solved) if taped else None,
        decisions=decisions or None,
        alternatives=alternatives if decisions else None,
        stages=_stages(method, solved) if stages else None,
        labels=found.labels,
    )


def diagnosis_of(
    method: str, reason: str, points: Floats, parts: Partition, solved: Sequence[Solved]
) -> Diagnosis:
    """Assemble what is known of the samples, without the curves.

    Parameters
    ----------
    method, reason : str
    points : (N, d) array
    parts : Partition
    solved : sequence of Solved
    """
    found = _assembled(points, parts, solved)
    sampling = sampling_of(found.curves, solved, parts)
    decisions, alternatives = _evidence(solved)
    return Diagnosis(
        method=method,
        reason=reason,
        verdict=verdict_of(sampling),
        curves=len(found.curves),
        closed=sum(curve.closed for curve in found.curves),
        crossings=len(found.crossings),
        outliers=found.outliers,
        sampling=sampling,
        frames=tuple(one.component.frame for one in solved),
        decisions=decisions,
        alternatives=alternatives,
        warnings=_warnings(method, parts, solved),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Assembled:
    """Curves of all components together; ``labels`` is the curve of each point, -1 for none."""

    curves: tuple[Curve, ...]
    crossings: tuple[Crossing, ...]
    outliers: Ints
    labels: Ints


def _assembled(points: Floats, parts: Partition, solved: Sequence[Solved]) -> _Assembled:
    curves: list[Curve] = []
    meetings: list[Crossing] = []
    labels = np.full(len(points), -1, np.int64)
    outside = ~np.isin(parts.labels, [one.component.label for one in solved])
    for one in solved:
        first = len(curves)
        own, far = _samples(one, len(points))
        labels[one.members] = np.where(own >= 0, own + first, -1)
        outside[one.members[far]] = True
        curves += _curves(one, own)
        meetings += _crossings(one, first)
    return _Assembled(tuple(curves), tuple(meetings), np.flatnonzero(outside), labels)


def _evidence(solved: Sequence[Solved]) -> tuple[tuple[Evidence, ...], tuple[Evidence, ...]]:
    """Evidence for what was chosen, and for what was not."""
    chosen = tuple(one.evidence[0] for one in solved if one.evidence)
    return chosen, tuple(each for one in solved for each in one.evidence[1:])


def _samples(one: Solved, total: int) -> tuple[Ints, NDArray[np.bool_]]:
    """The curve of each sample (-1: none), and which samples the noise does not explain."""
    feet, sigma = one.refined.feet, one.refined.sigma
    if one.outliers == "keep":
        return feet.curve, np.zeros(len(feet.curve), np.bool_)
    # One Gaussian cloud of this size in twenty has a sample farther out.
    limit = STRICT if one.outliers == "reject" else float(norm.isf(0.025 / max(total, 2)))
    noise = noise_at(feet.curve, feet.station, one.refined.sigmas, one.refined.noises or None)
    noise = np.where(feet.curve >= 0, np.maximum(noise, 1e-12), max(sigma, 1e-12))
    far = ~(feet.distance <= limit * noise)
    return np.where(far, -1, feet.curve), far


def _curves(one: Solved, own: Ints) -> list[Curve]:
    out = []
    for k, line in enumerate(one.refined.curves):
        distance = one.refined.feet.distance[own == k]
        distance = distance[np.isfinite(distance)]
        residual = float(np.sqrt(np.mean(distance**2))) if len(distance) else 0.0
        out.append(
            Curve(
                vertices=one.frame.restore(line.vertices),
                closed=line.closed,
                component=one.component.label,
                length=min(line.length * one.frame.scale, LARGEST),
                samples=len(distance),
                rms_residual=min(residual * one.frame.scale, LARGEST),
                standard_errors=_in_units(_errors(one, k), one.frame.scale),
            )
        )
    return out


def _errors(one: Solved, k: int) -> Floats:
    """Standard errors of a curve; in space those of the plane that it was projected on join them."""
    errors = one.refined.errors[k]
    if one.frame.dimension == 2 or not one.frame.flat:
        return errors
    return with_plane(errors, one.refined.curves[k].vertices, one.points, one.refined.sigma)


def _in_units(errors: Floats, scale: float) -> Floats | None:
    """Standard errors in the user's units; None where a stretch of the curve has no fit."""
    with np.errstate(over="ignore"):
        return None if np.isnan(errors).any() else np.minimum(errors * scale, LARGEST)


def _crossings(one: Solved, first: int) -> list[Crossing]:
    if not one.frame.flat:
        return []
    return [
        Crossing(one.frame.restore(m.place[None])[0], (m.curves[0] + first, m.curves[1] + first), m.angle)
        for m in crossings(one.refined.curves)
        if not _ends_there(one, m)
    ]


def _ends_there(one: Solved, meeting: Meeting) -> bool:
    """Whether a curve ends on another rather than crosses it: the noise blurs how far it goes."""
    for k, station in zip(meeting.curves, meeting.stations, strict=True):
        line = one.refined.curves[k]
        if not line.closed and min(station, line.length - station) < BLUR * one.refined.sigma:
            return True
    return False


def _warnings(method: str, parts: Partition, solved: Sequence[Solved]) -> tuple[Warn, ...]:
    asked = method == "skeleton" and all(one.method is None for one in solved)
    out = list(parts.warnings)
    for one in solved:
        if one.bent is not None:
            message = f"Component {one.component.label} does not lie in a plane; it was {one.bent}."
            out.append(Warn("not-quasi-planar", message, tuple(one.component.frame.origin.tolist())))
        out += _disagreement(one)
    return (*out, *skeleton_warnings(solved, asked))


def _disagreement(one: Solved) -> list[Warn]:
    """Say where the samples hardly tell which of two results is right."""
    if len(one.evidence) < 2 or one.evidence[1].nats > HARDLY:
        return []
    chosen, other = one.evidence[:2]
    if (chosen.curves, chosen.closed, chosen.crossings) == (other.curves, other.closed, other.crossings):
        return []
    message = (
        f"The methods find different curves in component {one.component.label}, and the samples hardly tell "
        "which are right; more samples or less noise would. See alternatives."
    )
    origin = one.component.frame.origin[: one.frame.dimension]
    return [Warn("methods-disagree", message, tuple(origin.tolist()))]


def _stages(method: str, solved: Sequence[Solved]) -> Stages | SkeletonStages:
    if method == "skeleton":
        return skeleton_stages(solved)
    balls, courses = [], []
    for one in solved:
        for fragment in one.march.fragments if one.march else ():
            places = one.frame.restore(fragment.centres)
            courses.append(places)
            tips = one.frame.restore(fragment.centres + fragment.nodes[:, 3:6])
            for node, place, tip in zip(fragment.nodes, places, tips, strict=True):
                balls.append(
                    Ball(place, float(node[RADIUS]) * one.frame.scale, (tip - place) / one.frame.scale,
                         int(node[N_ALL]), one.component.label)
                )  # fmt: skip
    return Stages(tuple(balls), tuple(courses))
