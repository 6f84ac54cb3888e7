from __future__ import annotations

import csv
import io
import json
from typing import Any

import ezdxf
import numpy as np
import pytest
import shapely

from core.surface.results import ContourLevel, Contours, Slices
from render.surfaces import contours, curve, slices
from service.render import encode
from service.render.levels import outlines

TILTED = (1.0, 2.0, 2.0)
each = pytest.mark.parametrize("made", [contours, slices], ids=["contours", "slices"])
each_axis = pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), TILTED])


def features(result: Contours | Slices) -> list[dict[str, Any]]:
    content = encode(result, "geojson")
    assert shapely.is_valid_input(shapely.from_geojson(content)).all()
    read: list[dict[str, Any]] = json.loads(content)["features"]
    return read


def test_a_contour_is_a_line_that_knows_its_level() -> None:
    result = contours()
    read = features(result)
    assert [one["properties"]["level"] for one in read] == [0, 1, 2, 3]
    assert [one["properties"]["height"] for one in read] == [0.0, 0.5, 1.0, 1.5]
    assert [one["properties"]["completed"] for one in read] == [False, True, False, False]
    assert [one["properties"]["curve"] for one in read] == [0, 1, 2, 3]
    for one, level in zip(read, result.slices, strict=False):
        vertices = level.curves[0].vertices.tolist()
        assert one["geometry"] == {"type": "LineString", "coordinates": [*vertices, vertices[0]]}
        assert one["properties"]["kind"] == "contour"
        assert one["properties"]["closed"]


@each_axis
def test_slices_are_lines_and_their_samples(axis: tuple[float, float, float]) -> None:
    result = slices(axis=axis)
    read = features(result)
    kinds = [(one["properties"]["kind"], one["geometry"]["type"]) for one in read]
    assert kinds == [("outline", "LineString")] * 8 + [("samples", "MultiPoint")] * 4
    assert [one["properties"]["closed"] for one in read[:8]] == [True, False] * 4
    for one, level in zip(read[8:], result.slices, strict=False):
        assert one["geometry"]["coordinates"] == level.points.tolist()
        assert one["properties"]["height"] == level.height
    for one, outline in zip(read[:8], outlines(result), strict=True):
        assert one["geometry"]["coordinates"][: len(outline.vertices)] == outline.vertices.tolist()
        assert len(one["geometry"]["coordinates"]) == len(outline.vertices) + outline.closed


@each
@each_axis
def test_a_table_has_a_line_for_each_vertex_with_its_level(made: Any, axis: Any) -> None:
    result = made(axis=axis)
    head, *read = csv.reader(io.StringIO(encode(result, "csv").decode()))
    assert head == ["curve", "x", "y", "z", "level", "height"]
    expected = [
        [number, *vertex, one.level, one.height]
        for number, one in enumerate(outlines(result))
        for vertex in one.vertices.tolist()
    ]
    assert [[float(cell) for cell in row] for row in read] == expected


@each
def test_a_drawing_has_a_layer_for_each_level(made: Any) -> None:
    result = made(12)
    document = ezdxf.read(io.StringIO(encode(result, "dxf").decode()))
    drawn = list(document.modelspace())
    expected = list(outlines(result))
    assert len(drawn) == len(expected)
    for entity, one in zip(drawn, expected, strict=True):
        assert entity.dxf.layer == f"LEVEL_{one.level:02d}" + ("_COMPLETED" if one.completed else "")
        assert entity.is_closed == one.closed
        assert entity.dxf.elevation.z == one.height
        assert [tuple(point) for point in entity.points_in_wcs()] == [tuple(p) for p in one.vertices.tolist()]
    layers = [layer for layer in document.layers if layer.dxf.name.endswith("_COMPLETED")]
    assert [layer.dxf.color for layer in layers] == ([1] if made is contours else [])


@each
def test_levels_across_another_axis_are_drawn_in_space(made: Any) -> None:
    result = made(axis=TILTED)
    drawn = list(ezdxf.read(io.StringIO(encode(result, "dxf").decode())).modelspace())
    for entity, one in zip(drawn, outlines(result), strict=True):
        assert entity.is_3d_polyline
        assert [tuple(vertex.dxf.location) for vertex in entity.vertices] == [
            tuple(p) for p in one.vertices.tolist()
        ]


def test_curves_are_counted_through_all_levels() -> None:
    ring = contours().slices[0].curves[0].vertices
    many = ContourLevel(0.0, tuple(curve(ring + k, component=k) for k in range(3)))
    other = ContourLevel(1.0, (curve(ring[:2], closed=False),))
    result = Contours(np.array([0.0, 0.0, 1.0]), (many, other))
    read = features(result)
    assert [one["properties"]["curve"] for one in read] == [0, 1, 2, 3]
    assert [one["properties"]["level"] for one in read] == [0, 0, 0, 1]
    assert not read[3]["properties"]["closed"]
    assert {row.split(b",")[0] for row in encode(result, "csv").splitlines()[1:]} == {b"0", b"1", b"2", b"3"}


@each
@pytest.mark.parametrize("form", ["geojson", "csv", "dxf"])
def test_levels_without_anything_give_a_file(made: Any, form: str) -> None:
    assert encode(made(0), form)
