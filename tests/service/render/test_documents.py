from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from render.results import SQUARE, cloud, partition, reconstruction
from service.answers import PartitionAnswer, ReconstructionAnswer
from service.render import document, encode


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stages", [False, True])
def test_a_reconstruction_reads_back_through_the_declared_answer(dimension: int, stages: bool) -> None:
    result = reconstruction(dimension, stages)
    text = encode(result, "json")
    answer = ReconstructionAnswer.model_validate_json(text)
    assert [curve.closed for curve in answer.curves] == [True, False]
    assert all(
        np.array_equal(read.vertices, made.vertices)
        for read, made in zip(answer.curves, result.curves, strict=True)
    )
    assert answer.outliers == [3, 7]
    assert answer.sampling.nyquist.margin_sigmas is None
    assert ("stages" in json.loads(text)) == stages
    assert [("location" in warning) for warning in json.loads(text)["warnings"]] == [True, False]


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
