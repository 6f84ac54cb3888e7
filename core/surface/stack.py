"""What was given of an object, checked, as meshes, slices or contours in place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from core.errors import DegenerateInput, InvalidInput, InvalidParameter
from core.results import Curve
from core.surface.axis import AxisFrame, axis_frame
from core.surface.parameters import SliceParameters
from core.surface.range_image import triangulate
from core.surface.results import ContourLevel, Mesh, Scans, Slice
from core.surface.slicing import slices_of

__all__ = ["cut", "given", "given_contours", "meshes_of"]

Floats = NDArray[np.float64]

KINDS = ("meshes", "range_images", "slices", "contours")
PLACES = ("levels", "spacing", "heights")
LARGEST = 1e60  # beyond it, or its inverse, products of coordinates leave the range of numbers
RESOLVED = 1e-9  # of the extent: levels closer to each other are one


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
    for k, mesh in enumerate(scans.meshes):
        _check_size(mesh.vertices, ("meshes", k))
    for k, image in enumerate(scans.range_images):
        _check_size(image.points, ("range_images", k))
        if image.pose is not None:
            _check_size(image.pose.translation, ("range_images", k, "pose", "translation"))
    _check_extent([one.points.reshape(-1, 3) for one in scans.range_images], "range_images")
    meshes = (*scans.meshes, *(triangulate(image) for image in scans.range_images))
    if not any(len(mesh.faces) for mesh in meshes):
        where = "range_images" if scans.range_images else "meshes"
        raise DegenerateInput("No three neighbouring samples make a triangle.", (where,))
    _check_extent([mesh.vertices for mesh in meshes], given(scans))
    return meshes


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
