from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable

import numpy as np
import pytest
import shapely

from core.results import Reconstruction
from render.results import (
    HOLE,
    OUTER,
    SQUARE,
    TRIANGLES,
    chosen,
    cloud,
    diagnosis,
    partition,
    reconstruction,
    skeleton,
)
from service.answers import DiagnosisAnswer, PartitionAnswer, PcaAnswer, ReconstructAnswer, SkeletonAnswer
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
    for read, made in zip(answer.curves, result.curves, strict=True):
        errors = made.standard_errors
        assert read.standard_errors == (None if errors is None else errors.tolist())
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


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stages", [False, True])
@pytest.mark.parametrize("made", [reconstruction, skeleton])
def test_a_choice_of_methods_reads_back_through_the_declared_answer(
    dimension: int, stages: bool, made: Callable[[int, bool], Reconstruction]
) -> None:
    answer = ReconstructAnswer.model_validate_json(encode(chosen(made(dimension, stages)), "json"))
    (better,), (worse,) = answer.decisions, answer.alternatives
    assert (better.method, better.nats, worse.method, worse.nats) == ("pca", 0.0, "skeleton", 31.5)
    assert (answer.stages is not None) == stages


def test_where_there_was_a_choice_and_no_tape_all_of_it_is_null() -> None:
    for result in (reconstruction(), dataclasses.replace(skeleton(), tape=())):
        answer = ReconstructAnswer.model_validate_json(encode(chosen(result), "json"))
        assert answer.tape is answer.tape_components is answer.containment is answer.graph is None
    taped = ReconstructAnswer.model_validate_json(encode(chosen(skeleton()), "json"))
    assert taped.tape is not None
    assert taped.tape_components == [0, 1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_diagnosis_reads_back_through_the_declared_answer(dimension: int) -> None:
    made = diagnosis(dimension)
    answer = DiagnosisAnswer.model_validate_json(encode(made, "json"))
    assert (answer.verdict, answer.curves, answer.closed, answer.crossings) == (made.verdict, 2, 1, 1)
    sampling = answer.sampling
    (violation,) = sampling.nyquist.violations
    assert violation.model_dump(exclude={"location"}) == {
        "gap_sigmas": 1.5,
        "reason": "narrow",
        "kind": "branches-too-near",
        "advice": "scan denser here",
    }
    assert len(violation.location) == dimension
    assert sampling.nyquist.margin_location == violation.location
    assert sampling.sigma_along[0].sigma == [0.01, 0.02]
    assert sampling.largest_gap is not None
    assert (sampling.largest_gap.spacings, sampling.largest_gap.expected) == (8.0, 9.5)
    assert [one.sigma_error for one in sampling.components] == [0.001, None]


def test_what_is_not_known_of_the_samples_is_null() -> None:
    made = diagnosis()
    nyquist = dataclasses.replace(made.sampling.nyquist, margin_sigmas=None, margin_location=None)
    sampling = dataclasses.replace(made.sampling, nyquist=nyquist, sigma_error=None, largest_gap=None)
    text = encode(dataclasses.replace(made, sampling=sampling), "json")
    read = DiagnosisAnswer.model_validate_json(text).sampling
    assert read.nyquist.margin_sigmas is read.nyquist.margin_location is None
    assert read.sigma_error is read.largest_gap is None


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
    choice = list(document(chosen(skeleton(stages=True))))
    assert choice[7:11] == ["warnings", "decisions", "alternatives", "tape"]
    assert choice == list(document(chosen(reconstruction(stages=True))))
    assert list(document(diagnosis()))[:3] == ["verdict", "method", "reason"]
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
