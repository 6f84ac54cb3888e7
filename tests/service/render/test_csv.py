from __future__ import annotations

import csv
import dataclasses
import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from core.parameters import PcaParameters
from render.results import cloud, partition, reconstruction
from service.intake import Limits, decode
from service.render import encode, points_table

CLOUDS = hnp.arrays(
    np.float64,
    st.tuples(st.integers(1, 20), st.integers(2, 3)),
    elements=st.floats(allow_nan=False, allow_infinity=False),
)


def rows(text: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text.decode())))


def reread(text: bytes) -> np.ndarray:
    return decode(text, "text/csv", None, {}, PcaParameters, frozenset(), Limits(10**6, 10**8)).points


@given(CLOUDS)
def test_points_read_back_to_the_same_floats(points: np.ndarray) -> None:
    assert np.array_equal(reread(points_table(points)), points)


@given(CLOUDS)
def test_a_partition_reads_back_to_points_and_labels(points: np.ndarray) -> None:
    result = partition(points)
    text = encode(result, "csv", points)
    assert np.array_equal(reread(text), points)
    assert [int(row["label"]) for row in rows(text)] == result.labels.tolist()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_reconstruction_has_a_line_for_each_vertex(dimension: int) -> None:
    result = reconstruction(dimension)
    text = encode(result, "csv")
    assert text.splitlines()[0] == (b"curve,x,y" if dimension == 2 else b"curve,x,y,z")
    assert [int(row["curve"]) for row in rows(text)] == [0, 0, 0, 0, 1, 1]
    assert np.array_equal(reread(text), np.vstack([curve.vertices for curve in result.curves]))


def test_nothing_is_a_table_with_a_head() -> None:
    nothing = dataclasses.replace(reconstruction(), curves=())
    assert encode(nothing, "csv") == b"curve,x,y\n"
    assert encode(nothing, "csv", cloud(5, 3)) == b"curve,x,y,z\n"
    assert points_table(np.empty((0, 2))) == b"x,y\n"
    assert encode(partition(np.empty((0, 2)), 0), "csv", np.empty((0, 2))) == b"x,y,label\n"


def test_a_partition_needs_its_points() -> None:
    with pytest.raises(TypeError, match="points"):
        encode(partition(cloud()), "csv")
