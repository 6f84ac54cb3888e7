"""The methods, each reading like the paper's own summary of it.

``partition`` (§3.3); ``pca`` (§4.1, 4.2): partition, scale and project on the best plane,
march, join, refine, and back into the user's frame; ``skeleton`` (§4.1, 4.3 - 4.5): the
same, with the tape polygon and its skeleton in place of the march.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.cloud.frame import is_quasi_planar
from core.cloud.partition import partition as _partition
from core.cloud.points import as_points, distinct
from core.cloud.sampling import Sample, Scale, estimate_scale
from core.cloud.working_frame import WorkingFrame, working_frame
from core.errors import DegenerateInput, InvalidParameter
from core.march.chain import chain_neighbours
from core.march.fragments import Pace
from core.march.solve import Marched, solve_march
from core.parameters import CommonParameters, PartitionParameters, PcaParameters, SkeletonParameters
from core.refine.evidence import description_length
from core.refine.polyline import Polyline
from core.refine.principal_curve import CUT, Refined, as_they_are, refine_curves
from core.report import report
from core.results import Component, Partition, Reconstruction
from core.solved import Solved
from core.tape.readings import read_crossings
from core.tape.small_triangles import Smallness
from core.tape.solve import CLEARLY, Choices, Taped, has_no_width, solve_tape

__all__ = ["partition", "pca", "skeleton"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_POINTS = 6
LEAST_EXPLAINED = 0.9  # share of samples on the found curves, below which neighbours are linked instead
MOST_VERTICES = 1_000_000  # along the diagonal of a component's box
CUTS = {"auto": CUT, "keep": 5.0, "reject": 3.0}  # in sigma
TOUCHING = 4.0  # in sigma: a curve that ends this near another ends on it


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
    parts, solved = _solve(points, parameters, lambda one: _march(one, parameters))
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
    parts, solved = _solve(points, parameters, lambda one: _tape(one, parameters))
    return report("skeleton", "the skeleton was asked for", points, parts, solved, stages)


@dataclass(frozen=True, slots=True, eq=False)
class _Prepared:
    """A component in working coordinates (§4.1), and what its samples say of themselves."""

    component: Component
    members: Ints
    frame: WorkingFrame
    sample: Sample
    once: Sample
    scale: Scale | None
    extent: float
    quasi_planar: bool
    parameters: CommonParameters

    @property
    def spacing(self) -> float | None:
        """The wished spacing of vertices in working units."""
        wished = self.parameters.vertex_spacing
        return None if wished is None else wished / self.frame.scale


def _solve(
    points: Floats, parameters: CommonParameters, method: Callable[[_Prepared], Solved | None]
) -> tuple[Partition, list[Solved]]:
    """Partition the points, and solve each component."""
    _require_enough(points)
    parts = _partition(points, parameters)
    solved = []
    for component in parts.components:
        members = np.flatnonzero(parts.labels == component.label)
        one = method(_prepared(points[members], members, component, parameters))
        if one is not None:
            solved.append(one)
    if not solved:
        raise DegenerateInput(
            "No curve can be seen in these points: nowhere do enough of them line up. "
            "Give more points, or a larger epsilon.",
            ("points",),
        )
    return parts, solved


def _require_enough(points: Floats) -> None:
    if (
        len(np.unique(points[: 4 * LEAST_POINTS], axis=0)) < LEAST_POINTS
        and len(np.unique(points, axis=0)) < LEAST_POINTS
    ):
        raise DegenerateInput(
            f"A curve needs at least {LEAST_POINTS} distinct points; there are fewer.", ("points",)
        )


def _prepared(points: Floats, members: Ints, component: Component, parameters: CommonParameters) -> _Prepared:
    planar = parameters.planar if isinstance(parameters, PcaParameters) else True
    in_plane = points.shape[1] == 2 or planar is False or is_quasi_planar(points)
    turned = isinstance(parameters, SkeletonParameters)
    work, frame = working_frame(points, component.frame.axes, in_plane if planar is None else planar, turned)
    _require_room(parameters, work, frame)
    sample = Sample.of(work)
    extent = float(np.sqrt(np.einsum("ij,ij->i", work, work).max()))
    once = distinct(work)  # a ball of repetitions would be a perfect line
    once_sample = sample if once is work else Sample.of(once)
    scale = estimate_scale(once_sample, extent, frame.flat) if extent > 0 else None
    return _Prepared(component, members, frame, sample, once_sample, scale, extent, in_plane, parameters)


def _require_room(parameters: CommonParameters, work: Floats, frame: WorkingFrame) -> None:
    """Refuse a spacing of vertices that no memory could hold."""
    wished = parameters.vertex_spacing
    if wished is None:
        return
    diagonal = float(np.linalg.norm(np.ptp(work, axis=0)))
    if wished * MOST_VERTICES < diagonal * frame.scale:
        raise InvalidParameter(
            f"vertex_spacing would make more than {MOST_VERTICES} vertices; give a larger one.",
            ("parameters", "vertex_spacing"),
        )


def _marched(one: _Prepared, parameters: PcaParameters) -> Marched | None:
    if one.scale is None:
        return None
    pace = Pace(
        one.scale,
        one.extent,
        one.frame.flat,
        radius=(parameters.radius or 0.0) / one.frame.scale,
        step=(parameters.step or 0.0) / one.frame.scale,
        max_uses=parameters.max_uses or 0,
        estimator=parameters.estimator,
        seed=parameters.seed,
    )
    return solve_march(one.once, pace)


def _march(one: _Prepared, parameters: PcaParameters) -> Solved | None:
    """One component by the PCA march (§4.2); None where nothing lines up."""
    marched = _marched(one, parameters)
    refined = _refined(one, marched.curves, one.scale.sigma) if marched and one.scale else None
    if refined is None or _leaves_too_many(refined):
        chain = chain_neighbours(one.sample.points)
        if chain is not None:
            refined, marched = _as_they_are(one, chain, 0.0), None
    return None if refined is None else _solved(one, refined, march=marched)


def _tape(one: _Prepared, parameters: SkeletonParameters) -> Solved | None:
    """One component by the tape polygon and its skeleton (§4.3 - 4.5); None where nothing lines up."""
    taped = None
    if one.scale is not None:
        choices = Choices(
            Smallness(parameters.f_d, parameters.f_a, parameters.f_l),
            parameters.resample / one.frame.scale if parameters.resample else None,
            parameters.prune,
        )
        taped = solve_tape(one.once, one.scale, one.extent, choices)
    refined = _refined(one, taped.curves, taped.sigma) if taped else None
    if refined is None or _leaves_too_many(refined):
        chain = chain_neighbours(one.sample.points)
        if chain is not None and (refined is None or len(chain) <= len(refined.curves)):
            refined = _as_they_are(one, chain, 0.0)
    marched = None
    if refined is None or _leaves_too_many(refined) or (one.scale and has_no_width(one.scale)):
        rival = _march(one, PcaParameters(outliers=parameters.outliers, seed=parameters.seed))
        if rival is not None and (refined is None or _is_better(one, rival.refined, refined)):
            refined, marched = rival.refined, rival.march
    if refined is None:
        return None
    if parameters.crossings != "through":
        read = read_crossings(refined.curves, parameters.crossings, refined.sigma, TOUCHING * refined.sigma)
        refined = replace(_as_they_are(one, read, refined.sigma), sigma=refined.sigma)
    return _solved(one, refined, march=marched, tape=taped)


def _is_better(one: _Prepared, rival: Refined, refined: Refined) -> bool:
    """Whether curves explain the samples clearly better than others."""
    sigma = max(rival.sigma, refined.sigma)
    told, wished = (
        description_length(one.sample.few, each.curves, sigma, one.extent, one.frame.flat)
        for each in (refined, rival)
    )
    return wished < told - CLEARLY


def _solved(
    one: _Prepared, refined: Refined, march: Marched | None = None, tape: Taped | None = None
) -> Solved:
    return Solved(
        component=one.component,
        members=one.members,
        points=one.sample.points,
        frame=one.frame,
        refined=refined,
        outliers=one.parameters.outliers,
        bent=None if one.quasi_planar else "projected" if one.frame.flat else "marched in 3D",
        scale=one.scale,
        march=march,
        tape=tape,
    )


def _refined(one: _Prepared, curves: Sequence[Polyline], sigma: float) -> Refined | None:
    """The common refinement; None where the curves stray from their samples."""
    if not curves:
        return None
    cut = CUTS[one.parameters.outliers]
    settle = refine_curves if one.parameters.refine else as_they_are
    refined = settle(one.sample, curves, sigma, one.frame.flat, cut, one.spacing)
    if not _strays(refined, one.sample.points):
        return refined
    rough = _as_they_are(one, curves, sigma)  # a blob without a course: no fit holds
    return None if _strays(rough, one.sample.points) else rough


def _as_they_are(one: _Prepared, curves: Sequence[Polyline], sigma: float) -> Refined:
    cut = CUTS[one.parameters.outliers]
    return as_they_are(one.sample, curves, sigma, one.frame.flat, cut, one.spacing)


def _leaves_too_many(refined: Refined) -> bool:
    return bool(np.mean(refined.feet.curve >= 0) < LEAST_EXPLAINED)


def _strays(refined: Refined, points: Floats) -> bool:
    """Whether a curve leaves the box of its points by more than a quarter of the box."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.25 * float(np.max(high - low))
    return any(np.any((c.vertices < low - room) | (c.vertices > high + room)) for c in refined.curves)
