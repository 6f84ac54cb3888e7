"""The methods, each reading like the paper's own summary of it.

``partition`` (§3.3); ``pca`` (§4.1, 4.2): partition, scale and project on the best plane,
march, join, refine, and back into the user's frame; ``skeleton`` (§4.1, 4.3 - 4.5): the
same, with the tape polygon and its skeleton in place of the march; ``reconstruct``: the one of
both that explains the samples better, component by component; ``diagnose``: what ``reconstruct``
learns about the samples, without the last pass over all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.arbiter import arbitrated, overall
from core.candidates import Candidate, by_march, by_neighbours, by_tape, crossings_read
from core.cloud.partition import partition as _partition
from core.cloud.points import as_points
from core.errors import DegenerateInput
from core.parameters import (
    CommonParameters,
    PartitionParameters,
    PcaParameters,
    ReconstructParameters,
    SkeletonParameters,
)
from core.prepared import Prepared, prepared
from core.refine.blobs import is_blob
from core.refine.evidence import description_length
from core.report import diagnosis_of, report
from core.results import Diagnosis, Partition, Reconstruction
from core.solved import Solved
from core.tape.solve import CLEARLY, has_no_width

__all__ = ["diagnose", "partition", "pca", "reconstruct", "skeleton"]

Floats = NDArray[np.float64]

LEAST_POINTS = 6


def partition(points: ArrayLike, parameters: PartitionParameters | None = None) -> Partition:
    """Partition a point set into extended neighbours (§3.3).

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
    parameters : PartitionParameters, optional

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    """
    return _partition(as_points(points), parameters or PartitionParameters())


def pca(
    points: ArrayLike, parameters: PcaParameters | None = None, *, stages: bool = False
) -> Reconstruction:
    """Reconstruct curves by the PCA march (§4.2).

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
        Noisy, unorganised samples of one or several curves.
    parameters : PcaParameters, optional
        By default everything follows from the data.
    stages : bool
        Whether to return the balls and the raw march as well.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    points, parameters = as_points(points), parameters or PcaParameters()
    parts, solved = _solve(points, parameters, lambda one: _marched(one, parameters))
    return report("pca", "the PCA march was asked for", points, parts, solved, stages)


def skeleton(
    points: ArrayLike, parameters: SkeletonParameters | None = None, *, stages: bool = False
) -> Reconstruction:
    """Reconstruct curves by the tape polygon and its skeleton (§4.3 - 4.5).

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
        Noisy, unorganised samples of one or several curves, which may cross.
    parameters : SkeletonParameters, optional
        By default everything follows from the data.
    stages : bool
        Whether to return triangles, border and raw skeleton as well (Figs. 5 and 10).

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    points, parameters = as_points(points), parameters or SkeletonParameters()
    parts, solved = _solve(points, parameters, lambda one: _taped(one, parameters))
    return report("skeleton", "the skeleton was asked for", points, parts, solved, stages)


def reconstruct(
    points: ArrayLike, parameters: ReconstructParameters | None = None, *, stages: bool = False
) -> Reconstruction:
    """Reconstruct curves by the method that each component calls for.

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
        Noisy, unorganised samples of one or several curves, which may cross.
    parameters : ReconstructParameters, optional
        By default everything follows from the data.
    stages : bool
        Whether to return the intermediate results of the answer's ``method`` as well.

    Returns
    -------
    Reconstruction
        With ``decisions``, why each component got its curves, and ``alternatives``, what the
        other method would have given.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    points, parameters = as_points(points), parameters or ReconstructParameters()
    parts, solved = _solve(points, parameters, lambda one: arbitrated(one, parameters))
    method, reason = overall(solved)
    return report(method, reason, points, parts, solved, stages)


def diagnose(points: ArrayLike, parameters: ReconstructParameters | None = None) -> Diagnosis:
    """Tell noise, density and Nyquist compliance of a point set (§1), and which method it calls for.

    Curves are found as in :func:`reconstruct`, but refined with at most 20 000 samples of each component.

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
    parameters : ReconstructParameters, optional

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    points, parameters = as_points(points), parameters or ReconstructParameters()
    parts, solved = _solve(points, parameters, lambda one: arbitrated(replace(one, hasty=True), parameters))
    method, reason = overall(solved)
    return diagnosis_of(method, reason, points, parts, solved)


def _solve(
    points: Floats, parameters: CommonParameters, method: Callable[[Prepared], Solved | None]
) -> tuple[Partition, list[Solved]]:
    """Partition the points, and solve each component."""
    _require_enough(points)
    parts = _partition(points, parameters)
    solved = []
    for component in parts.components:
        members = np.flatnonzero(parts.labels == component.label)
        one = method(prepared(points[members], members, component, parameters))
        if one is not None:
            solved.append(one)
    if not solved:
        raise DegenerateInput(
            "No curve can be seen in these points: nowhere do enough of them line up. "
            "Give more points, or a larger epsilon.",
            ("points",),
        )
    return parts, _without_clumps(solved)


def _without_clumps(solved: list[Solved]) -> list[Solved]:
    """Leave out components that are but clumps of outliers, unless all are: their samples are outliers."""
    clump = [
        all(is_blob(one.points, line, one.refined.sigma, one.frame.flat) for line in one.refined.curves)
        for one in solved
    ]
    if all(clump):
        return solved
    return [one for one, left_out in zip(solved, clump, strict=True) if not left_out]


def _require_enough(points: Floats) -> None:
    if (
        len(np.unique(points[: 4 * LEAST_POINTS], axis=0)) < LEAST_POINTS
        and len(np.unique(points, axis=0)) < LEAST_POINTS
    ):
        raise DegenerateInput(
            f"A curve needs at least {LEAST_POINTS} distinct points; there are fewer.", ("points",)
        )


def _marched(one: Prepared, parameters: PcaParameters) -> Solved | None:
    """One component by the PCA march; linked neighbours where it leaves too many samples."""
    candidate = by_march(one, parameters)
    if candidate is None or candidate.leaves_too_many:
        candidate = by_neighbours(one) or candidate
    return None if candidate is None else candidate.solved(one)


def _taped(one: Prepared, parameters: SkeletonParameters) -> Solved | None:
    """One component by its skeleton; the march stands in where there is no tape, or hardly one."""
    candidate = by_tape(one, parameters)
    tape = candidate.tape if candidate else None
    if candidate is None or candidate.leaves_too_many:
        linked = by_neighbours(one)
        if linked is not None and (
            candidate is None or len(linked.refined.curves) <= len(candidate.refined.curves)
        ):
            candidate = linked
    if candidate is None or candidate.leaves_too_many or (one.scale and has_no_width(one.scale)):
        rival = by_march(one, PcaParameters(outliers=parameters.outliers, seed=parameters.seed))
        if rival is not None and (candidate is None or _is_better(one, rival, candidate)):
            candidate = rival
    if candidate is None:
        return None
    return replace(crossings_read(one, candidate, parameters.crossings).solved(one), tape=tape)


def _is_better(one: Prepared, rival: Candidate, candidate: Candidate) -> bool:
    """Whether curves explain the samples clearly better than others."""
    sigma = max(rival.refined.sigma, candidate.refined.sigma)
    told, wished = (
        description_length(one.sample.few, each.refined.curves, sigma, one.extent, one.frame.flat)
        for each in (candidate, rival)
    )
    return wished < told - CLEARLY
