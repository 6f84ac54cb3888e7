from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from core.surface.results import ContourLevel, Contours, Slices
from render.surfaces import contours, curve, slices
from service.render import encode, scene, stack_of
from service.render.scenes import ALARM, Scene, Sheet
from service.render.stacks import MOST_LEVELS

each = pytest.mark.parametrize("made", [contours, slices], ids=["contours", "slices"])


def sheet(result: Contours | Slices) -> Sheet:
    shown = scene(result)
    assert isinstance(shown, Sheet)
    return shown


def extent(one: Scene) -> np.ndarray:
    low, high = one.bounds()
    return high - low


@each
def test_the_stack_comes_first_and_single_levels_follow(made: Any) -> None:
    shown = sheet(made())
    assert list(shown.panels) == ["stack", "level-0", "level-1", "level-2", "level-3"]
    assert shown.title == "5 levels"
    assert shown.panels["level-2"].title == "Level 2, height 1"


@each
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 2.0, 2.0), (0.0, 0.0, -1.0)])
def test_the_stack_stands_upright_along_any_axis(made: Any, axis: tuple[float, float, float]) -> None:
    usual, turned = stack_of(made()), stack_of(made(axis=axis))
    assert extent(turned) == pytest.approx(extent(usual))
    heights = [area.rings[0][:, 1].mean() for area in turned.areas]
    assert heights == sorted(heights)


@each
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, 2.0)])
def test_single_levels_are_seen_from_above_to_scale(made: Any, axis: tuple[float, float, float]) -> None:
    level = sheet(made(axis=axis)).panels["level-0"]
    assert extent(level) == pytest.approx([1.0 if made is contours else 1.5, 1.0], abs=0.1)  # bands stick out


@each
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_everything_lies_in_the_box(made: Any, offset: float) -> None:
    shown = sheet(made(offset=offset))
    low, high = shown.bounds()
    for one in shown.panels.values():
        least, most = one.bounds()
        assert (least >= low - 1e-9 * offset - 1e-9).all()
        assert (most <= high + 1e-9 * offset + 1e-9).all()


def test_plates_lie_on_those_below_and_completed_ones_are_told() -> None:
    areas = stack_of(contours()).areas
    assert [area.name for area in areas] == ["contours", "completed", "contours", "contours"]
    assert len({area.colour for area in areas}) == 2
    assert "completed" in sheet(contours()).panels["level-1"].title


def test_nested_contours_leave_holes() -> None:
    ring = contours().slices[0].curves[0].vertices
    middle = ring.mean(axis=0)
    nested = ContourLevel(0.0, (curve(ring), curve(middle + 0.5 * (ring - middle))))
    (area,) = stack_of(Contours(np.array([0.0, 0.0, 1.0]), (nested,))).areas
    assert len(area.rings) == 2


def test_open_contours_are_an_alarm() -> None:
    ring = contours().slices[0].curves[0].vertices
    result = Contours(np.array([0.0, 0.0, 1.0]), (ContourLevel(0.0, (curve(ring, closed=False),)),))
    stack = stack_of(result)
    assert not stack.areas
    (path,) = stack.paths
    assert (path.closed, path.colour) == (False, ALARM)


def test_completed_levels_are_among_those_shown() -> None:
    made = contours(60)
    levels = tuple(replace(one, completed=k in {17, 18, 43}) for k, one in enumerate(made.slices))
    shown = sheet(replace(made, slices=levels))
    assert {"level-17", "level-18", "level-43"} <= set(shown.panels)
    assert len(shown.panels) == 8


@each
def test_of_very_many_levels_some_are_drawn_and_it_says_so(made: Any) -> None:
    result = made(2 * MOST_LEVELS)
    stack, expected = stack_of(result), stack_of(replace(result, slices=result.slices[::3]))
    assert stack.title == f"{2 * MOST_LEVELS + 1} levels, one in 3 drawn"
    for drawn, wanted in zip(stack.areas, expected.areas, strict=True):
        assert np.allclose(drawn.rings[0], wanted.rings[0])
    for group, other in zip(stack.segments, expected.segments, strict=True):
        assert np.allclose(group.ends, other.ends)


def test_vertices_that_nobody_would_see_are_left_out() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 20_000, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    result = Contours(np.array([0.0, 0.0, 1.0]), (ContourLevel(0.0, (curve(ring),)),))
    (area,) = stack_of(result).areas
    assert 50 < len(area.rings[0]) < 200
    usual = stack_of(replace(result, slices=(ContourLevel(0.0, (curve(ring[::50]),)),)))
    assert extent(stack_of(result)) == pytest.approx(extent(usual), rel=1e-3)


@each
@pytest.mark.parametrize("form", ["svg", "png"])
@pytest.mark.parametrize(("scale", "offset"), [(1e-90, 0.0), (1e90, 0.0), (1.0, 1e9)])
def test_any_size_and_place_gives_a_picture(made: Any, form: str, scale: float, offset: float) -> None:
    assert encode(made(scale=scale, offset=offset), form)


@each
@pytest.mark.parametrize("form", ["svg", "png"])
def test_nothing_gives_a_picture(made: Any, form: str) -> None:
    assert encode(made(0), form)


def test_a_picture_of_vectors_shows_every_level_as_a_plate() -> None:
    root = ET.fromstring(encode(contours(), "svg"))  # noqa: S314 # our own
    plates = [path for path in root.iter("{http://www.w3.org/2000/svg}path") if path.get("class") == "area"]
    assert len(plates) == 4
    places = np.concatenate(
        [np.array(re.findall(r"-?\d+\.\d+", path.get("d", "")), float).reshape(-1, 2) for path in plates]
    )
    assert (np.ptp(places, axis=0) > 100).all()


def test_plates_are_seen_in_their_colours() -> None:
    with Image.open(BytesIO(encode(contours(), "png"))) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    for colour in {area.colour for area in stack_of(contours()).areas}:
        wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
        assert (np.abs(pixels - wanted).max(axis=2) < 8).sum() > 1000
