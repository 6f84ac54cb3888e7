from __future__ import annotations

import pytest

from intake.reading import dumped, read, refusal
from service.intake import MEDIA_TYPES, media_type_of_name
from service.intake.media import parse_media_type

BODY = dumped(points=[[0, 0], [1, 1]])


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("a.json", ("application/json", None)),
        ("dir.gz/A.NPY", ("application/x-npy", None)),
        ("a.b.csv.gz", ("text/csv", "gzip")),
        ("a.xyz.zst", ("text/plain", "zstd")),
        ("a.gz", (None, "gzip")),
        ("a.stl", ("model/stl", None)),
        ("scan.PLY.gz", ("application/x-ply", "gzip")),
        ("a.las", (None, None)),
        ("-", (None, None)),
        ("", (None, None)),
    ],
)
def test_file_names_stand_for_media_types(name: str, found: tuple[str | None, str | None]) -> None:
    assert media_type_of_name(name) == found


@pytest.mark.parametrize(
    "header",
    ["application/json", "Application/JSON", "application/json; charset=utf-8", " application/json ;x=y"],
)
def test_spellings_of_a_media_type(header: str) -> None:
    assert len(read(BODY, header).points) == 2


_OTHERS = """
application/x-www-form-urlencoded application/xml json ; */* text/csv2 \u1234 application/json/x
multipart/mixed;boundary=x a/b;c*=klingon''%ff
"""


@pytest.mark.parametrize("header", [None, "", *_OTHERS.split()])
def test_other_media_types_are_told_what_is_read(header: str | None) -> None:
    error = refusal(BODY, header)
    assert (error.status, error.kind) == (415, "unsupported-media-type")


def test_the_answer_lists_the_media_types() -> None:
    assert all(name in refusal(BODY, "application/xml").detail for name in MEDIA_TYPES["points"])


def test_parameters_of_a_media_type() -> None:
    assert parse_media_type('text/CSV; Charset="UTF-8"; header=present') == (
        "text/csv",
        {"charset": "UTF-8", "header": "present"},
    )
