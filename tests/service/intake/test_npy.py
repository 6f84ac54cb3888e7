from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from intake.reading import NPY, places, read, refusal
from service.intake.errors import MAX_LISTED

NUMBERS = hnp.floating_dtypes() | hnp.integer_dtypes() | hnp.unsigned_integer_dtypes()
SHAPES = st.tuples(st.integers(1, 20), st.integers(2, 3))


def saved(array: object, *, version: tuple[int, int] | None = None) -> bytes:
    file = BytesIO()
    np.lib.format.write_array(file, np.asanyarray(array), version=version)
    return file.getvalue()


def header(text: str, numbers: bytes = b"", version: int = 1) -> bytes:
    size = len(text).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + size + text.encode() + numbers


@given(NUMBERS.flatmap(lambda dtype: hnp.arrays(dtype, SHAPES)), st.booleans())
def test_every_type_and_order_of_numbers_is_read(array: np.ndarray, turned: bool) -> None:
    if turned:
        array = np.asfortranarray(array)
    wanted = array.astype(np.float64)
    if np.isfinite(wanted).all():
        points = read(saved(array), NPY).points
        assert points.dtype == np.float64
        assert points.flags.c_contiguous
        assert points.flags.writeable
        assert np.array_equal(points, wanted)
    else:
        assert places(refusal(saved(array), NPY)) == [
            ["body", "points", *place] for place in np.argwhere(~np.isfinite(wanted))[:MAX_LISTED].tolist()
        ]


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_version_of_the_format_is_read(version: tuple[int, int]) -> None:
    array = np.arange(8.0).reshape(4, 2)
    assert np.array_equal(read(saved(array, version=version), NPY).points, array)


@given(st.integers(0, 200))
def test_a_file_cut_off_anywhere_is_unreadable(length: int) -> None:
    whole = saved(np.arange(10.0).reshape(5, 2))
    assert refusal(whole[: min(length, len(whole) - 1)], NPY).status == 400


def test_bytes_beyond_the_array_are_not_ignored() -> None:
    assert refusal(saved(np.ones((3, 2))) + b"\0", NPY).status == 400


@pytest.mark.parametrize(
    "array",
    [
        np.array([[True, False]]),
        np.array([[1j, 2]]),
        np.array([["a", "b"]]),
        np.array(["2020-01-01"], "M8[D]"),
        np.array([(1.0, 2.0)], [("x", "f8"), ("y", "f8")]),
    ],
)
def test_what_is_no_number_is_no_coordinate(array: np.ndarray) -> None:
    error = refusal(saved(array), NPY)
    assert (error.status, error.kind) == (422, "invalid-points")


@pytest.mark.parametrize("shape", [(), (4,), (0, 2), (2, 0), (3, 1), (3, 4), (2, 2, 2), (1,) * 20])
def test_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    assert refusal(saved(np.ones(shape)), NPY).status in {400, 422}


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_have_a_place(wrong: float) -> None:
    array = np.ones((30, 3))
    array[17, 1] = wrong
    assert places(refusal(saved(array), NPY)) == [["body", "points", 17, 1]]


def test_pickles_are_not_opened() -> None:
    file = BytesIO()
    np.save(file, np.array([[print, 1]], dtype=object), allow_pickle=True)
    assert refusal(file.getvalue(), NPY).status == 422


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"PK\x03\x04 an npz archive",
        b"\x93NUMPY",
        header("not a dictionary"),
        header("[1, 2]"),
        header("{'descr': '<f8', 'fortran_order': False}"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': 3}"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 2)}"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (True, 2)}", bytes(16)),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999, 2)}"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (" + "9" * 3000 + ", 2)}"),
        header("-" * 4000 + "1"),
        header("(" * 4000),
        header("[" * 90 + "]" * 90),
        header("{}" + " " * 10_000),
        header("{'descr': '<f8'}", version=2)[:11],
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}",
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2)}\xff"),
    ],
)
def test_broken_headers_are_unreadable(body: bytes) -> None:
    assert refusal(body, NPY).status == 400


@pytest.mark.parametrize("kind", ["<f3", "<f99", "<i5", "O", "|O8", "V16", "<f8,<f8"])
def test_odd_element_types_are_refused(kind: str) -> None:
    body = header(f"{{'descr': '{kind}', 'fortran_order': False, 'shape': (1, 2)}}", bytes(16))
    assert refusal(body, NPY).status == 422
