from __future__ import annotations

import gc

import numpy as np
import pytest

from intake.reading import dumped, places, read, refusal
from service.intake import load_json, paused_collector

SQUARE = [[0, 0], [1, 0], [1.5, 1], [0, 1]]


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"  ",
        b"{",
        b'{"points": [[1, 2]',
        b'{"points": [[NaN, 2]]}',
        b'{"points": [[1, -Infinity]]}',
        b'{"points": [[1, 2]]} trailing',
        b'{"points": [[1., 2]]}',
        b'{"points": [[01, 2]]}',
        b'{"points": "\xff"}',
        b"[" * 100_000,
        b'{"a":' * 2000,
        '{"points": [[1, 2]]}'.encode("utf-16"),
    ],
)
def test_what_is_not_json_is_unreadable(body: bytes) -> None:
    error = refusal(body)
    assert (error.status, error.kind) == (400, "unreadable-body")
    assert places(error)[0][0] == "body"


def test_the_offset_of_a_syntax_error_is_told() -> None:
    assert places(refusal(b'{"points": [[1, x]]}')) == [["body", 16]]


def test_nan_is_named() -> None:
    assert "NaN and Infinity" in refusal(b'{"points": [[1, NaN]]}').detail


@pytest.mark.parametrize(
    "body",
    [
        b'{"points": [[1, 2]], "points": [[3, 4]]}',
        b'{"points": [[1, 2]], "parameters": {"epsilon": 1, "epsilon": 2}}',
        b'{"points": [[1, 2]], "parameters": {}, "parameters": {"epsilon": 2}}',
    ],
)
def test_a_member_that_comes_twice_has_no_meaning(body: bytes) -> None:
    error = refusal(body)
    assert error.status == 400
    assert "two members of the same name" in error.detail


def test_escaped_quotation_marks_are_no_second_members() -> None:
    assert load_json(rb'{"a": "say \"hello\" twice", "b\"c": "\""}') == {"a": 'say "hello" twice', 'b"c': '"'}


def test_a_byte_order_mark_is_skipped() -> None:
    assert np.array_equal(read(b"\xef\xbb\xbf" + dumped(points=SQUARE)).points, SQUARE)


@pytest.mark.parametrize("number", ["1e400", "-1e400", "9" * 400, "9" * 100_000])
def test_numbers_beyond_the_floats_are_values_out_of_range(number: str) -> None:
    error = refusal(f'{{"points": [[1, 2], [3, {number}]]}}'.encode())
    assert error.status == 422
    assert places(error) == [["body", "points", 1, 1]]


def test_integers_beyond_64_bits_are_numbers_still() -> None:
    assert (
        read(b'{"points": [[1, 123456789012345678901234567890]]}').points[0, 1]
        == 123456789012345678901234567890.0
    )


@pytest.mark.parametrize("body", [b"null", b"[]", b"3", b'"points"', b"true", b"[[1, 2]]"])
def test_a_document_that_is_no_object_is_refused(body: bytes) -> None:
    error = refusal(body)
    assert (error.status, places(error)) == (422, [["body"]])


def test_the_collector_is_as_before_after_a_pause() -> None:
    assert gc.isenabled()
    with paused_collector():
        assert not gc.isenabled()
        with paused_collector():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()


def test_the_collector_runs_again_after_a_refusal() -> None:
    refusal(b'{"points": 3}')
    assert gc.isenabled()
