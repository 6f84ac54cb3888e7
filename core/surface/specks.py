"""Specks: contours of a few samples that nothing above or below goes on from.

Scans have stray patches beside the object, where rays hit an edge or the table. What is cut of them are
contours like all others, but of few samples, in one level or two, and the surface would have a crumb there.
Where a patch bridges two parts in one level, the hole beside it would make a handle of the surface, and a
hole in one level alone a bubble.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from core.results import Curve, Warn
from core.surface.axis import AxisFrame
from core.surface.draft import STRAY
from core.surface.results import ContourLevel

__all__ = ["without_specks"]

_SHALLOW = 0.1  # of the samples of a usual level
_OPEN = 0.5  # share of a hole that may lie within contours of another level, to be open there
_LEFT = 0.05  # share that may be open, to be solid there

Place = tuple[int, int]  # of a level in the stack, and of a contour in it


def without_specks(levels: Sequence[ContourLevel], frame: AxisFrame) -> tuple[ContourLevel, ...]:
    """Leave out contours that have no part in anything larger.

    A speck is a set of contours that overlap from level to level and together have fewer samples than 3 % of
    what levels usually have; or a hole of one level with fewer than 10 %, over and under which all is open,
    or all solid.

    Parameters
    ----------
    levels : sequence of ContourLevel
        By height.
    frame : AxisFrame
        Of the axis across them.

    Returns
    -------
    tuple of ContourLevel
        With a warning where something was left out.
    """
    counts = [sum(curve.samples for curve in one.curves) for one in levels]
    usual = float(np.median([count for count in counts if count] or [0]))
    guessed = [
        (k, j)
        for k, one in enumerate(levels)
        if one.completed
        for j, curve in enumerate(one.curves)
        if not curve.samples
    ]
    doubted = [*guessed, *_places(levels, _SHALLOW * usual)]
    gone = {place for place in doubted if _is_shallow(place, levels, frame)}
    limit = STRAY * usual
    small = {(k, j): _disc(levels[k].curves[j], frame) for k, j in _places(levels, limit)}
    while small:
        group, meets_more = _group(next(iter(small)), small, levels, frame)
        for place in group:
            del small[place]
        if not meets_more and sum(levels[k].curves[j].samples for k, j in group) < limit:
            gone.update(group)
    return tuple(_without(level, {j for at, j in gone if at == k}) for k, level in enumerate(levels))


def _places(levels: Sequence[ContourLevel], limit: float) -> list[Place]:
    """Return where closed contours of fewer samples are."""
    return [
        (k, j)
        for k, level in enumerate(levels)
        for j, curve in enumerate(level.curves)
        if 0 < curve.samples < limit and curve.closed
    ]


def _group(
    first: Place, small: Mapping[Place, BaseGeometry], levels: Sequence[ContourLevel], frame: AxisFrame
) -> tuple[list[Place], bool]:
    """Return the small contours that a small one goes on to, and whether they meet larger ones too."""
    group, meets_more = [first], False
    for k, j in group:
        one = small[k, j]
        for at in (k - 1, k + 1):
            curves = levels[at].curves if 0 <= at < len(levels) else ()
            for other, curve in enumerate(curves):
                if (at, other) in group or not curve.closed:
                    continue
                if not one.intersects(_disc(curve, frame)):
                    continue
                if (at, other) in small:
                    group.append((at, other))
                else:
                    meets_more = True
    return group, meets_more


def _is_shallow(place: Place, levels: Sequence[ContourLevel], frame: AxisFrame) -> bool:
    """Tell whether a contour is a hole that is as open above and below as beside the object, or as solid."""
    k, j = place
    if not 0 < k < len(levels) - 1:
        return False
    hole = _disc(levels[k].curves[j], frame)
    others = [curve for at, curve in enumerate(levels[k].curves) if at != j]
    if not _covered(others, frame).contains(hole.representative_point()):
        return False
    beside = [levels[at].curves for at in (k - 1, k + 1)]
    if all(_covered(curves, frame).intersection(hole).area < _OPEN * hole.area for curves in beside):
        return True
    return all(_solid(curves, frame).intersection(hole).area > (1.0 - _LEFT) * hole.area for curves in beside)


def _covered(curves: Sequence[Curve], frame: AxisFrame) -> BaseGeometry:
    """Return all that contours go around, holes and all."""
    return shapely.union_all([_disc(one, frame) for one in curves if one.closed])


def _solid(curves: Sequence[Curve], frame: AxisFrame) -> BaseGeometry:
    """Return what an odd number of contours goes around."""
    discs = [_disc(one, frame) for one in curves if one.closed]
    return reduce(shapely.symmetric_difference, discs, shapely.Polygon())


def _disc(curve: Curve, frame: AxisFrame) -> BaseGeometry:
    """Return what a closed contour goes around."""
    ring = shapely.Polygon(frame.to_plane(curve.vertices))
    return shapely.make_valid(ring, method="structure", keep_collapsed=False)


def _without(level: ContourLevel, gone: set[int]) -> ContourLevel:
    if not gone:
        return level
    lost = sum(level.curves[j].samples for j in gone)
    message = (
        f"At height {level.height:.6g}, {len(gone)} contour{'' if len(gone) == 1 else 's'} of {lost} samples "
        "that nothing above or below goes on from were left out."
    )
    curves = tuple(curve for j, curve in enumerate(level.curves) if j not in gone)
    return replace(level, curves=curves, warnings=(*level.warnings, Warn("speck", message)))
