from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from intake.reading import CSV, places, read, refusal

TABLE = np.array([[1.0, 2.0], [3.5, -4.0], [0.0, 1e-9]])
FINITE = st.floats(allow_nan=False, allow_infinity=False)


def points(text: str | bytes, content_type: str = CSV) -> np.ndarray:
    return read(text if isinstance(text, bytes) else text.encode(), content_type).points


@given(
    hnp.arrays(np.float64, st.tuples(st.integers(1, 30), st.integers(2, 3)), elements=FINITE),
    st.sampled_from([",", ";", "\t", " ", "  ", ", ", " ; "]),
    st.sampled_from(["\n", "\r\n", "\r"]),
    st.booleans(),
    st.booleans(),
)
def test_every_way_of_writing_a_table_is_read(
    array: np.ndarray, separator: str, end: str, named: bool, noted: bool
) -> None:
    lines = [separator.join(map(repr, row)) for row in array.tolist()]
    if named:
        lines.insert(0, separator.join("xyz"[: array.shape[1]]))
    if noted:
        lines = ["# a note", "", *(f"{line}  # so" for line in lines), "", "   "]
    assert np.array_equal(points(end.join(lines)), array)


@pytest.mark.parametrize(
    "text",
    [
        "y,x\n2,1\n-4,3.5\n1e-9,0",
        "X, Y\n1,2\n3.5,-4\n0,1e-9",
        '"x","y"\n"1","2"\n"3.5","-4"\n"0","1e-9"',
        "id,y,label,x\n7,2,a,1\n8,-4,b,3.5\n9,1e-9,c,0",
        "\ufeffx,y\n1,2\n3.5,-4\n0,1e-9\n",
        "1;2\n3,5;-4,0\n0;1e-9",
        "x;y\n1,0;2,0\n3,5;-4\n0;1e-9",
        "+1,2.\n3.5,-4.00\n.0,1E-9",
        "  1 2\n 3.5 -4\n\t0   1e-9 ",
    ],
)
def test_headers_quotes_and_decimal_commas(text: str) -> None:
    assert np.array_equal(points(text), TABLE)


def test_columns_go_by_their_names_in_space_too() -> None:
    assert points("z,y,x\n3,2,1\n6,5,4").tolist() == [[1, 2, 3], [4, 5, 6]]


def test_plain_text_is_a_table_too() -> None:
    assert np.array_equal(points("1 2\n3.5 -4\n0 1e-9\n", "text/plain"), TABLE)


@pytest.mark.parametrize(
    "charset", ["utf-8", "UTF-8", "us-ascii", "iso-8859-1", "windows-1252", "utf-16", "utf-16-le"]
)
def test_charsets(charset: str) -> None:
    body = "x,y\n1,2\n3.5,-4\n0,1e-9\n".encode(charset)
    assert np.array_equal(points(body, f'text/csv; charset="{charset}"'), TABLE)


def test_text_that_is_not_in_its_charset_is_unreadable() -> None:
    error = refusal("1,2 # Größe".encode("latin-1"), CSV)
    assert (error.status, places(error)) == (400, [["body", 8]])


@pytest.mark.parametrize("charset", ["klingon", "hex", "punycode", "zip", "utf-7"])
def test_other_charsets_are_not_supported(charset: str) -> None:
    assert refusal(b"1,2", f"text/csv; charset={charset}").status == 415


@pytest.mark.parametrize(
    ("text", "place", "line"),
    [
        ("1,2\n3,abc\n", [1, 1], "line 2"),
        ("x,y\n1,2\n\n# note\n3,\n", [1, 1], "line 5"),
        ("1,2\n3,4\n5,nan", [2, 1], "line 3"),
        ("1,2\ninf,4", [1, 0], "line 2"),
        ("1,2\n3,1e400", [1, 1], "line 2"),
        ("1,2\n3,4,5\n6,7", [1], "line 2"),
        ("1,2\n3\n", [1], "line 2"),
        ("1,2\n1_0,3\n", [1, 0], "line 2"),
        ("1,2\n0x10,3\n", [1, 0], "line 2"),
        ("1,2\n１,3\n", [1, 0], "line 2"),
        ("1,2\nTrue,3\n", [1, 0], "line 2"),
        ("nan,2\n", [0, 0], "line 1"),
        ("1\n2\n", [0], "line 1"),
        ("1 2 3 4\n", [0], "line 1"),
        ("a,b\n1,2\n", [0], "line 1"),
        ("x,x,y\n1,2,3\n", [0], "line 1"),
        ("one, two\n", [0], "line 1"),
        ("x,y\n1,2\n3\n", [1], "line 3"),
    ],
)
def test_errors_name_the_point_and_the_line(text: str, place: list[int], line: str) -> None:
    error = refusal(text.encode(), CSV)
    assert (error.status, error.kind) == (422, "invalid-points")
    assert places(error)[0] == ["body", "points", *place]
    assert line in error.errors[0]["msg"]


@pytest.mark.parametrize("text", ["", "\n\n", "# only a note\n", "x,y\n", "x,y\n# nothing\n"])
def test_a_table_without_points_is_refused(text: str) -> None:
    assert places(refusal(text.encode(), CSV)) == [["body", "points"]]


def test_only_so_many_errors_are_listed() -> None:
    assert len(refusal(b"1,2\n" + b"a,b\n" * 100, CSV).errors) == 20


def test_a_long_row_of_digits_is_one_number_or_none() -> None:
    assert refusal(b"1,2\n" + b"1" * 100_000 + b"x,2\n", CSV).status == 422
    assert refusal(b"1" * 100_000 + b",2\n", CSV).status == 422


def test_the_text_of_a_table_is_not_echoed() -> None:
    assert "secret" not in str(vars(refusal(b"1,2\nsecret,3\n", CSV)))
