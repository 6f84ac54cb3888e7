"""Curves as DXF for drawing programs: ASCII of release 12, which all of them read.

A polyline in a plane z = constant is a ``POLYLINE`` in the plane with that elevation, any other one a
3D ``POLYLINE``. Numbers keep all their digits. (Libraries that write newer releases take seconds for
what takes a tenth of one here, and write the time of day into the file.)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from core.results import Reconstruction
from service.render.documents import dump_json, floats

__all__ = ["Line", "lines", "write_dxf"]

Floats = NDArray[np.float64]

_COLOURS = (5, 30, 3, 6, 40, 4, 7)
"""Colours of layers by their numbers in AutoCAD's list, near those of the pictures."""

_CLOSED, _IN_SPACE, _VERTEX_IN_SPACE = 1, 8, 32


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A polyline (M, 2) or (M, 3) on a layer, whose name has capitals, digits, ``-`` and ``_`` only.

    ``colour`` is the layer's number in AutoCAD's list; None: by turns.
    """

    layer: str
    vertices: Floats
    closed: bool
    colour: int | None = None


@singledispatch
def lines(result: object) -> Sequence[Line]:
    """Return what there is to draw of a result; register a function for each new type of result."""
    raise TypeError(f"no drawing is defined for {type(result).__name__}")


@lines.register
def _(result: Reconstruction) -> Sequence[Line]:
    """Draw the curves, a layer for each component."""
    return [Line(f"COMPONENT_{curve.component}", curve.vertices, curve.closed) for curve in result.curves]


def write_dxf(drawing: Iterable[Line]) -> bytes:
    """Write polylines as a DXF file (release 12, ASCII)."""
    shown = [line for line in drawing if len(line.vertices)]
    layers = {line.layer: line.colour for line in shown}
    return b"".join(
        [
            *_header([_in_space(line.vertices) for line in shown]),
            *_layers(layers),
            _section("ENTITIES"),
            *(_polyline(line) for line in shown),
            _END_OF_SECTION,
            _groups((0, "EOF")),
        ]
    )


def _header(sets: Sequence[Floats]) -> Iterable[bytes]:
    """Name the release, and the extent: what programs show first."""
    points = np.concatenate(sets) if sets else np.zeros((1, 3))
    yield _section("HEADER")
    yield _groups((9, "$ACADVER"), (1, "AC1009"))
    for name, corner in (("$EXTMIN", points.min(axis=0)), ("$EXTMAX", points.max(axis=0))):
        x, y, z = corner.tolist()
        yield _groups((9, name), (10, x), (20, y), (30, z))
    yield _END_OF_SECTION


def _layers(layers: dict[str, int | None]) -> Iterable[bytes]:
    yield _section("TABLES")
    yield _groups((0, "TABLE"), (2, "LTYPE"), (70, 1))
    yield _groups((0, "LTYPE"), (2, "CONTINUOUS"), (70, 0), (3, "Solid line"), (72, 65), (73, 0), (40, 0.0))
    yield _groups((0, "ENDTAB"), (0, "TABLE"), (2, "LAYER"), (70, len(layers)))
    for number, (name, given) in enumerate(layers.items()):
        colour = _COLOURS[number % len(_COLOURS)] if given is None else given
        yield _groups((0, "LAYER"), (2, name), (70, 0), (62, colour), (6, "CONTINUOUS"))
    yield _groups((0, "ENDTAB"))
    yield _END_OF_SECTION


def _polyline(line: Line) -> bytes:
    points = floats(_in_space(line.vertices))
    points = np.repeat(points, 2, axis=0) if len(points) == 1 else points  # the least that programs take
    level = bool(np.all(points[:, 2] == points[0, 2]))
    flags = (_CLOSED if line.closed else 0) | (0 if level else _IN_SPACE)
    elevation = float(points[0, 2]) if level else 0.0
    head = _groups(
        (0, "POLYLINE"), (8, line.layer), (66, 1), (10, 0.0), (20, 0.0), (30, elevation), (70, flags)
    )
    mark = b"" if level else _groups((70, _VERTEX_IN_SPACE))
    vertex = _groups((0, "VERTEX"), (8, line.layer)) + b" 10\n%s\n 20\n%s\n 30\n%s\n" + mark
    numbers = tuple(dump_json(points.ravel())[1:-1].split(b","))
    return head + vertex * len(points) % numbers + _groups((0, "SEQEND"), (8, line.layer))


def _in_space(vertices: Floats) -> Floats:
    return vertices if vertices.shape[1] == 3 else np.column_stack([vertices, np.zeros(len(vertices))])


def _section(name: str) -> bytes:
    return _groups((0, "SECTION"), (2, name))


def _groups(*pairs: tuple[int, object]) -> bytes:
    """Write codes and values, a line each."""
    return "".join(f"{code:3d}\n{value}\n" for code, value in pairs).encode()


_END_OF_SECTION = _groups((0, "ENDSEC"))
