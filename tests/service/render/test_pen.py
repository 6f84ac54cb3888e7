from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from core.results import Ball, TapePolygon
from render.results import HOLE, OUTER, SQUARE, lifted, reconstruction
from service.render.pen import Pen
from service.render.scenes import COLOURS


def test_a_planar_set_is_drawn_as_it_is() -> None:
    assert np.array_equal(Pen.of([SQUARE])(OUTER), OUTER)


@pytest.mark.parametrize("scale", [1e-300, 1e-90, 1.0, 1e90, 1e300])
@pytest.mark.parametrize("dimension", [2, 3])
def test_units_bring_any_size_within_what_can_be_drawn(scale: float, dimension: int) -> None:
    places = lifted(SQUARE, dimension)
    pen = Pen.of([places * scale])
    assert np.allclose(pdist(pen(places * scale)) * (pen.unit / scale), pdist(places))


def test_a_tape_keeps_its_holes() -> None:
    (area,) = Pen.of([SQUARE]).tape([TapePolygon(OUTER, (HOLE,), 0)])
    assert [ring.tolist() for ring in area.rings] == [OUTER.tolist(), HOLE.tolist()]


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_ball_is_drawn_as_large_as_it_is(dimension: int) -> None:
    places = lifted(SQUARE, dimension)
    circle = Pen.of([places]).circle(Ball(places[1], 0.25, places[0], 3, 0))
    assert circle.radius == 0.25
    assert [circle.x, circle.y] == pytest.approx(Pen.of([places])(places)[1].tolist())


def test_curves_have_colours_by_their_numbers_and_dashes_when_those_are_used_up() -> None:
    pen, curve = Pen.of([SQUARE]), reconstruction().curves[0]
    drawn = [pen.curve(number, curve) for number in range(len(COLOURS) + 1)]
    assert [path.colour for path in drawn] == [*COLOURS, COLOURS[0]]
    assert [path.turn for path in drawn] == [0] * len(COLOURS) + [1]
    assert drawn[0].name == "curve 0 (closed)"


def test_crossings_are_marked_where_there_are_any() -> None:
    made = reconstruction()
    (marks,) = Pen.of([SQUARE]).crossings(made.crossings)
    assert marks.points.tolist() == [SQUARE[1].tolist()]
    assert Pen.of([SQUARE]).crossings([]) == ()
