"""Specks: contours of a few samples that nothing above or below goes on from.

Scans have stray patches beside the object, where rays hit an edge or the table. What is cut of them are
contours like all others, but of few samples, in one level or two, and the surface would have a crumb there.
Where a patch bridges two parts in one level, the hole beside it would make a handle of the surface.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from core.results import Curve, Warn
from core.surface.axis import AxisFrame
from core.surface.draft import STRAY
from core.surface.results import ContourLevel

__all__ = ["without_specks"]

_OPEN = 0.5  # share of a hole that may lie within contours of another level

Place = tuple[int, int]  # of a level in the stack, and of a contour in it


def without_specks(levels: Sequence[ContourLevel], frame: AxisFrame) -> tuple[ContourLevel, ...]:
    """Leave out contours that have no part in anything larger.

    A speck is a set of contours that overlap from level to level and together have fewer samples than 3 % of
    what levels usually have; or a hole of as few that is open above and below.

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
    limit = STRAY * float(np.median([count for count in counts if count] or [0]))
    small = {
        (k, j): _disc(curve, frame)
        for k, level in enumerate(levels)
        for j, curve in enumerate(level.curves)
        if 0 < curve.samples < limit and curve.closed
    }
    gone = {place for place, hole in small.items() if _is_handle(place, hole, levels, frame)}
    while small:
        group, meets_more = _group(next(iter(small)), small, levels, frame)
        for place in group:
            del small[place]
        if not meets_more and sum(levels[k].curves[j].samples for k, j in group) < limit:
            gone.update(group)
    return tuple(_without(level, {j for at, j in gone if at == k}) for k, level in enumerate(levels))


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


def _is_handle(place: Place, hole: BaseGeometry, levels: Sequence[ContourLevel], frame: AxisFrame) -> bool:
    """Tell whether a contour is a hole of its level, over and under which there is only outside."""
    k, j = place
    if not 0 < k < len(levels) - 1:
        return False
    others = [curve for at, curve in enumerate(levels[k].curves) if at != j]
    if not _covered(others, frame).contains(hole.representative_point()):
        return False
    beside = [_covered(levels[at].curves, frame).intersection(hole).area for at in (k - 1, k + 1)]
    return bool(max(beside) < _OPEN * hole.area)


def _covered(curves: Sequence[Curve], frame: AxisFrame) -> BaseGeometry:
    """Return all that contours go around, holes and all."""
    return shapely.union_all([_disc(one, frame) for one in curves if one.closed])


def _disc(curve: Curve, frame: AxisFrame) -> BaseGeometry:
    """Return what a closed contour goes around."""
    return shapely.make_valid(shapely.Polygon(frame.to_plane(curve.vertices)))


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
