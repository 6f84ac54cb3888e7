"""The methods, each reading like the paper's own summary of it.

``partition`` (§3.3); ``pca`` (§4.1, 4.2): partition, scale and project on the best plane,
march, join, refine, and back into the user's frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.cloud.frame import is_quasi_planar
from core.cloud.partition import partition as _partition
from core.cloud.points import as_points, distinct
from core.cloud.sampling import Sample, estimate_scale
from core.cloud.working_frame import WorkingFrame, working_frame
from core.errors import DegenerateInput, InvalidParameter
from core.march.chain import chain_neighbours
from core.march.fragments import Fragment, Pace
from core.march.solve import Marched, solve_march
from core.parameters import CommonParameters, PartitionParameters, PcaParameters
from core.refine.principal_curve import CUT, Refined, as_they_are, refine_curves
from core.report import Solved, report
from core.results import Component, Partition, Reconstruction

__all__ = ["partition", "pca"]

Floats = NDArray[np.float64]

LEAST_POINTS = 6
LEAST_EXPLAINED = 0.9  # share of samples on the marched curves, below which neighbours are linked instead
MOST_VERTICES = 1_000_000  # along the diagonal of a component's box
CUTS = {"auto": CUT, "keep": 5.0, "reject": 3.0}  # in sigma


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
    DegenerateInput
        When the points determine no curve.
    """
    points = as_points(points)
    parameters = parameters or PcaParameters()
    _require_enough(points)
    parts = _partition(points, parameters)
    solved = []
    for component in parts.components:
        members = np.flatnonzero(parts.labels == component.label)
        one = _march_component(points[members], members, component, parameters)
        if one is not None:
            solved.append(one)
    if not solved:
        raise DegenerateInput(
            "No curve can be seen in these points: nowhere do enough of them line up. "
            "Give more points, or a larger epsilon.",
            ("points",),
        )
    return report("pca", "the PCA march was asked for", points, parts, solved, stages)


def _require_enough(points: Floats) -> None:
    if (
        len(np.unique(points[: 4 * LEAST_POINTS], axis=0)) < LEAST_POINTS
        and len(np.unique(points, axis=0)) < LEAST_POINTS
    ):
        raise DegenerateInput(
            f"A curve needs at least {LEAST_POINTS} distinct points; there are fewer.", ("points",)
        )


def _march_component(
    points: Floats, members: NDArray[np.int64], component: Component, parameters: PcaParameters
) -> Solved | None:
    """One component from the input frame to refined curves; None where nothing lines up."""
    in_plane = points.shape[1] == 2 or parameters.planar is False or is_quasi_planar(points)
    flat = in_plane if parameters.planar is None else parameters.planar
    marched_in_space = None if in_plane else not flat
    work, frame = working_frame(points, component.frame.axes, flat)
    sample = Sample.of(work)
    cut = CUTS[parameters.outliers]
    spacing = _spacing(parameters, work, frame)
    found = _march(sample, frame, parameters)
    fragments: list[Fragment] = []
    refined: Refined | None = None
    if found is not None:
        marched, sigma = found
        settle = refine_curves if parameters.refine else as_they_are
        refined = settle(sample, marched.curves, sigma, frame.flat, cut, spacing)
        fragments = marched.fragments
        if _strays(refined, work):  # a blob without a course: no fit holds
            refined = as_they_are(sample, marched.curves, sigma, frame.flat, cut, spacing)
            refined = None if _strays(refined, work) else refined
    if refined is None or np.mean(refined.feet.curve >= 0) < LEAST_EXPLAINED:
        chain = chain_neighbours(work)
        if chain is not None:
            refined, fragments = as_they_are(sample, chain, 0.0, frame.flat, cut, spacing), []
    if refined is None:
        return None
    return Solved(component, members, frame, refined, fragments, parameters.outliers, marched_in_space)


def _spacing(parameters: CommonParameters, work: Floats, frame: WorkingFrame) -> float | None:
    """The wished spacing of vertices in working units."""
    if parameters.vertex_spacing is None:
        return None
    diagonal = float(np.linalg.norm(np.ptp(work, axis=0)))
    if parameters.vertex_spacing * MOST_VERTICES < diagonal * frame.scale:
        raise InvalidParameter(
            f"vertex_spacing would make more than {MOST_VERTICES} vertices; give a larger one.",
            ("parameters", "vertex_spacing"),
        )
    return parameters.vertex_spacing / frame.scale


def _strays(refined: Refined, points: Floats) -> bool:
    """Whether a curve leaves the box of its points by more than a quarter of the box."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.25 * float(np.max(high - low))
    return any(np.any((c.vertices < low - room) | (c.vertices > high + room)) for c in refined.curves)


def _march(sample: Sample, frame: WorkingFrame, parameters: PcaParameters) -> tuple[Marched, float] | None:
    """March, and say how much noise was seen; None where no ball or no march is to be had."""
    extent = float(np.sqrt(np.einsum("ij,ij->i", sample.points, sample.points).max()))
    once = distinct(sample.points)  # a ball of repetitions would be a perfect line
    sample = sample if once is sample.points else Sample.of(once)
    scale = estimate_scale(sample, extent, frame.flat) if extent > 0 else None
    if scale is None:
        return None
    pace = Pace(
        scale,
        extent,
        frame.flat,
        radius=(parameters.radius or 0.0) / frame.scale,
        step=(parameters.step or 0.0) / frame.scale,
        max_uses=parameters.max_uses or 0,
        estimator=parameters.estimator,
        seed=parameters.seed,
    )
    marched = solve_march(sample, pace)
    return (marched, scale.sigma) if marched.curves else None
