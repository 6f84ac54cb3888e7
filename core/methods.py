"""The methods, each reading like the paper's own summary of it.

``partition`` (§3.3); ``pca`` (§4.1, 4.2): partition, scale and project on the best plane,
march, join, refine, and back into the user's frame; ``skeleton`` (§4.1, 4.3 - 4.5): the
same, with the tape polygon and its skeleton in place of the march; ``reconstruct``: the one of
both that explains the samples better, component by component; ``diagnose``: what ``reconstruct``
learns about the samples, without the last pass over all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.arbiter import arbitrated, overall
from core.candidates import Candidate, by_march, by_neighbours, by_tape, crossings_read
from core.cloud.partition import partition as _partition
from core.cloud.points import as_points
from core.componentwise import Componentwise
from core.parameters import (
    PartitionParameters,
    PcaParameters,
    ReconstructParameters,
    SkeletonParameters,
)
from core.prepared import Prepared
from core.progress import Progress, tell, within
from core.refine.evidence import description_length
from core.report import diagnosis_of, report
from core.results import Diagnosis, Partition, Reconstruction
from core.solved import Solved
from core.tape.solve import CLEARLY, has_no_width

__all__ = ["diagnose", "partition", "pca", "reconstruct", "skeleton"]

Floats = NDArray[np.float64]

TAPED = 0.7  # fraction of the skeleton's work after which it is weighed against the march


def partition(
    points: ArrayLike, parameters: PartitionParameters | None = None, *, progress: Progress | None = None
) -> Partition:
    """Partition a point set into extended neighbours (§3.3).

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
    parameters : PartitionParameters, optional
    progress : Progress, optional
        Told how far it has come.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    """
    tell(progress, 0.0, "partitioning")
    parts = _partition(as_points(points), parameters or PartitionParameters())
    tell(progress, 1.0, "done")
    return parts


def pca(
    points: ArrayLike,
    parameters: PcaParameters | None = None,
    *,
    stages: bool = False,
    progress: Progress | None = None,
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
    progress : Progress, optional
        Told how far it has come.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    return PCA(points, parameters, stages=stages, progress=progress)


def skeleton(
    points: ArrayLike,
    parameters: SkeletonParameters | None = None,
    *,
    stages: bool = False,
    progress: Progress | None = None,
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
    progress : Progress, optional
        Told how far it has come.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    return SKELETON(points, parameters, stages=stages, progress=progress)


def reconstruct(
    points: ArrayLike,
    parameters: ReconstructParameters | None = None,
    *,
    stages: bool = False,
    progress: Progress | None = None,
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
    progress : Progress, optional
        Told how far it has come.

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
    return RECONSTRUCT(points, parameters, stages=stages, progress=progress)


def diagnose(
    points: ArrayLike, parameters: ReconstructParameters | None = None, *, progress: Progress | None = None
) -> Diagnosis:
    """Tell noise, density and Nyquist compliance of a point set (§1), and which method it calls for.

    Curves are found as in :func:`reconstruct`, but refined with at most 20 000 samples of each component.

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
    parameters : ReconstructParameters, optional
    progress : Progress, optional
        Told how far it has come.

    Raises
    ------
    InvalidPoints
        When the shape, the type or a value is wrong.
    InvalidParameter
        When a length is out of all proportion to the points.
    DegenerateInput
        When the points determine no curve.
    """
    return DIAGNOSE(points, parameters, progress=progress)


def _marched(one: Prepared, parameters: PcaParameters, progress: Progress | None) -> Solved | None:
    """One component by the PCA march; linked neighbours where it leaves too many samples."""
    candidate = by_march(one, parameters, progress=progress)
    if candidate is None or candidate.leaves_too_many:
        candidate = by_neighbours(one) or candidate
    return None if candidate is None else candidate.solved(one)


def _taped(one: Prepared, parameters: SkeletonParameters, progress: Progress | None) -> Solved | None:
    """One component by its skeleton; the march stands in where there is no tape, or hardly one."""
    candidate = by_tape(one, parameters, progress=within(progress, 0.0, TAPED))
    tape = candidate.tape if candidate else None
    if candidate is None or candidate.leaves_too_many:
        linked = by_neighbours(one)
        if linked is not None and (
            candidate is None or len(linked.refined.curves) <= len(candidate.refined.curves)
        ):
            candidate = linked
    if candidate is None or candidate.leaves_too_many or (one.scale and has_no_width(one.scale)):
        asked = PcaParameters(outliers=parameters.outliers, seed=parameters.seed)
        rival = by_march(one, asked, progress=within(progress, TAPED, 1.0))
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


def _hastily(one: Prepared, parameters: ReconstructParameters, progress: Progress | None) -> Solved | None:
    """One component by either method, refined with a part of its samples."""
    return arbitrated(replace(one, hasty=True), parameters, progress)


def _marches(
    points: Floats, parts: Partition, solved: Sequence[Solved], *, stages: bool = False
) -> Reconstruction:
    return report("pca", "the PCA march was asked for", points, parts, solved, stages)


def _skeletons(
    points: Floats, parts: Partition, solved: Sequence[Solved], *, stages: bool = False
) -> Reconstruction:
    return report("skeleton", "the skeleton was asked for", points, parts, solved, stages)


def _chosen(
    points: Floats, parts: Partition, solved: Sequence[Solved], *, stages: bool = False
) -> Reconstruction:
    method, reason = overall(solved)
    return report(method, reason, points, parts, solved, stages)


def _diagnosed(points: Floats, parts: Partition, solved: Sequence[Solved]) -> Diagnosis:
    method, reason = overall(solved)
    return diagnosis_of(method, reason, points, parts, solved)


PCA = Componentwise(PcaParameters, _marched, _marches)
SKELETON = Componentwise(SkeletonParameters, _taped, _skeletons)
RECONSTRUCT = Componentwise(ReconstructParameters, arbitrated, _chosen)
DIAGNOSE = Componentwise(ReconstructParameters, _hastily, _diagnosed)
