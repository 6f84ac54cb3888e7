from __future__ import annotations

from itertools import chain

import numpy as np
import pytest

from render.results import cloud, reconstruction, skeleton
from service.render import scene
from service.render.scenes import Area, Band, Circle, Dots, Marks, Path, Scene, Segments, Sheet

BOX = np.array([[1.0, 2.0], [4.0, 6.0]])


@pytest.mark.parametrize(
    "shown",
    [
        Scene("", areas=(Area((BOX[:1], BOX), "#000000"),)),
        Scene("", segments=(Segments(BOX[None], "#000000"),)),
        Scene("", dots=(Dots(BOX, "#000000"), Dots(np.empty((0, 2)), "#000000"))),
        Scene("", circles=(Circle(2.0, 3.0, 1.0), Circle(3.0, 5.0, 1.0))),
        Scene("", bands=(Band((BOX[:1], BOX), "#000000"),)),
        Scene("", paths=(Path(BOX, False, "#000000", 0, ""),)),
        Scene("", marks=(Marks(BOX, "#000000"),)),
    ],
    ids=["areas", "segments", "dots", "circles", "bands", "paths", "marks"],
)
def test_the_bounds_hold_each_kind_of_shape(shown: Scene) -> None:
    assert np.array_equal(shown.bounds(), BOX)


def test_nothing_lies_in_a_unit_square() -> None:
    assert np.array_equal(Scene("").bounds(), [[0, 0], [1, 1]])


def test_the_bounds_hold_everything() -> None:
    shown = scene(reconstruction(stages=True), cloud())
    assert isinstance(shown, Scene)
    low, high = shown.bounds()
    for points in [*(group.points for group in shown.dots), *(path.vertices for path in shown.paths)]:
        assert (points >= low).all()
        assert (points <= high).all()
    for circle in shown.circles:
        assert low[0] <= circle.x - circle.radius
        assert circle.y + circle.radius <= high[1]


def test_a_sheet_shows_what_its_last_picture_does() -> None:
    sheet = scene(skeleton(stages=True), cloud())
    assert isinstance(sheet, Sheet)
    assert np.array_equal(sheet.bounds(), sheet.panels["curves"].bounds())
    rings = chain.from_iterable(area.rings for area in sheet.panels["tape"].areas)
    low, high = sheet.bounds()
    for ring in rings:
        assert (low <= ring).all()
        assert (ring <= high).all()


@pytest.mark.parametrize(("width", "columns"), [(0.2, 4), (1.0, 4), (3.0, 2)])
def test_wide_pictures_have_fewer_columns(width: float, columns: int) -> None:
    panel = Scene("", dots=(Dots(np.array([[0.0, 0.0], [width, 1.0]]), "#000000"),))
    assert Sheet("", {"a": panel, "b": panel}).columns == columns


def test_the_key_has_a_colour_for_each_name() -> None:
    shown = Scene(
        "",
        areas=(Area((BOX,), "#111111", "#FFFFFF", "tape"), Area((BOX,), "#111111", "#FFFFFF", "tape")),
        dots=(Dots(BOX, "#222222"),),
        circles=(Circle(0.0, 0.0, 1.0), Circle(0.0, 0.0, 1.0, "#444444", "noise")),
        marks=(Marks(BOX, "#333333", "crossings"),),
        paths=(Path(BOX, False, "#000000", 0, "curve 0"),),
    )
    assert shown.key() == {"tape": "#111111", "noise": "#444444", "crossings": "#333333"}
