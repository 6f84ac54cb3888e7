from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.parameters import PartitionParameters, PcaParameters
from intake.reading import dumped, places, read, refusal
from service.intake import submission_model

REAL = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**53), 2**53)


@given(st.integers(2, 3).flatmap(lambda d: st.lists(st.lists(REAL, min_size=d, max_size=d), min_size=1)))
def test_rows_of_numbers_become_the_same_array(rows: list[list[float]]) -> None:
    points = read(dumped(points=rows)).points
    assert points.dtype == np.float64
    assert points.flags.c_contiguous
    assert points.flags.writeable
    assert points.tolist() == [[float(value) for value in row] for row in rows]


@given(
    st.integers(2, 3).flatmap(lambda d: st.lists(st.lists(REAL, min_size=d, max_size=d), min_size=1)),
    st.data(),
    st.sampled_from([True, False, "1", "", None, [1.0], {}, {"x": 1, "y": 2}]),
)
def test_anything_but_a_number_is_found_where_it_is(
    rows: list[list[Any]], data: st.DataObject, wrong: Any
) -> None:
    row, column = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, len(rows[0]) - 1))
    rows[row][column] = wrong
    error = refusal(dumped(points=rows))
    assert (error.status, error.kind) == (422, "invalid-points")
    assert places(error) == [["body", "points", row, column]]


@pytest.mark.parametrize("wrong", [3, 1.5, True, None, "ab", "abc", {}, {"a": 1, "b": 2}])
def test_a_row_must_be_a_list(wrong: object) -> None:
    assert places(refusal(dumped(points=[[1, 2], wrong]))) == [["body", "points", 1]]


@pytest.mark.parametrize("wrong", [None, 3, "points", {}, {"x": [1], "y": [2]}, True, []])
def test_points_must_be_a_list_with_something_in_it(wrong: object) -> None:
    assert places(refusal(dumped(points=wrong))) == [["body", "points"]]


@pytest.mark.parametrize("width", [0, 1, 4, 5])
def test_a_row_has_two_or_three_numbers(width: int) -> None:
    assert places(refusal(dumped(points=[[1.0] * width] * 3))) == [
        ["body", "points", row] for row in range(3)
    ]


def test_mixed_lengths_are_named() -> None:
    rows = [[0.5, 0.5]] * 17 + [[1, 2, 3]] + [[4, 5]]
    error = refusal(dumped(points=rows))
    assert places(error) == [["body", "points", 17]]
    assert error.errors[0]["msg"] == "row 17 has 3 numbers, row 0 has 2"


def test_only_so_many_errors_are_listed() -> None:
    assert places(refusal(dumped(points=[["x", 1]] * 9000))) == [
        ["body", "points", row, 0] for row in range(20)
    ]
    assert len(refusal(dumped(points=[[1, 2], *[[1, 2, 3]] * 9000])).errors) == 20


def test_errors_far_down_keep_their_place() -> None:
    rows: list[list[object]] = [[0.25, 0.75]] * 9000
    rows[8888] = [0.5, "here"]
    assert places(refusal(dumped(points=rows))) == [["body", "points", 8888, 1]]


def test_the_input_is_not_echoed() -> None:
    error = refusal(dumped(points=[["secret", 1]], parameters={"epsilon": "hidden"}, include=["covert"]))
    assert not {word for word in ("secret", "hidden", "covert") if word in str(vars(error))}


def test_made_up_names_are_cut() -> None:
    error = refusal(dumped(points=[[1, 2]], **{"n" * 5000: 1}))
    assert max(len(str(part)) for part in places(error)[0]) <= 80


def test_the_schema_shows_arrays_of_numbers() -> None:
    schema = submission_model(PcaParameters, frozenset({"stages"})).model_json_schema()
    points = schema["properties"]["points"]
    assert points["type"] == points["items"]["type"] == "array"
    assert points["items"]["items"] == {"type": "number"}
    assert (points["items"]["minItems"], points["items"]["maxItems"]) == (2, 3)
    assert schema["required"] == ["points"]
    assert schema["properties"]["include"]["items"]["const"] == "stages"
    assert schema["additionalProperties"] is False


def test_models_are_made_once_and_named_after_their_parameters() -> None:
    model = submission_model(PartitionParameters, frozenset())
    assert model is submission_model(PartitionParameters, frozenset())
    assert model.__name__ == "PartitionSubmission"
