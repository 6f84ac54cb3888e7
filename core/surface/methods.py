"""The application of the paper (§5.1.1), each function reading like its steps.

``slices``: range images are triangulated, and all meshes cut by parallel planes; ``contours``:
each slice through the reconstruction of curves, consistent from level to level, incomplete levels
completed; ``surface``: the contours spanned by one closed mesh, which is then measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.division import Division
from core.errors import DegenerateInput, InvalidInput, InvalidParameter
from core.progress import Progress, tell, within
from core.results import Warn
from core.surface import levelwise, stack
from core.surface.axis import axis_frame
from core.surface.draft import is_clean
from core.surface.indicator import Indicator, indicator_of
from core.surface.levelwise import Drafts, Levels, Shown
from core.surface.parameters import ContourParameters, SliceParameters, SurfaceParameters
from core.surface.residual import rms_residual
from core.surface.results import ContourLevel, Contours, Mesh, Scans, Slice, Slices, Surface
from core.surface.skin import surface_of

__all__ = ["CONTOURS", "SURFACE", "contours", "slices", "surface"]

Floats = NDArray[np.float64]

CUT, CONTOURED, SKINNED = 0.05, 0.85, 0.97  # fractions of the whole after which a step is done


def slices(
    scans: Scans, parameters: SliceParameters | None = None, *, progress: Progress | None = None
) -> Slices:
    """Cut meshes and range images by parallel planes (§5.1.1, steps i and ii).

    Parameters
    ----------
    scans : Scans
        Meshes, range images, or both.
    parameters : SliceParameters, optional
    progress : Progress, optional
        Told how far it has come.

    Returns
    -------
    Slices
        One for each plane, by height; a plane that cuts nothing has an empty one.

    Raises
    ------
    InvalidInput
        When slices or contours are given, or coordinates beyond 1e60.
    DegenerateInput
        When there is no triangle, or no plane cuts any.
    """
    parameters = parameters or SliceParameters()
    kind = stack.given(scans)
    if kind in {"slices", "contours"}:
        raise InvalidInput(f"There is nothing to slice in {kind}; give meshes or range images.", (kind,))
    found = _sliced(scans, parameters, progress).slices
    tell(progress, 1.0, "done")
    return Slices(_axis(parameters), found)


def contours(
    scans: Scans, parameters: ContourParameters | None = None, *, progress: Progress | None = None
) -> Contours:
    """Reconstruct the closed contours of each slice (§5.1.1, step iii).

    Parameters
    ----------
    scans : Scans
        Slices; or meshes and range images, which are sliced first.
    parameters : ContourParameters, optional
        With slices, of the placement of planes only ``axis`` may be given.
    progress : Progress, optional
        Told how far it has come.

    Returns
    -------
    Contours
        Incomplete levels are completed from their neighbours, unless ``complete`` is false.

    Raises
    ------
    InvalidInput
        When contours are given, two slices have one height, or coordinates are beyond 1e60.
    InvalidParameter
        When slices are given, and heights as well.
    DegenerateInput
        When there is no sample at any level.
    """
    parameters = parameters or ContourParameters()
    return _contours(scans, parameters, None, progress)


def surface(
    scans: Scans,
    parameters: SurfaceParameters | None = None,
    *,
    slices: bool = False,
    progress: Progress | None = None,
) -> Surface:
    """Make one closed surface of scans (§5.1.1).

    Parameters
    ----------
    scans : Scans
        Meshes and range images; or slices; or contours, which are taken as they are.
    parameters : SurfaceParameters, optional
        With slices and contours, of the placement of planes only ``axis`` may be given.
    slices : bool
        Whether the result shall hold the contours.
    progress : Progress, optional
        Told how far it has come.

    Returns
    -------
    Surface
        Its report is computed from the mesh.

    Raises
    ------
    InvalidInput
        When two levels have one height, or coordinates are beyond 1e60.
    InvalidParameter
        When slices or contours are given, and heights as well.
    DegenerateInput
        With fewer than two levels, or when nothing is enclosed.
    """
    return _surface(scans, parameters or SurfaceParameters(), None, slices, progress)


def _contours(
    scans: Scans, parameters: ContourParameters, drafts: Sequence[Drafts] | None, progress: Progress | None
) -> Contours:
    """Contours, with what has been found of each level elsewhere."""
    _refuse_contours(scans)
    found = _sliced(scans, parameters, within(progress, 0.0, CUT))
    shown = found.guessed(parameters)
    told = within(progress, CUT, 1.0)
    levels = levelwise.contour_levels(found.slices, parameters, shown, told, drafts)
    return Contours(_axis(parameters), levels, _warnings(levels))


def _surface(
    scans: Scans,
    parameters: SurfaceParameters,
    drafts: Sequence[Drafts] | None,
    slices: bool,
    progress: Progress | None,
) -> Surface:
    """One surface, with what has been found of each level elsewhere."""
    kind = stack.given(scans)
    if kind == "contours":
        points, levels, indicator = np.zeros((0, 3)), stack.given_contours(scans, parameters), None
    else:
        found = _sliced(scans, parameters, within(progress, 0.0, CUT))
        _require_two(found.slices, parameters, kind)
        points, indicator = found.points, found.indicator(parameters)
        shown, told = found.shown(indicator), within(progress, CUT, CONTOURED)
        levels = levelwise.contour_levels(found.slices, parameters, shown, told, drafts)
    tell(progress, CONTOURED, "spanning the surface")
    made = _spanned(levels, parameters, kind, indicator)
    tell(progress, SKINNED, "measuring the surface")
    report = replace(made.report, rms_residual=rms_residual(points, made.mesh))
    warnings = (*_warnings(levels), *made.warnings)
    tell(progress, 1.0, "done")
    return Surface(made.mesh, report, made.slices if slices else (), warnings, _axis(parameters))


def _spanned(
    levels: Sequence[ContourLevel], parameters: SurfaceParameters, kind: str, indicator: Indicator | None
) -> Surface:
    """Span contours; errors name what was given."""
    try:
        return surface_of(levels, parameters, None if indicator is None else indicator.crossings)
    except InvalidParameter:
        raise
    except InvalidInput as error:
        raise type(error)(error.message, (kind,), error.kind) from None


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """Slices by height, and the meshes that were cut; none where slices were given."""

    slices: tuple[Slice, ...]
    meshes: tuple[Mesh, ...] = ()

    @property
    def points(self) -> Floats:
        """The scan points, (N, 3)."""
        of = [one.vertices for one in self.meshes] or [one.points for one in self.slices]
        return np.concatenate(of)

    def indicator(self, parameters: SliceParameters) -> Indicator | None:
        """What all meshes show together, if anything."""
        return indicator_of(self.meshes, axis_frame(parameters.axis))

    @property
    def is_clean(self) -> bool:
        """Whether the slices are contours already."""
        return all(is_clean(one) for one in self.slices)

    def shown(self, indicator: Indicator | None) -> Shown | None:
        """About where the contours run that have to be found."""
        if indicator is None or self.is_clean:
            return None
        return tuple(tuple(indicator.loops(one.height)) for one in self.slices)

    def guessed(self, parameters: SliceParameters) -> Shown | None:
        """The same, where nothing else is asked of the indicator."""
        return None if self.is_clean else self.shown(self.indicator(parameters))


def _sliced(scans: Scans, parameters: SliceParameters, progress: Progress | None) -> _Cut:
    """Return the slices, those given or those of the meshes and range images."""
    if stack.given(scans) == "slices":
        return _Cut(stack.cut(scans, parameters, ()))
    tell(progress, 0.0, "triangulating range images")
    meshes = stack.meshes_of(scans)
    tell(progress, 0.5, "slicing")
    return _Cut(stack.cut(scans, parameters, meshes), meshes)


def _require_two(found: Sequence[Slice], parameters: SurfaceParameters, kind: str) -> None:
    if len(found) < 2:
        where = next(
            (("parameters", name) for name in ("levels", "heights") if getattr(parameters, name)), (kind,)
        )
        raise DegenerateInput("A surface needs at least two levels.", where)


def _refuse_contours(scans: Scans) -> None:
    if stack.given(scans) == "contours":
        raise InvalidInput("These are contours already; give slices, meshes or range images.", ("contours",))


def _warnings(levels: Sequence[ContourLevel]) -> tuple[Warn, ...]:
    return tuple(warning for level in levels for warning in level.warnings)


def _axis(parameters: SliceParameters) -> Floats:
    axis: Floats = axis_frame(parameters.axis).axes[2]
    return axis


# --- in parts ----------------------------------------------------------------------------------------


def _split(scans: Scans, parameters: ContourParameters) -> tuple[Levels, ...]:
    if stack.given(scans) == "contours":
        return ()
    found = _sliced(scans, parameters, None)
    return levelwise.parts_of(found.slices, parameters, found.guessed(parameters))


def _joined_contours(
    scans: Scans,
    parameters: ContourParameters,
    solved: Sequence[Drafts],
    *,
    progress: Progress | None = None,
) -> Contours:
    return _contours(scans, parameters, solved, progress)


def _joined_surface(
    scans: Scans,
    parameters: SurfaceParameters,
    solved: Sequence[Drafts],
    *,
    slices: bool = False,
    progress: Progress | None = None,
) -> Surface:
    return _surface(scans, parameters, solved, slices, progress)


CONTOURS = Division(_split, levelwise.solve, _joined_contours)
"""`contours` in parts: groups of levels."""

SURFACE = Division(_split, levelwise.solve, _joined_surface)
"""`surface` in parts: groups of levels."""
