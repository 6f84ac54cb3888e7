from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
import shapely

from render.results import HOLE, OUTER, SQUARE, TRIANGLES, cloud, partition, reconstruction, skeleton
from service.answers import PartitionAnswer, PcaAnswer, SkeletonAnswer
from service.render import document, encode


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stages", [False, True])
def test_a_reconstruction_reads_back_through_the_declared_answer(dimension: int, stages: bool) -> None:
    result = reconstruction(dimension, stages)
    text = encode(result, "json")
    answer = PcaAnswer.model_validate_json(text)
    assert [curve.closed for curve in answer.curves] == [True, False]
    assert all(
        np.array_equal(read.vertices, made.vertices)
        for read, made in zip(answer.curves, result.curves, strict=True)
    )
    assert answer.outliers == [3, 7]
    assert answer.sampling.nyquist.margin_sigmas is None
    assert ("stages" in json.loads(text)) == stages
    assert [("location" in warning) for warning in json.loads(text)["warnings"]] == [True, False]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stages", [False, True])
def test_a_skeleton_reads_back_through_the_declared_answer(dimension: int, stages: bool) -> None:
    result = skeleton(dimension, stages)
    text = encode(result, "json")
    answer = SkeletonAnswer.model_validate_json(text)
    assert result.graph is not None
    assert answer.containment is not None
    assert (answer.containment.passes, answer.containment.samples_inside) == (2, 0.975)
    for read, made in zip(answer.graph.edges, result.graph.edges, strict=True):
        assert np.array_equal(read.vertices, made.vertices)
        assert (tuple(read.nodes), len(read.widths)) == (made.nodes, len(made.vertices))
    assert [node.degree for node in answer.graph.nodes] == [2, 2]
    assert ("stages" in json.loads(text)) == stages


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_tape_is_a_geometry_that_other_software_reads(dimension: int) -> None:
    read = json.loads(encode(skeleton(dimension), "json"))
    shape = shapely.from_geojson(json.dumps(read["tape"]))
    assert shape.geom_type == "MultiPolygon"
    assert shape.has_z == (dimension == 3)
    if dimension == 2:
        assert shape.is_valid
        assert shape.area == pytest.approx(3 * 2 - 1 * 0.2 + 3 * 2 / 16)
    assert [len(polygon) for polygon in read["tape"]["coordinates"]] == [2, 1]
    assert read["tape_components"] == [0, 1]


def test_the_rings_of_the_tape_repeat_their_first_position() -> None:
    outer, hole = json.loads(encode(skeleton(), "json"))["tape"]["coordinates"][0]
    assert outer == [*OUTER.tolist(), OUTER[0].tolist()]
    assert hole == [*HOLE.tolist(), HOLE[0].tolist()]


def test_the_criteria_are_parallel_to_the_triangles() -> None:
    delaunay = json.loads(encode(skeleton(stages=True), "json"))["stages"]["delaunay"]
    assert delaunay["triangles"] == TRIANGLES.tolist()
    assert delaunay["enclosed"] == [True, False, False, False, False]
    assert delaunay["accepted"] == [True, True, True, True, False]
    assert delaunay["bridges"] == [[7, 8], [8, 9]]


def test_samples_without_a_tape_have_an_empty_one() -> None:
    result = dataclasses.replace(skeleton(), tape=(), containment=None, graph=None)
    answer = SkeletonAnswer.model_validate_json(encode(result, "json"))
    assert (answer.tape.coordinates, answer.tape_components, answer.containment) == ([], [], None)
    assert (answer.graph.nodes, answer.graph.edges) == ([], [])


def test_a_march_has_no_tape() -> None:
    assert {"tape", "tape_components", "containment", "graph"}.isdisjoint(document(reconstruction()))


def test_a_partition_reads_back_through_the_declared_answer() -> None:
    result = partition(cloud())
    answer = PartitionAnswer.model_validate_json(encode(result, "json", cloud()))
    assert answer.labels == result.labels.tolist()
    assert [component.size for component in answer.components] == [
        component.size for component in result.components
    ]


def test_members_come_in_the_order_of_the_contract() -> None:
    assert list(document(reconstruction(stages=True))) == [
        "method",
        "reason",
        "curves",
        "crossings",
        "outliers",
        "sampling",
        "frames",
        "warnings",
        "stages",
    ]
    assert list(document(skeleton(stages=True)))[7:] == [
        "warnings",
        "tape",
        "tape_components",
        "containment",
        "graph",
        "stages",
    ]
    assert list(document(partition(cloud()))) == [
        "epsilon",
        "epsilon_source",
        "count",
        "labels",
        "components",
        "warnings",
    ]


def test_numbers_that_are_not_finite_become_null() -> None:
    made = reconstruction()
    curve = dataclasses.replace(made.curves[0], rms_residual=float("nan"))
    result = dataclasses.replace(
        made, curves=(curve,), sampling=dataclasses.replace(made.sampling, density=float("inf"))
    )
    read = json.loads(encode(result, "json"))
    assert read["curves"][0]["rms_residual"] is None
    assert read["sampling"]["density"] is None


def test_arrays_of_any_layout_are_written() -> None:
    made = reconstruction()
    for vertices in (np.asfortranarray(SQUARE), SQUARE[::-1][::-1], SQUARE.astype(">f8"), SQUARE.astype(int)):
        result = dataclasses.replace(made, curves=(dataclasses.replace(made.curves[0], vertices=vertices),))
        assert json.loads(encode(result, "json"))["curves"][0]["vertices"] == SQUARE.tolist()


def test_numbers_of_numpy_are_numbers() -> None:
    made = reconstruction()
    curve = dataclasses.replace(
        made.curves[0],
        length=np.float64(1.5),
        samples=np.int64(3),
        closed=np.bool_(True),
        component=np.int32(0),
    )
    read = json.loads(encode(dataclasses.replace(made, curves=(curve,)), "json"))["curves"][0]
    assert (read["length"], read["samples"], read["closed"]) == (1.5, 3, True)


def test_a_result_of_another_type_has_no_document() -> None:
    with pytest.raises(TypeError, match="object"):
        encode(object(), "json")
