"""Stacks of slices, whose contours are sought level by level: here and at once, or in parts anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.division import Part, balanced
from core.errors import DegenerateInput, InvalidInput, InvalidParameter
from core.progress import Progress, tell, within
from core.results import Curve
from core.surface.axis import AxisFrame, axis_frame
from core.surface.contours import consistent
from core.surface.draft import Draft
from core.surface.drafts import GROUP, drafts_of
from core.surface.parameters import ContourParameters, SliceParameters
from core.surface.range_image import triangulate
from core.surface.results import ContourLevel, Mesh, Scans, Slice
from core.surface.slicing import slices_of

__all__ = [
    "Drafts",
    "Levels",
    "contour_levels",
    "cut",
    "given",
    "given_contours",
    "meshes_of",
    "parts_of",
    "solve",
]

Floats = NDArray[np.float64]
Drafts = tuple[tuple[int, Draft], ...]
"""Contours of some levels, each with its place in the stack."""

KINDS = ("meshes", "range_images", "slices", "contours")
PLACES = ("levels", "spacing", "heights")
LARGEST = 1e60  # beyond it, or its inverse, products of coordinates leave the range of numbers
RESOLVED = 1e-9  # of the extent: levels closer to each other are one
BASE = 3000.0  # samples that take as long as what every level takes
CLEAN = 100.0  # what a level of closed polylines takes, in samples
DRAFTED = 0.9  # fraction of the work after which every level has been looked at alone


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Consecutive slices whose contours are sought together; ``first`` is the place of the first one."""

    first: int
    slices: tuple[Slice, ...]

    @property
    def work(self) -> float:
        """What it costs, in samples."""
        return sum(_work(one) for one in self.slices)


@dataclass(frozen=True, slots=True, eq=False)
class Levels(Part):
    """Groups of slices of a stack of ``count``."""

    axis: tuple[float, float, float]
    groups: tuple[Group, ...]
    count: int


def given(scans: Scans) -> str:
    """Name what was given.

    Raises
    ------
    InvalidInput
        When there is nothing, or slices or contours beside anything else.
    """
    names = [name for name in KINDS if getattr(scans, name)]
    if not names:
        raise InvalidInput(f"There is nothing to work on; give one of {', '.join(KINDS)}.", ())
    if len(names) > 1 and names != ["meshes", "range_images"]:
        message = "Give meshes and range images, or slices, or contours, but not several of them."
        raise InvalidInput(message, (names[-1],))
    return names[0]


def meshes_of(scans: Scans) -> tuple[Mesh, ...]:
    """Return the meshes and those of the range images, in place.

    Raises
    ------
    InvalidInput
        For coordinates that are too large, or range images of which nothing is left.
    """
    for name, arrays in (
        ("meshes", [one.vertices for one in scans.meshes]),
        ("range_images", [one.points for one in scans.range_images]),
    ):
        for k, array in enumerate(arrays):
            _check_size(array, (name, k))
    _check_extent([one.vertices for one in scans.meshes], "meshes")
    _check_extent([one.points.reshape(-1, 3) for one in scans.range_images], "range_images")
    seen = tuple(triangulate(image) for image in scans.range_images)
    if not any(len(mesh.faces) for mesh in (*scans.meshes, *seen)):
        where = "range_images" if seen else "meshes"
        raise DegenerateInput("No three neighbouring samples make a triangle.", (where,))
    return (*scans.meshes, *seen)


def cut(scans: Scans, parameters: SliceParameters, meshes: Sequence[Mesh]) -> tuple[Slice, ...]:
    """Return slices in place, by height: those given, or those of the meshes.

    Raises
    ------
    InvalidInput
        For two slices of one height, or coordinates that are too large.
    InvalidParameter
        When slices are given, which have their heights, and heights as well.
    DegenerateInput
        When no plane cuts anything.
    """
    if scans.slices:
        _refuse_heights(parameters)
        found = _placed(scans.slices, axis_frame(parameters.axis))
    else:
        found = slices_of(meshes, parameters)
    if not any(len(one.points) for one in found):
        where = ("slices",) if scans.slices else _where(parameters, given(scans))
        raise DegenerateInput("No plane cuts anything: there is no sample at any level.", where)
    return found


