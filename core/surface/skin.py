"""From contours to one closed surface, by slabs or, should they fail or so be wished, by distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from core.errors import DegenerateInput
from core.results import Warn
from core.surface.axis import axis_frame
from core.surface.distance_field import mesh_of_distances
from core.surface.heights import Passes
from core.surface.mesh_report import is_sound, report_of
from core.surface.noding import Unsettled, noded
from core.surface.overlay import slab_ends
from core.surface.parameters import SurfaceParameters
from core.surface.regions import Regions, regions_of
from core.surface.results import ContourLevel, Mesh, Surface, SurfaceReport
from core.surface.similarity import gated
from core.surface.slabs import mesh_of_slabs

__all__ = ["surface_of"]

Floats = NDArray[np.float64]

ATTEMPTS = 4  # at signed distances: each fails about once in sixty on the hardest stacks


def surface_of(
    levels: Sequence[ContourLevel],
    parameters: SurfaceParameters | None = None,
    passes: Passes | None = None,
) -> Surface:
    """One closed, oriented 2-manifold through the contours of parallel planes (§5.1.1).

    Parameters
    ----------
    levels : sequence of ContourLevel
        At different heights, in any order; a level without contours is empty space. Curves have
        (M, 2) vertices in the planes' axes, or (M, 3) in place.
    parameters : SurfaceParameters
        Its axis is that along which heights are measured.
    passes : Passes, optional
        How high the surface is between levels, where that is known; in the frame of the axis.

    Returns
    -------
    Surface
        The mesh in place; its report is computed from the mesh.

    Raises
    ------
    InvalidInput
        Two levels of one height, or numbers too large to be computed with.
    DegenerateInput
        Fewer than two levels, or nothing enclosed.
    """
    parameters = parameters or SurfaceParameters()
    axes = axis_frame(parameters.axis).axes
    regions = regions_of(levels, axes)
    mesh, report, warnings = _skin(regions, parameters, axes, passes)
    completed = tuple(sorted(level.height for level in levels if level.completed))
    report = replace(report, completed_levels=completed)
    return Surface(mesh, report, tuple(levels), (*regions.warnings, *warnings))


def _skin(
    regions: Regions, parameters: SurfaceParameters, axes: Floats, passes: Passes | None
) -> tuple[Mesh, SurfaceReport, tuple[Warn, ...]]:
    """The first sound mesh, else the last one with what is wrong with it.

    On a coarser grid, what rounding upset on the finest one mostly settles.
    """
    grids = (
        [] if parameters.method == "distance" else [regions, regions.coarser(), regions.coarser().coarser()]
    )
    for each in grids:
        made = _by_slabs(each, parameters.similarity, passes)
        if made is not None:
            mesh = _placed(made, axes)
            report = report_of(mesh, "slabs")
            if is_sound(report):
                return mesh, report, ()
    for attempt in range(ATTEMPTS):
        mesh = _placed(mesh_of_distances(regions, attempt), axes)
        report = report_of(mesh, "distance")
        if is_sound(report):
            break
    warnings = _complaints(report)
    if parameters.method != "distance":
        message = "Slabs gave no closed surface here; signed distances were interpolated instead."
        warnings = (Warn("distance-instead", message), *warnings)
    return mesh, report, warnings


def _by_slabs(regions: Regions, similarity: float, passes: Passes | None) -> Mesh | None:
    """The mesh of slabs; None when rounding to the grid does not settle."""
    heights = regions.heights
    try:
        lines = noded(regions.lines)
        if similarity > 0.0:
            lines = noded(gated(lines, len(heights), similarity), reach=2)
            heights = np.insert(heights, np.arange(1, len(heights)), (heights[1:] + heights[:-1]) / 2.0)
    except Unsettled:
        return None
    if not len(lines):
        raise DegenerateInput("The contours enclose nothing.", ("contours",))
    ends = slab_ends(lines, heights, 2 if similarity > 0.0 else 1)
    return mesh_of_slabs(lines, ends, regions.grid, passes)


def _placed(mesh: Mesh, axes: Floats) -> Mesh:
    """The mesh in place, from the frame of the levels; exactly, for the axes of the coordinates."""
    return mesh if np.array_equal(axes, np.eye(3)) else Mesh(mesh.vertices @ axes, mesh.faces)


def _complaints(report: SurfaceReport) -> tuple[Warn, ...]:
    if is_sound(report):
        return ()
    return (
        Warn("surface-unsound", "The surface is not closed, not a manifold, or cuts itself: see the report."),
    )
