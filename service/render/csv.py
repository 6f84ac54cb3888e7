"""Results as tables (RFC 4180, lines end in a line feed); numbers read back to the same floats."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from core.results import Partition, Reconstruction
from service.render.documents import dump_json, floats

__all__ = ["points_table", "rows", "table"]

Floats = NDArray[np.float64]


@singledispatch
def table(result: object, points: Floats | None = None) -> bytes:  # noqa: ARG001 # registered functions use it
    """Return the CSV of a result; register a function for each new type of result."""
    raise TypeError(f"no table is defined for {type(result).__name__}")


@table.register
def _(result: Partition, points: Floats | None = None) -> bytes:
    """Columns x, y[, z], label: one line a point, in the order of the input."""
    if points is None:
        raise TypeError("the table of a partition needs the points")
    labels = dump_json(result.labels.astype(np.int64)).strip(b"[]").split(b",")
    lines = map(b",".join, zip(rows(points), labels, strict=True)) if len(points) else ()
    return b"\n".join([_names(points.shape[1]) + b",label", *lines, b""])


@table.register
def _(result: Reconstruction, points: Floats | None = None) -> bytes:
    """Columns curve, x, y[, z]: one line a vertex, curve after curve."""
    dimension = (
        result.curves[0].vertices.shape[1] if result.curves else 2 if points is None else points.shape[1]
    )
    lines = [
        b"%d,%s" % (number, row) for number, curve in enumerate(result.curves) for row in rows(curve.vertices)
    ]
    return b"\n".join([b"curve," + _names(dimension), *lines, b""])


def points_table(points: Floats) -> bytes:
    """Return the CSV of a point set: columns x, y[, z]."""
    return b"\n".join([_names(points.shape[1]), *rows(points), b""])


def _names(dimension: int) -> bytes:
    return b",".join([b"x", b"y", b"z"][:dimension])


def rows(points: Floats) -> list[bytes]:
    """Return each point as ``x,y[,z]``: JSON rows without their brackets, which ``orjson`` writes fastest."""
    return dump_json(floats(points))[2:-2].split(b"],[") if len(points) else []