def _where(parameters: SliceParameters, kind: str) -> tuple[str, ...]:
    """Return the place of what decided about the planes."""
    name = next((name for name in PLACES if getattr(parameters, name) is not None), None)
    return (kind,) if name is None else ("parameters", name)


def _refuse_heights(parameters: SliceParameters) -> None:
    """Refuse parameters that place planes where levels have their heights already."""
    for name in PLACES:
        if getattr(parameters, name) is not None:
            raise InvalidParameter("The levels that are given have their heights.", ("parameters", name))


def given_contours(scans: Scans, parameters: SliceParameters) -> tuple[ContourLevel, ...]:
    """Return the contours that are given in place, by height.

    Raises
    ------
    InvalidInput
        For two levels of one height, or coordinates that are too large.
    InvalidParameter
        When heights are given as well.
    """
    _refuse_heights(parameters)
    for k, level in enumerate(scans.contours):
        for j, curve in enumerate(level.curves):
            _check_size(curve.vertices, ("contours", k, "curves", j))
    heights = [one.height for one in scans.contours]
    _check_heights(heights, "contours")
    frame = axis_frame(parameters.axis)
    curves = [curve.vertices for level in scans.contours for curve in level.curves]
    _check_planes(curves, heights, frame, "contours")
    levels = [
        replace(level, curves=tuple(_in_place(curve, level.height, frame) for curve in level.curves))
        for level in scans.contours
    ]
    return tuple(sorted(levels, key=lambda one: one.height))


def _in_place(curve: Curve, height: float, frame: AxisFrame) -> Curve:
    return replace(curve, vertices=_lifted(curve.vertices, height, frame))


def _check_heights(heights: Sequence[float], kind: str) -> None:
    """Refuse levels of one height."""
    for k, one in enumerate(heights):
        _check_size(np.array([one]), (kind, k, "height"))
    order = np.argsort(heights, kind="stable")
    ascending = np.asarray(heights)[order]
    same = np.flatnonzero(np.diff(ascending) <= RESOLVED * (ascending[-1] - ascending[0]))
    if len(same):
        place = int(max(order[same[0]], order[same[0] + 1]))
        raise InvalidInput("Levels must have different heights.", (kind, place, "height"))


def _placed(slices: Sequence[Slice], frame: AxisFrame) -> tuple[Slice, ...]:
    """Return slices by height, with points in place; those off their plane are projected on it."""
    for k, one in enumerate(slices):
        _check_size(one.points, ("slices", k, "points"))
    heights = [one.height for one in slices]
    _check_heights(heights, "slices")
    _check_planes([one.points for one in slices], heights, frame, "slices")
    ascending = sorted(slices, key=lambda one: one.height)
    return tuple(replace(one, points=_lifted(one.points, one.height, frame)) for one in ascending)


def _lifted(points: Floats, height: float, frame: AxisFrame) -> Floats:
    """Return points in place that are given in the plane's axes, or in space: those are projected."""
    return frame.lift(frame.to_plane(points) if points.shape[1] == 3 else points, height)


def _check_planes(arrays: Sequence[Floats], heights: Sequence[float], frame: AxisFrame, kind: str) -> None:
    """Refuse levels that are far higher above each other than they are wide, or far too close together."""
    _check_extent([frame.lift(np.zeros((1, 2)), height) for height in heights] + list(arrays), kind)
    flat = [frame.to_plane(one) if one.shape[1] == 3 else one for one in arrays if len(one)]
    if flat and _extent(flat) < RESOLVED * (max(heights) - min(heights)):
        raise DegenerateInput("The levels are points, as far apart as they are.", (kind,))


def _check_extent(arrays: Sequence[Floats], kind: str) -> None:
    """Refuse what is too small to be computed with."""
    some = [one if one.shape[1] == 3 else np.pad(one, ((0, 0), (0, 1))) for one in arrays if len(one)]
    if not some:
        return
    extent, largest = _extent(some), max(float(np.nanmax(np.abs(one), initial=0.0)) for one in some)
    if not extent > max(1.0 / LARGEST, RESOLVED * largest):
        message = "All points coincide, or nearly so for how far from the origin they lie."
        raise DegenerateInput(message, (kind,))


