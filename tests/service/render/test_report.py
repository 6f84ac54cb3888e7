from __future__ import annotations

import dataclasses

import pytest

from core.results import Diagnosis, Violation
from render.results import SQUARE, diagnosis, reconstruction
from service.render import encode


def text(result: Diagnosis) -> str:
    return encode(result, "txt").decode()


def words(result: Diagnosis) -> str:
    return " ".join(text(result).split())


def test_the_verdict_comes_first_then_what_is_wrong_then_the_figures() -> None:
    report = text(diagnosis())
    places = [report.index(part) for part in ("not good enough", "What is wrong", "noise", "component")]
    assert places == sorted(places)
    assert report.startswith("The samples are not good enough.")


def test_every_figure_is_told() -> None:
    told = words(diagnosis())
    for part in (
        "- Narrow. Scan denser here.",
        "the PCA march. fits better",
        "1 closed, 1 open, 1 crossing noise",
        "sigma 0.01 ± 0.001; along curve 0 from 0.01 to 0.02",
        "20 samples per unit of length",
        "1.5 sigma apart, near (2, 0)",
        "0.4, 8.0 mean distances between samples (chance alone: up to 9.5)",
        "outliers 2",
        "few points",
    ):
        assert part in told


def test_a_component_has_a_line_where_there_are_several() -> None:
    made = diagnosis()
    assert "component" in text(made)
    one = dataclasses.replace(made.sampling, components=made.sampling.components[:1])
    assert "component " not in text(dataclasses.replace(made, sampling=one))


def test_what_is_not_known_is_not_told() -> None:
    made = diagnosis()
    nyquist = dataclasses.replace(
        made.sampling.nyquist, compliant=True, margin_sigmas=None, margin_location=None, violations=()
    )
    sampling = dataclasses.replace(
        made.sampling, nyquist=nyquist, sigma_error=None, sigma_along=(), largest_gap=None
    )
    told = words(dataclasses.replace(made, sampling=sampling, warnings=()))
    assert "sigma 0.01 density" in told
    assert "none come near each other" in told
    assert not {"wrong", "None", "gap", "Warnings", "±"} & set(told.split())


def test_very_many_violations_are_counted() -> None:
    made = diagnosis()
    many = tuple(Violation(SQUARE[1], float(k), "narrow") for k in range(25))
    nyquist = dataclasses.replace(made.sampling.nyquist, violations=many)
    sampling = dataclasses.replace(made.sampling, nyquist=nyquist)
    report = text(dataclasses.replace(made, sampling=sampling))
    assert report.count("Narrow") == 10
    assert "and 15 more" in report


@pytest.mark.parametrize("dimension", [2, 3])
def test_lines_fit_on_a_screen(dimension: int) -> None:
    assert max(map(len, text(diagnosis(dimension)).splitlines())) <= 100


def test_a_result_of_another_type_has_no_report() -> None:
    with pytest.raises(TypeError, match="Reconstruction"):
        encode(reconstruction(), "txt")
