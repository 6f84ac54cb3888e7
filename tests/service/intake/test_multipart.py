from __future__ import annotations

import gzip
from io import BytesIO

import httpx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.parameters import PcaParameters
from intake.reading import dumped, places, read, refusal
from service.intake import Submission
from service.intake.multipart import split_form

CSV = b"x,y\n1,2\n3,4\n"
POINTS = [[1, 2], [3, 4]]


def npy() -> bytes:
    file = BytesIO()
    np.save(file, np.array(POINTS))
    return file.getvalue()


def form(files: object, data: dict[str, str] | None = None) -> tuple[bytes, str]:
    """Encode a form as a client does."""
    request = httpx.Request("POST", "http://localhost/", files=files, data=data)  # type: ignore[arg-type] # httpx's union
    return request.read(), request.headers["content-type"]


def send(files: object, data: dict[str, str] | None = None) -> Submission:
    return read(*form(files, data))


@pytest.mark.parametrize(
    ("name", "content", "media_type"),
    [
        ("cloud.csv", CSV, "text/csv"),
        ("cloud.csv", CSV, "application/octet-stream"),
        ("CLOUD.CSV", CSV, "application/octet-stream"),
        ("cloud", CSV, "text/csv; charset=utf-8"),
        ("cloud.xyz", b"1 2\n3 4\n", "chemical/x-xyz"),
        ("cloud.txt", b"1 2\n3 4\n", "text/plain"),
        ("cloud.npy", npy(), "application/octet-stream"),
        ("data.bin", npy(), "application/x-npy"),
        ("cloud.json", dumped(points=POINTS), "application/json"),
        ("cloud.csv.gz", gzip.compress(CSV), "application/gzip"),
        ("cloud.csv.gz", gzip.compress(CSV), "text/csv"),
        ("wolke größe.csv", CSV, "application/octet-stream"),
    ],
)
def test_a_file_is_read_by_its_type_or_its_name(name: str, content: bytes, media_type: str) -> None:
    assert send({"file": (name, content, media_type)}).points.tolist() == POINTS


def test_parameters_are_json() -> None:
    submission = send({"file": ("a.csv", CSV)}, {"parameters": '{"epsilon": 0.5, "refine": false}'})
    assert submission.parameters == PcaParameters(epsilon=0.5, refine=False)


def test_a_json_file_may_bring_its_parameters() -> None:
    body = dumped(points=POINTS, parameters={"seed": 4}, include=["stages"])
    submission = send({"file": ("a.json", body)})
    assert submission.parameters == PcaParameters(seed=4)
    assert submission.include == {"stages"}


def test_parameters_may_not_come_from_two_places() -> None:
    body = dumped(points=POINTS, parameters={"seed": 4})
    assert refusal(*form({"file": ("a.json", body)}, {"parameters": "{}"})).status == 422


@pytest.mark.parametrize(
    ("files", "data", "status", "place"),
    [
        ({"cloud": ("a.csv", CSV)}, None, 422, ["cloud"]),
        ({"file": ("a.csv", CSV)}, {"epsilon": "1"}, 422, ["epsilon"]),
        ([("file", ("a.csv", CSV)), ("file", ("b.csv", CSV))], None, 422, ["file"]),
        ({"parameters": (None, "{}")}, None, 422, ["file"]),
        ({"file": ("a.pdf", CSV, "application/pdf")}, None, 415, ["file"]),
        ({"file": ("a.csv", CSV)}, {"parameters": "{"}, 400, ["parameters", 1]),
        ({"file": ("a.csv", CSV)}, {"parameters": "[]"}, 422, ["parameters"]),
        ({"file": ("a.csv", CSV)}, {"parameters": '{"epsilon": -1}'}, 422, ["parameters", "epsilon"]),
        ({"file": ("a.csv", b"1,2\n3,x\n")}, None, 422, ["points", 1, 1]),
    ],
)
def test_wrong_forms_are_refused_where_they_are_wrong(
    files: object, data: dict[str, str] | None, status: int, place: list[str | int]
) -> None:
    error = refusal(*form(files, data))
    assert error.status == status
    assert places(error)[0] == ["body", *place]


def test_a_form_cannot_hold_a_form() -> None:
    body, content_type = form({"file": ("a.csv", CSV)})
    assert refusal(*form({"file": ("inner", body, content_type)})).status == 415


@given(st.integers(0, 200))
def test_a_form_cut_off_anywhere_is_refused(length: int) -> None:
    body, content_type = form({"file": ("a.csv", CSV)})
    assert refusal(body[: min(length, len(body) - 4)], content_type).status == 400


@pytest.mark.parametrize("content_type", ["multipart/form-data", "multipart/form-data; boundary=other"])
def test_the_boundary_must_be_the_one_of_the_body(content_type: str) -> None:
    body, _ = form({"file": ("a.csv", CSV)})
    assert refusal(body, content_type).status == 400


def test_a_form_of_very_many_fields_is_refused() -> None:
    body, content_type = form([(f"f{number}", ("a", b"")) for number in range(100)])
    assert refusal(body, content_type).status == 400


def test_fields_come_in_order_with_what_they_say() -> None:
    body, content_type = form([("file", ("a.csv", CSV, "text/csv"))], {"parameters": "{}"})
    parts = split_form(body, content_type.partition("boundary=")[2])
    assert [(part.name, part.filename, part.content_type, part.content) for part in parts] == [
        ("parameters", "", "", b"{}"),
        ("file", "a.csv", "text/csv", CSV),
    ]