def _extent(arrays: Sequence[Floats]) -> float:
    """Return the longest edge of the box around points; holes do not count."""
    finite = [one[np.isfinite(one).all(axis=1)] for one in arrays]
    low = np.array([one.min(axis=0) for one in finite if len(one)])
    high = np.array([one.max(axis=0) for one in finite if len(one)])
    return float((high.max(axis=0) - low.min(axis=0)).max()) if len(low) else np.inf


def _check_size(array: Floats, where: tuple[str | int, ...]) -> None:
    if len(array) and not np.nanmax(np.abs(array), initial=0.0) < LARGEST:
        raise InvalidInput("Coordinates must be smaller than 1e60.", where)


# --- contours, level by level ------------------------------------------------------------------------


def contour_levels(
    slices: Sequence[Slice],
    parameters: ContourParameters,
    progress: Progress | None = None,
    drafts: Sequence[Drafts] | None = None,
) -> tuple[ContourLevel, ...]:
    """Return the contours of slices, consistent with each other.

    Parameters
    ----------
    slices : sequence of Slice
        By height.
    parameters : ContourParameters
    progress : Progress, optional
    drafts : sequence of Drafts, optional
        What has been found elsewhere, each level once, in any order; sought here by default.
    """
    start = 0.0
    if drafts is None:
        start = DRAFTED
        told = within(progress, 0.0, start)
        drafts = [tuple(_drafted(_groups(slices), len(slices), parameters, told))]
    together = sorted((one for part in drafts for one in part), key=lambda one: one[0])
    return consistent(
        slices, [draft for _, draft in together], parameters, progress=within(progress, start, 1.0)
    )


def parts_of(slices: Sequence[Slice], parameters: ContourParameters) -> tuple[Levels, ...]:
    """Gather levels into parts that take about as long as one another; none where it is not worth it."""
    groups = _groups(slices)
    work = [one.work for one in groups]
    return tuple(
        Levels(
            name=_named([groups[k] for k in part], len(slices)),
            work=sum(work[k] for k in part),
            axis=parameters.axis,
            groups=tuple(groups[k] for k in part),
            count=len(slices),
        )
        for part in balanced(work)
    )


def solve(part: Levels, progress: Progress | None) -> Drafts:
    """Find the contours of some levels, group by group."""
    solved = tuple(_drafted(part.groups, part.count, ContourParameters(axis=part.axis), progress))
    tell(progress, 1.0, "done")
    return solved


def _groups(slices: Sequence[Slice]) -> list[Group]:
    """Cut a stack into groups, which are the same whoever solves them."""
    return [Group(first, tuple(slices[first : first + GROUP])) for first in range(0, len(slices), GROUP)]


def _drafted(
    groups: Sequence[Group], count: int, parameters: ContourParameters, progress: Progress | None
) -> Iterator[tuple[int, Draft]]:
    """Find the contours of groups one after the other."""
    frame = axis_frame(parameters.axis)
    shares = np.cumsum([0.0, *(one.work for one in groups)]).tolist()
    for k, one in enumerate(groups):
        own = within(progress, shares[k] / shares[-1], shares[k + 1] / shares[-1])
        yield from enumerate(drafts_of(one.slices, frame, progress=_worded(own, one, count)), one.first)


def _worded(progress: Progress | None, group: Group, count: int) -> Progress | None:
    """Tell which slice of the stack is worked on, by the fraction of a group that is done."""
    if progress is None:
        return None

    def told(fraction: float, _: str) -> None:
        done = min(round(fraction * len(group.slices)), len(group.slices) - 1)
        progress(fraction, f"slice {group.first + done + 1} of {count}")

    return told


def _work(one: Slice) -> float:
    """What finding the contours of a slice costs, in samples."""
    clean = not len(one.points) or (one.polylines and all(one.closed))
    return CLEAN if clean else BASE + len(one.points)


def _named(groups: Sequence[Group], count: int) -> str:
    spans = [f"{one.first + 1} to {one.first + len(one.slices)}" for one in groups]
    return f"slices {' and '.join(spans)} of {count}"
