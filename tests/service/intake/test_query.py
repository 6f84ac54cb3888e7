from __future__ import annotations

import pytest

from core.parameters import PcaParameters
from intake.reading import CSV, dumped, places, read, refusal
from service.intake.query import read_query

ROWS = b"0,0\n1,0.5\n"


def test_text_becomes_values_of_the_declared_types() -> None:
    query = {
        "epsilon": "0.5",
        "min_component_size": "7",
        "refine": "false",
        "outliers": "keep",
        "planar": "true",
        "seed": "42",
    }
    assert read(ROWS, CSV, query=query).parameters == PcaParameters(
        epsilon=0.5, min_component_size=7, refine=False, outliers="keep", planar=True, seed=42
    )


@pytest.mark.parametrize("null", ["", "null", "NULL", " "])
def test_null_lets_the_data_decide(null: str) -> None:
    assert read(ROWS, CSV, query={"epsilon": null}).parameters == PcaParameters()


def test_null_is_no_value_where_the_model_has_none() -> None:
    assert places(refusal(ROWS, CSV, query={"seed": "null"})) == [["query", "seed"]]


@pytest.mark.parametrize(
    "query",
    [
        {"epsilon": "wide"},
        {"epsilon": "-1"},
        {"epsilon": "nan"},
        {"epsilon": "1e999"},
        {"max_uses": "1.5"},
        {"refine": "perhaps"},
        {"estimator": "guess"},
        {"epsilom": "1"},
        {"radius[]": "1"},
    ],
)
def test_wrong_text_is_refused_by_name(query: dict[str, str]) -> None:
    error = refusal(ROWS, CSV, query=query)
    assert (error.status, error.kind) == (422, "invalid-parameter")
    assert places(error) == [["query", *query]]


def test_a_parameter_may_not_come_twice() -> None:
    pairs = [("epsilon", "1"), ("epsilon", "2")]
    assert places(refusal(ROWS, CSV, query=pairs)) == [["query", "epsilon"]]


def test_include_may_be_repeated_and_listed() -> None:
    _, include = read_query([("include", "stages"), ("include", "graph, tape")], PcaParameters)
    assert include == ["stages", "graph", "tape"]
    assert read(ROWS, CSV, query={"include": "stages"}).include == {"stages"}


def test_an_unknown_name_in_include_is_refused() -> None:
    error = refusal(ROWS, CSV, query={"include": "everything"})
    assert (error.status, places(error)) == (422, [["query", "include"]])


def test_the_form_of_the_answer_is_no_parameter() -> None:
    assert read(ROWS, CSV, query={"format": "svg"}).parameters == PcaParameters()


def test_body_and_query_add_up() -> None:
    body = dumped(points=[[0, 0], [1, 1]], parameters={"epsilon": 2}, include=["stages"])
    submission = read(body, query={"seed": "5", "include": "stages"})
    assert submission.parameters == PcaParameters(epsilon=2.0, seed=5)
    assert submission.include == {"stages"}


def test_a_parameter_in_body_and_query_is_ambiguous() -> None:
    error = refusal(dumped(points=[[0, 0]], parameters={"epsilon": 2}), query={"epsilon": "2"})
    assert places(error) == [["body", "parameters", "epsilon"]]
    assert "both" in error.detail
