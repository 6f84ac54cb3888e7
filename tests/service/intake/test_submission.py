from __future__ import annotations

import pickle

import numpy as np
import pytest

from core.parameters import PcaParameters
from intake.reading import LIMITS, dumped, places, read, refusal
from service.intake import IntakeError, Limits, check_document

POINTS = [[0, 0], [1, 0.5]]


def test_parameters_and_include_may_be_left_out() -> None:
    submission = read(dumped(points=POINTS))
    assert submission.parameters == PcaParameters()
    assert submission.include == frozenset()


def test_parameters_and_include_are_read() -> None:
    submission = read(dumped(points=POINTS, parameters={"epsilon": 2, "refine": False}, include=["stages"]))
    assert submission.parameters == PcaParameters(epsilon=2.0, refine=False)
    assert submission.include == {"stages"}


@pytest.mark.parametrize(
    ("document", "place", "kind"),
    [
        ({}, ["points"], "invalid-points"),
        ({"points": POINTS, "colour": 1}, ["colour"], "invalid-input"),
        ({"points": POINTS, "parameters": None}, ["parameters"], "invalid-parameter"),
        ({"points": POINTS, "parameters": []}, ["parameters"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"epsilom": 1}}, ["parameters", "epsilom"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"epsilon": -1}}, ["parameters", "epsilon"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"epsilon": "1"}}, ["parameters", "epsilon"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"epsilon": True}}, ["parameters", "epsilon"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"refine": 1}}, ["parameters", "refine"], "invalid-parameter"),
        ({"points": POINTS, "parameters": {"seed": 1.5}}, ["parameters", "seed"], "invalid-parameter"),
        ({"points": POINTS, "include": "stages"}, ["include"], "invalid-input"),
        ({"points": POINTS, "include": ["stages", "all"]}, ["include", 1], "invalid-input"),
        ({"points": POINTS, "include": [1]}, ["include", 0], "invalid-input"),
    ],
)
def test_what_is_not_declared_is_refused_where_it_is(
    document: dict[str, object], place: list[str | int], kind: str
) -> None:
    error = refusal(dumped(**document))
    assert (error.status, error.kind) == (422, kind)
    assert places(error) == [["body", *place]]


def test_nothing_may_be_included_where_nothing_is_allowed() -> None:
    assert read(dumped(points=POINTS, include=[]), include=frozenset()).include == frozenset()
    assert places(refusal(dumped(points=POINTS, include=["stages"]), include=frozenset())) == [
        ["body", "include"]
    ]


def test_several_errors_are_told_together() -> None:
    error = refusal(dumped(points=[[1, "2"]], parameters={"epsilon": 0, "seed": -1}))
    assert places(error) == [
        ["body", "points", 0, 1],
        ["body", "parameters", "epsilon"],
        ["body", "parameters", "seed"],
    ]
    assert "and 2 more" in error.detail


def test_many_unknown_names_cost_no_more_than_some() -> None:
    excess = {f"p{number}": 0 for number in range(5000)}
    assert len(refusal(dumped(points=POINTS, **excess)).errors) == 20
    assert len(refusal(dumped(points=POINTS, parameters=excess)).errors) == 20


def test_a_point_more_than_allowed_is_too_many() -> None:
    rows = [[0.5, 0.25]] * 10
    assert len(read(dumped(points=rows), limits=Limits(10, 10_000)).points) == 10
    error = refusal(dumped(points=rows), limits=Limits(9, 10_000))
    assert (error.status, error.kind) == (413, "too-many-points")


def test_a_part_of_a_document_can_be_checked_with_its_own_place() -> None:
    document = {"points": np.array([[1.0, np.nan], [np.inf, 0.0]])}
    with pytest.raises(IntakeError) as caught:
        check_document(document, {}, PcaParameters, frozenset(), LIMITS, ("body", "inputs"))
    assert places(caught.value) == [["body", "inputs", "points", 0, 1], ["body", "inputs", "points", 1, 0]]


def test_the_document_of_the_caller_is_left_alone() -> None:
    document = {"points": POINTS, "parameters": {"epsilon": 1.0}}
    check_document(document, {"seed": "3"}, PcaParameters, frozenset(), LIMITS)
    assert document == {"points": POINTS, "parameters": {"epsilon": 1.0}}


def test_refusals_cross_process_borders() -> None:
    error = refusal(dumped(points=[[1, "2"]]))
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301 # our own
    assert vars(copy) == vars(error)
    assert str(copy) == str(error)
