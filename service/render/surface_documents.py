"""Slices, contours and surfaces as JSON documents."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from core.surface.results import ContourLevel, Contours, Slice, Slices, Surface, SurfaceReport
from service.render.documents import Document, curve_document, document, floats, warning_document

__all__: list[str] = []


@document.register
def _(result: Slices) -> Document:
    return {
        "axis": floats(result.axis),
        "slices": [_slice(one) for one in result.slices],
        "warnings": [warning_document(warning) for warning in result.warnings],
    }


@document.register
def _(result: Contours) -> Document:
    return {
        "axis": floats(result.axis),
        "slices": _levels(result.slices),
        "warnings": [warning_document(warning) for warning in result.warnings],
    }


@document.register
def _(result: Surface) -> Document:
    slices = {"slices": _levels(result.slices)} if result.slices else {}
    return {
        "mesh": {
            "vertices": floats(result.mesh.vertices),
            "faces": np.ascontiguousarray(result.mesh.faces, dtype=np.int64),
        },
        "report": _report(result.report),
        **slices,
        "warnings": [warning_document(warning) for warning in result.warnings],
    }


def _slice(one: Slice) -> Document:
    return {
        "height": one.height,
        "points": floats(one.points),
        "polylines": [floats(line) for line in one.polylines],
        "closed": list(one.closed),
    }


def _levels(levels: Iterable[ContourLevel]) -> list[Document]:
    return [
        {
            "height": level.height,
            "curves": [curve_document(curve) for curve in level.curves],
            "completed": level.completed,
        }
        for level in levels
    ]


def _report(report: SurfaceReport) -> Document:
    return {
        "closed": report.closed,
        "manifold": report.manifold,
        "components": report.components,
        "euler": report.euler,
        "genus": report.genus,
        "volume": report.volume,
        "area": report.area,
        "self_intersections": report.self_intersections,
        "completed_levels": list(report.completed_levels),
        "rms_residual": report.rms_residual,
        "method": report.method,
    }
