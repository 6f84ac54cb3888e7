"""Slices and contours, level by level, as GeoJSON, tables and drawings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.results import Curve
from core.surface.results import ContourLevel, Contours, Slice, Slices
from service.render.csv import rows, table
from service.render.dxf import Line, lines
from service.render.geojson import Feature, collection, curve_feature, feature, feature_collection

__all__ = ["Outline", "outlines"]

Floats = NDArray[np.float64]

_RED = 1  # in AutoCAD's list


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A polyline (M, 3) of a level, which has a number."""

    level: int
    height: float
    vertices: Floats
    closed: bool
    completed: bool = False


def outlines(result: Slices | Contours) -> Iterator[Outline]:
    """Return the polylines of all levels, the lowest first, where the answer has them so."""
    levels: Sequence[Slice | ContourLevel] = result.slices
    for number, level in enumerate(levels):
        if isinstance(level, ContourLevel):
            for curve in level.curves:
                yield Outline(number, level.height, curve.vertices, curve.closed, level.completed)
        else:
            for vertices, closed in zip(level.polylines, level.closed, strict=True):
                yield Outline(number, level.height, vertices, closed)


# --- GeoJSON ------------------------------------------------------------------------------------------


@feature_collection.register
def _(result: Contours, points: Floats | None = None) -> Feature:  # noqa: ARG001 # contours say it all
    """One LineString a contour."""
    numbers = iter(range(sum(len(level.curves) for level in result.slices)))
    return collection(
        [
            _contour(number, level, curve, next(numbers))
            for number, level in enumerate(result.slices)
            for curve in level.curves
        ]
    )


def _contour(number: int, level: ContourLevel, curve: Curve, place: int) -> Feature:
    made = curve_feature(place, curve)
    told = {"kind": "contour", "level": number, "height": level.height, "completed": level.completed}
    made["properties"] |= told
    return made


@feature_collection.register
def _(result: Slices, points: Floats | None = None) -> Feature:  # noqa: ARG001 # slices have their own
    """One LineString a polyline, and one MultiPoint for the samples of each level."""
    return collection(
        [
            feature("LineString", _positions(one), _properties(one.level, one.height, one.closed))
            for one in outlines(result)
        ]
        + [
            feature("MultiPoint", level.points, _properties(number, level.height))
            for number, level in enumerate(result.slices)
            if len(level.points)
        ]
    )


def _positions(outline: Outline) -> Floats:
    """A closed line repeats its first position; any line has two."""
    ring = outline.closed or len(outline.vertices) == 1
    return np.concatenate([outline.vertices, outline.vertices[:1]]) if ring else outline.vertices


def _properties(level: int, height: float, closed: bool | None = None) -> dict[str, object]:
    told = {"kind": "samples"} if closed is None else {"kind": "outline", "closed": closed}
    return told | {"level": level, "height": height}


# --- tables and drawings ------------------------------------------------------------------------------


@table.register(Contours)
@table.register(Slices)
def _(result: Slices | Contours, points: Floats | None = None) -> bytes:  # noqa: ARG001 # see above
    """Columns curve, x, y, z, level, height: one line a vertex, curve after curve."""
    lines_ = [
        b"%d,%s,%d,%r" % (number, row, one.level, float(one.height))
        for number, one in enumerate(outlines(result))
        for row in rows(one.vertices)
    ]
    return b"\n".join([b"curve,x,y,z,level,height", *lines_, b""])


@lines.register(Contours)
@lines.register(Slices)
def _(result: Slices | Contours) -> Sequence[Line]:
    """Draw every level on a layer of its own, completed ones in red."""
    digits = len(str(len(result.slices)))
    return [
        Line(
            f"LEVEL_{one.level:0{digits}d}" + ("_COMPLETED" if one.completed else ""),
            one.vertices,
            one.closed,
            _RED if one.completed else None,
        )
        for one in outlines(result)
    ]
