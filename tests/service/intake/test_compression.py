from __future__ import annotations

import gzip
import importlib.util
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from intake.reading import dumped, read, refusal
from service.intake import Limits, decompress

BODY = dumped(points=[[0.5, 1.5], [2.5, 3.5]])


@given(st.binary(max_size=500), st.sampled_from(["gzip", "x-gzip", " GZIP "]))
def test_gzip_is_undone(body: bytes, name: str) -> None:
    assert decompress(gzip.compress(body), name, 500) == body


@pytest.mark.parametrize("name", [None, "", "identity", " Identity "])
def test_no_encoding_changes_nothing(name: str | None) -> None:
    assert decompress(BODY, name, 1000) == BODY


def test_a_file_of_several_members_is_one_body() -> None:
    assert decompress(gzip.compress(b"one ") + gzip.compress(b"two"), "gzip", 100) == b"one two"


def test_points_come_compressed() -> None:
    assert np.array_equal(read(gzip.compress(BODY), encoding="gzip").points, [[0.5, 1.5], [2.5, 3.5]])


@pytest.mark.parametrize(
    "body",
    [
        b"not gzip",
        gzip.compress(BODY)[:-5],
        gzip.compress(BODY)[:12],
        gzip.compress(BODY) + b"junk",
        gzip.compress(BODY)[:-8] + bytes(8),
        zlib.compress(BODY),
    ],
)
def test_broken_data_are_unreadable(body: bytes) -> None:
    assert refusal(body, encoding="gzip").status == 400


def test_the_limit_holds_before_and_after() -> None:
    limits = Limits(max_points=100, max_bytes=len(BODY))
    assert len(read(BODY, limits=limits).points) == 2
    assert refusal(BODY + b" ", limits=limits).kind == "too-many-bytes"
    assert len(read(gzip.compress(BODY), encoding="gzip", limits=Limits(100, 100)).points) == 2
    assert refusal(gzip.compress(BODY + b" " * 100), encoding="gzip", limits=Limits(100, 100)).status == 413


def test_a_bomb_stops_at_the_limit() -> None:
    bomb = gzip.compress(bytes(50_000_000))
    error = refusal(bomb, encoding="gzip", limits=Limits(100, 100_000))
    assert (error.status, error.kind) == (413, "too-many-bytes")


def test_an_endless_row_of_empty_members_is_sound() -> None:
    assert decompress(gzip.compress(b"") * 500, "gzip", 100_000) == b""


@pytest.mark.parametrize("name", ["br", "deflate", "gzip, gzip", "aes128gcm"])
def test_other_encodings_are_not_supported(name: str) -> None:
    error = refusal(BODY, encoding=name)
    assert (error.status, error.kind) == (415, "unsupported-content-encoding")
    assert "gzip" in error.detail


def test_zstd_works_where_the_standard_library_has_it() -> None:
    if importlib.util.find_spec("compression"):
        zstd = importlib.import_module("compression.zstd")
        packed = zstd.compress(BODY)
        assert decompress(packed, "zstd", 1000) == BODY
        assert refusal(packed[:-3], encoding="zstd").status == 400
        assert refusal(zstd.compress(bytes(10**6)), encoding="zstd", limits=Limits(9, 1000)).status == 413
    else:
        assert "3.14" in refusal(BODY, encoding="zstd").detail
        assert refusal(BODY, encoding="zstd").status == 415
