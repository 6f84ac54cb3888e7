"""From refined curves in working frames to the answer in the user's frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from core.march.strip import N_ALL
from core.march.walk import RADIUS
from core.nyquist import LEAST_GAP, branch_gaps
from core.refine.crossings import Meeting, crossings
from core.results import (
    Ball,
    Crossing,
    Curve,
    Nyquist,
    Partition,
    Reconstruction,
    Sampling,
    SkeletonStages,
    Stages,
    Violation,
    Warn,
)
from core.skeleton_report import containment_of, graph_of, skeleton_stages, skeleton_warnings, tape_of
from core.solved import Solved

__all__ = ["report"]

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

STRICT = 3.0  # in sigma: what "reject" leaves out
BLUR = 3.0  # in sigma: how far beyond a junction an end may go
LARGEST = float(np.finfo(np.float64).max)  # lengths beyond it cannot be said


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
    return Reconstruction(
        method=method,
        reason=reason,
        curves=tuple(curves),
        crossings=tuple(meetings),
        outliers=np.flatnonzero(outside),
        sampling=_sampling(curves, solved, parts),
        frames=tuple(one.component.frame for one in solved),
        warnings=(
            *parts.warnings,
            *_warnings(solved),
            *(skeleton_warnings(solved) if method == "skeleton" else []),
        ),
        tape=tape_of(solved) if method == "skeleton" else None,
        containment=containment_of(solved) if method == "skeleton" else None,
        graph=graph_of(solved) if method == "skeleton" else None,
        stages=_stages(method, solved) if stages else None,
        labels=labels,
    )


def _samples(one: Solved, total: int) -> tuple[Ints, NDArray[np.bool_]]:
    """The curve of each sample (-1: none), and which samples the noise does not explain."""
    feet, sigma = one.refined.feet, one.refined.sigma
    if one.outliers == "keep":
        return feet.curve, np.zeros(len(feet.curve), np.bool_)
    # One Gaussian cloud of this size in twenty has a sample farther out.
    limit = STRICT if one.outliers == "reject" else float(norm.isf(0.025 / max(total, 2)))
    far = ~(feet.distance <= limit * max(sigma, 1e-12))
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
            )
        )
    return out


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


def _sampling(curves: Sequence[Curve], solved: Sequence[Solved], parts: Partition) -> Sampling:
    samples = sum(c.samples for c in curves)
    length = sum(c.length for c in curves)
    weights = np.array([len(one.members) for one in solved], np.float64)
    sigmas = np.array([one.refined.sigma * one.frame.scale for one in solved])
    largest = max(float(sigmas.max()), float(np.finfo(np.float64).tiny))  # squares of huge ones overflow
    sigma = largest * float(np.sqrt(np.average((sigmas / largest) ** 2, weights=weights)))
    # Of coordinates near the smallest doubles there are more samples a unit than doubles can say.
    density = min(samples / length, LARGEST) if length > 0 else 0.0
    return Sampling(sigma, density, parts.epsilon, _nyquist(solved))


def _nyquist(solved: Sequence[Solved]) -> Nyquist:
    """The least distance between branches, and every place where it is too small."""
    violations: list[Violation] = []
    margin: float | None = None
    for one in solved:
        sigma = one.refined.sigma
        meetings = crossings(one.refined.curves) if one.frame.flat else []
        for place, gap in branch_gaps(one.refined.curves, sigma):
            if any(np.linalg.norm(m.place - place) < 12.0 * sigma + 2.0 * gap for m in meetings):
                continue
            sigmas = gap / sigma
            margin = sigmas if margin is None else min(margin, sigmas)
            if sigmas < LEAST_GAP:
                location = one.frame.restore(place[None])[0]
                reason = (
                    f"two branches only {sigmas:.1f} sigma apart: noise must stay below half of the detail"
                )
                violations.append(Violation(location, float(sigmas), reason))
    return Nyquist(not violations, margin, tuple(violations))


def _warnings(solved: Sequence[Solved]) -> list[Warn]:
    out = []
    for one in solved:
        if one.bent is not None:
            message = f"Component {one.component.label} does not lie in a plane; it was {one.bent}."
            origin = one.component.frame.origin
            out.append(Warn("not-quasi-planar", message, tuple(float(x) for x in origin)))
    return out


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
