from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import ezdxf
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from render.results import LINE, SQUARE, lifted, reconstruction, skeleton
from service.render import encode
from service.render.dxf import Line, lines, write_dxf

finite = st.floats(-1e300, 1e300)


def read(content: bytes) -> Any:
    """Read as another program does, which has nothing to mend."""
    document = ezdxf.read(io.StringIO(content.decode("ascii")))
    audit = document.audit()
    assert (audit.errors, audit.fixes) == ([], [])
    return document


def drawn(content: bytes) -> list[Any]:
    return list(read(content).modelspace())


def places(entity: Any) -> list[tuple[float, ...]]:
    return [tuple(vertex.dxf.location) for vertex in entity.vertices]


@pytest.mark.parametrize("dimension", [2, 3])
def test_curves_read_back_as_they_are(dimension: int) -> None:
    result = reconstruction(dimension)
    entities = drawn(encode(result, "dxf"))
    assert [entity.is_closed for entity in entities] == [curve.closed for curve in result.curves]
    for entity, curve in zip(entities, result.curves, strict=True):
        assert np.array_equal(np.array(places(entity))[:, :dimension], curve.vertices)
        assert entity.dxf.layer == f"COMPONENT_{curve.component}"


def test_flat_polylines_lie_in_their_plane_and_others_in_space() -> None:
    level = np.column_stack([SQUARE, np.full(4, 7.25)])
    tilted = lifted(SQUARE, 3)
    flat, raised, space = drawn(
        write_dxf([Line("A", SQUARE, True), Line("B", level, False), Line("C", tilted, True)])
    )
    assert [one.is_2d_polyline for one in (flat, raised, space)] == [True, True, False]
    assert space.is_3d_polyline
    assert [one.dxf.elevation.z for one in (flat, raised)] == [0.0, 7.25]
    assert [tuple(point) for point in raised.points_in_wcs()] == [tuple(row) for row in level.tolist()]


@given(
    arrays.arrays(float, st.tuples(st.integers(1, 20), st.sampled_from([2, 3])), elements=finite),
    st.booleans(),
)
def test_every_number_is_kept_to_the_last_digit(vertices: np.ndarray, closed: bool) -> None:
    (entity,) = drawn(write_dxf([Line("CURVE", vertices, closed)]))
    read_back = np.array(places(entity))
    assert entity.is_closed == closed
    assert np.array_equal(read_back[: len(vertices), : vertices.shape[1]], vertices)
    assert len(read_back) == max(2, len(vertices))


def test_each_component_has_a_layer_with_a_colour_of_its_own() -> None:
    document = read(encode(reconstruction(curves=5), "dxf"))
    layers = [document.layers.get(f"COMPONENT_{k}") for k in range(5)]
    assert len({layer.dxf.color for layer in layers}) == 5


def test_the_extent_is_told_so_that_programs_show_all() -> None:
    document = read(write_dxf([Line("A", LINE, False), Line("B", SQUARE + 5.0, True)]))
    assert tuple(document.header["$EXTMIN"]) == (0.0, 0.1, 0.0)
    assert tuple(document.header["$EXTMAX"]) == (7.0, 6.0, 0.0)


def test_nothing_is_an_empty_drawing() -> None:
    assert drawn(encode(replace(reconstruction(), curves=()), "dxf")) == []
    assert drawn(write_dxf([Line("EMPTY", np.empty((0, 3)), True)])) == []


def test_the_same_result_gives_the_same_file() -> None:
    assert encode(skeleton(), "dxf") == encode(skeleton(), "dxf")


def test_what_has_no_curves_has_no_drawing() -> None:
    with pytest.raises(TypeError, match="no drawing"):
        lines(object())
