from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from core.results import Reconstruction
from render.results import LINE, SQUARE, cloud, partition, reconstruction, skeleton
from service.render import encode


@pytest.mark.parametrize("dimension", [2, 3])
def test_geometry_parses_and_holds_the_vertices(dimension: int) -> None:
    result = reconstruction(dimension)
    geometries = shapely.get_parts(shapely.from_geojson(encode(result, "geojson")))
    assert shapely.get_type_id(geometries).tolist() == [1, 1, 0]
    for curve, line in zip(result.curves, geometries[:2], strict=True):
        assert shapely.is_closed(line) == curve.closed
        read = shapely.get_coordinates(line, include_z=dimension == 3)
        assert np.array_equal(read[: len(curve.vertices)], curve.vertices)


def test_the_line_of_a_closed_curve_is_as_long_as_the_curve() -> None:
    lines = shapely.get_parts(shapely.from_geojson(encode(reconstruction(), "geojson")))[:2]
    assert shapely.length(lines) == pytest.approx([6.0, 3.0])


def test_closed_curves_repeat_their_first_vertex_and_open_ones_do_not() -> None:
    closed, opened, crossing = json.loads(encode(reconstruction(), "geojson"))["features"]
    assert closed["geometry"]["coordinates"] == [*SQUARE.tolist(), SQUARE[0].tolist()]
    assert opened["geometry"]["coordinates"] == LINE.tolist()
    assert closed["properties"]["closed"]
    assert not opened["properties"]["closed"]
    assert crossing["properties"] == {"kind": "crossing", "curves": [0, 1], "angle": 90.0}


def test_standard_errors_are_parallel_to_the_positions() -> None:
    closed, opened, _ = json.loads(encode(reconstruction(), "geojson"))["features"]
    errors = closed["properties"]["standard_errors"]
    assert len(errors) == len(closed["geometry"]["coordinates"])
    assert errors[0] == errors[-1]
    assert opened["properties"]["standard_errors"] is None


def test_a_curve_of_one_vertex_is_still_a_line() -> None:
    made = reconstruction()
    curve = dataclasses.replace(made.curves[0], vertices=SQUARE[:1], closed=False)
    read = json.loads(encode(dataclasses.replace(made, curves=(curve,)), "geojson"))
    assert len(read["features"][0]["geometry"]["coordinates"]) == 2


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_skeleton_has_its_tape_and_its_graph_beside_the_curves(dimension: int) -> None:
    features = json.loads(encode(skeleton(dimension), "geojson"))["features"]
    kinds = [(feature["properties"]["kind"], feature["geometry"]["type"]) for feature in features]
    assert kinds == [
        ("curve", "LineString"),
        ("crossing", "Point"),
        ("tape", "MultiPolygon"),
        ("tape", "MultiPolygon"),
        ("node", "MultiPoint"),
        ("node", "MultiPoint"),
        ("edge", "MultiLineString"),
        ("edge", "MultiLineString"),
    ]
    made = skeleton(dimension).graph
    assert made is not None
    for feature, edge in zip(features[6:], made.edges, strict=True):
        assert feature["geometry"]["coordinates"] == [edge.vertices.tolist()]
        assert feature["properties"]["widths"] == edge.widths.tolist()


def test_every_component_has_its_own_tape() -> None:
    features = json.loads(encode(skeleton(), "geojson"))["features"]
    tapes = [feature for feature in features if feature["properties"]["kind"] == "tape"]
    assert [tape["properties"]["component"] for tape in tapes] == [0, 1]
    shapes = [shapely.from_geojson(json.dumps(tape)) for tape in tapes]
    assert all(shape.is_valid for shape in shapes)
    assert shapely.area(shapes) == pytest.approx([3 * 2 - 1 * 0.2, 3 * 2 / 16])


@pytest.mark.parametrize("result", [reconstruction(), skeleton()], ids=["pca", "skeleton"])
def test_lines_are_curves_and_points_are_crossings_whatever_the_method(result: Reconstruction) -> None:
    features = json.loads(encode(result, "geojson"))["features"]
    found: dict[str, list[str]] = {}
    for feature in features:
        found.setdefault(feature["geometry"]["type"], []).append(feature["properties"]["kind"])
    assert found["LineString"] == ["curve"] * len(result.curves)
    assert found["Point"] == ["crossing"] * len(result.crossings)


@given(st.integers(1, 40), st.integers(0, 5), st.sampled_from([2, 3]))
def test_the_components_of_a_partition_hold_every_point_once(n: int, count: int, dimension: int) -> None:
    points = cloud(n, dimension)
    result = partition(points, count)
    features = json.loads(encode(result, "geojson", points))["features"]
    assert [feature["properties"]["label"] for feature in features] == np.unique(result.labels).tolist()
    for feature in features:
        assert feature["geometry"]["type"] == "MultiPoint"
        mine = points[result.labels == feature["properties"]["label"]]
        assert feature["geometry"]["coordinates"] == mine.tolist()


def test_a_partition_needs_its_points() -> None:
    with pytest.raises(TypeError, match="points"):
        encode(partition(cloud()), "geojson")
