from __future__ import annotations

import pytest

from service.intake import IntakeError
from service.render import FORMS, negotiate

ALL = ("json", "geojson", "csv", "svg", "png")
FIREFOX = "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,image/png,image/svg+xml,*/*;q=0.8"


@pytest.mark.parametrize(
    ("accept", "form"),
    [
        (None, "json"),
        ("", "json"),
        ("*/*", "json"),
        ("application/json", "json"),
        ("application/*", "json"),
        ("application/geo+json", "geojson"),
        ("image/*", "svg"),
        ("IMAGE/PNG", "png"),
        ("text/*", "csv"),
        ("text/csv;header=present, */*;q=0.1", "csv"),
        ("application/json;q=0.5, text/csv;q=0.6", "csv"),
        ("application/json;q=0.5, text/csv", "csv"),
        ("*/*;q=0.2, image/png;q=0.3", "png"),
        ("*/*, application/json;q=0", "geojson"),
        ("image/*, image/svg+xml;q=0.1", "png"),
        ("application/pdf, image/png;q=0.1", "png"),
        ("text/csv;q=nonsense, image/png;q=0.1", "png"),
        ("image/png, image/svg+xml", "svg"),
        (FIREFOX, "json"),
        ("text/html, */*", "json"),
        ("image/avif,image/webp,image/png,image/svg+xml,image/*;q=0.8,*/*;q=0.5", "svg"),
    ],
)
def test_accept_chooses(accept: str | None, form: str) -> None:
    assert negotiate(accept, None, ALL) == form


@pytest.mark.parametrize("form", ALL)
def test_format_wins(form: str) -> None:
    assert negotiate("image/avif", form, ALL) == form
    assert negotiate(FORMS["json"], f" {form.upper()} ", ALL) == form


@pytest.mark.parametrize(
    "accept",
    ["text/html", "application/pdf", "image/avif;q=1", "*/*;q=0", "json", "application/json;q=0", ",", "q=1"],
)
def test_what_is_not_offered_is_not_acceptable(accept: str) -> None:
    with pytest.raises(IntakeError) as caught:
        negotiate(accept, None, ALL)
    assert (caught.value.status, caught.value.kind) == (406, "not-acceptable")
    assert all(FORMS[form] in caught.value.detail for form in ALL)


def test_a_form_of_other_answers_is_not_acceptable() -> None:
    with pytest.raises(IntakeError) as caught:
        negotiate(None, "png", ("json", "csv"))
    assert caught.value.status == 406
    assert "format=csv" in caught.value.detail


def test_a_form_that_does_not_exist_is_a_wrong_value() -> None:
    with pytest.raises(IntakeError) as caught:
        negotiate(None, "bmp", ALL)
    assert (caught.value.status, caught.value.errors[0]["loc"]) == (422, ["query", "format"])
