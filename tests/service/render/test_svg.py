from __future__ import annotations

import dataclasses
import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from render.results import (
    HOLE,
    OUTER,
    SQUARE,
    cloud,
    diagnosis,
    partition,
    reconstruction,
    skeleton,
    without_curves,
)
from service.render import encode
from service.render.scenes import ALARM, COLOURS, GREY
from service.render.svg import MAX_DOTS

SVG = "{http://www.w3.org/2000/svg}"


def parsed(text: bytes) -> ET.Element:
    return ET.fromstring(text)  # noqa: S314 # our own


def kinds(root: ET.Element, kind: str) -> list[ET.Element]:
    return root.findall(f".//{SVG}path[@class='{kind}']")


def numbers(path: ET.Element) -> np.ndarray:
    return np.array(re.findall(r"-?\d+\.\d+", path.get("d", "")), float).reshape(-1, 2)


def test_curves_are_drawn_closed_or_open_in_colours_of_their_own() -> None:
    root = parsed(encode(reconstruction(), "svg", cloud()))
    closed, opened = kinds(root, "curve")
    assert closed.get("d", "").endswith("Z")
    assert not opened.get("d", "").endswith("Z")
    assert [closed.get("stroke"), opened.get("stroke")] == list(COLOURS[:2])
    (dots,) = kinds(root, "dots")
    assert dots.get("stroke") == GREY
    assert dots.get("d", "").count("M") == 50


@pytest.mark.parametrize("dimension", [2, 3])
def test_everything_lies_on_the_sheet(dimension: int) -> None:
    root = parsed(encode(reconstruction(dimension, stages=True), "svg", cloud(50, dimension)))
    _, _, width, height = map(float, root.get("viewBox", "").split())
    for path in root.iter(f"{SVG}path"):
        places = numbers(path)
        assert (places >= 0).all()
        assert (places <= [width, height]).all()


def test_scales_are_equal_and_y_points_up() -> None:
    square = numbers(kinds(parsed(encode(reconstruction(), "svg")), "curve")[0])
    right, up = square[1] - square[0], square[3] - square[0]
    assert right[0] == pytest.approx(-2 * up[1], abs=0.02)
    assert up[1] < 0 < right[0]


def test_balls_are_circles_of_their_size() -> None:
    root = parsed(encode(reconstruction(stages=True), "svg"))
    square = numbers(kinds(root, "curve")[0])
    scale = (square[1, 0] - square[0, 0]) / 2
    radii = [float(circle.get("r", "")) for circle in root.iter(f"{SVG}circle")]
    assert radii == pytest.approx([0.25 * scale, 0.5 * scale], abs=0.02)
    assert not list(parsed(encode(reconstruction(), "svg")).iter(f"{SVG}circle"))


def test_many_dots_are_thinned_out_the_same_way_each_time() -> None:
    points = cloud(3 * MAX_DOTS)
    text = encode(reconstruction(), "svg", points)
    assert text == encode(reconstruction(), "svg", points)
    (dots,) = kinds(parsed(text), "dots")
    assert dots.get("d", "").count("M") == MAX_DOTS
    assert str(MAX_DOTS) in (parsed(text).findtext(f"{SVG}desc") or "")


def test_few_dots_are_all_drawn() -> None:
    text = encode(partition(cloud(90), 2), "svg", cloud(90))
    groups = kinds(parsed(text), "dots")
    assert [group.get("stroke") for group in groups] == [GREY, *COLOURS[:2]]
    assert sum(group.get("d", "").count("M") for group in groups) == 90


def test_more_curves_than_colours_are_told_apart_by_dashes() -> None:
    root = parsed(encode(reconstruction(curves=3 * len(COLOURS)), "svg"))
    looks = {(path.get("stroke"), path.get("stroke-dasharray")) for path in kinds(root, "curve")}
    assert len(looks) == 3 * len(COLOURS)


def test_words_are_escaped() -> None:
    result = dataclasses.replace(reconstruction(), method="<b>&\"'")
    assert "<b>&\"'" in (parsed(encode(result, "svg")).findtext(f"{SVG}title") or "")


def test_the_tape_lies_below_the_cloud_and_its_hole_stays_empty() -> None:
    root = parsed(encode(skeleton(), "svg", cloud()))
    drawn = [path.get("class") for path in root.iter(f"{SVG}path")]
    assert drawn == ["area", "area", "dots", "band", "curve", "mark", "mark", "mark", "mark"]
    tape, _ = kinds(root, "area")
    assert tape.get("fill-rule") == "evenodd"
    assert tape.get("d", "").count("Z") == 2
    assert len(numbers(tape)) == len(OUTER) + len(HOLE)


def test_crossings_and_violations_are_marked_on_top() -> None:
    root = parsed(encode(reconstruction(), "svg", cloud()))
    square, marks = numbers(kinds(root, "curve")[0]), kinds(root, "mark")
    assert len(marks) == 4
    for mark in marks:
        assert numbers(mark)[0] == pytest.approx(square[1])
    assert {mark.get("stroke") for mark in marks[2:]} == {ALARM, "#FFFFFF"}
    assert marks[2].findtext(f"{SVG}title") == "branches too near"


def test_the_band_lies_beneath_its_curve_in_the_same_colour() -> None:
    root = parsed(encode(reconstruction(), "svg", cloud()))
    (band,) = kinds(root, "band")
    assert band.get("fill") == kinds(root, "curve")[0].get("stroke")
    assert 0 < float(band.get("fill-opacity", "")) < 1
    assert band.get("d", "").count("Z") == 2
    assert len(numbers(band)) == 2 * len(SQUARE)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_diagnosis_is_drawn_with_words_for_what_is_seen(dimension: int) -> None:
    root = parsed(encode(diagnosis(dimension), "svg", cloud(50, dimension)))
    told = [node.text for node in root.iter(f"{SVG}title")]
    assert {"2 sigma", "longest gap", "branches too near"} <= set(told)
    assert len(list(root.iter(f"{SVG}circle"))) == 3


def test_a_sheet_has_a_view_of_every_stage() -> None:
    root = parsed(encode(skeleton(stages=True), "svg", cloud()))
    panels = root.findall(f"{SVG}g[@class='panel']")
    views = root.findall(f"{SVG}view")
    assert [view.get("id") for view in views] == [
        "balls", "delaunay", "triangles", "tape", "border", "voronoi", "graph", "curves"
    ]  # fmt: skip
    _, _, width, height = map(float, root.get("viewBox", "").split())
    for view, panel in zip(views, panels, strict=True):
        x, y, w, h = map(float, view.get("viewBox", "").split())
        assert panel.get("transform") == f"translate({x:.2f} {y:.2f})"
        assert x + w <= width + 0.01
        assert y + h <= height + 0.01
        assert panel.findtext(f"{SVG}text")


def test_a_stage_says_what_its_colours_mean() -> None:
    root = parsed(encode(skeleton(stages=True), "svg", cloud()))
    triangles = root.findall(f"{SVG}g[@class='panel']")[2]
    _, key = triangles.findall(f"{SVG}text")
    assert "".join(key.itertext()).replace("■", "").split("  ")[0].strip() == "enclosed"
    areas = triangles.findall(f".//{SVG}path[@class='area']")
    assert [span.get("fill") for span in key.findall(f"{SVG}tspan")][:4] == [
        area.get("fill") for area in areas
    ]


def test_a_sheet_of_many_points_stays_small() -> None:
    points = cloud(5 * MAX_DOTS)
    assert len(encode(skeleton(stages=True), "svg", points)) < 60 * MAX_DOTS


EXTENTS = st.floats(-300, 290).map(lambda power: 10.0**power)


@given(EXTENTS, st.sampled_from([0.0, 1.0, 1e7, -1e12]), st.sampled_from([2, 3]))
def test_any_size_and_place_gives_a_sound_picture(extent: float, offset: float, dimension: int) -> None:
    result = reconstruction(dimension, scale=extent, offset=offset * extent)
    root = parsed(encode(result, "svg", cloud(20, dimension) * extent + offset * extent))
    for path in [*kinds(root, "curve"), *kinds(root, "band")]:
        assert np.isfinite(numbers(path)).all()
    assert "nan" not in (root.get("viewBox") or "")


@given(EXTENTS, st.sampled_from([2, 3]))
def test_a_diagnosis_of_any_size_gives_a_sound_picture(extent: float, dimension: int) -> None:
    root = parsed(encode(diagnosis(dimension, extent), "svg", cloud(20, dimension) * extent))
    assert all(np.isfinite(numbers(path)).all() for path in root.iter(f"{SVG}path"))
    assert "nan" not in (root.get("viewBox") or "")


@given(EXTENTS, st.sampled_from([0.0, 1.0, 1e7, -1e12]), st.sampled_from([2, 3]))
def test_stages_of_any_size_and_place_give_a_sound_sheet(
    extent: float, offset: float, dimension: int
) -> None:
    result = skeleton(dimension, True, scale=extent, offset=offset * extent)
    root = parsed(encode(result, "svg", cloud(20, dimension) * extent + offset * extent))
    assert all(np.isfinite(numbers(path)).all() for path in root.iter(f"{SVG}path"))
    assert "nan" not in (root.get("viewBox") or "")


@pytest.mark.parametrize(
    "points", [np.zeros((1, 2)), np.full((5, 2), 3e300), np.full((3, 3), -1e-320), np.empty((0, 2))]
)
def test_points_without_extent_give_a_sound_picture(points: np.ndarray) -> None:
    result = without_curves(reconstruction())
    assert "nan" not in parsed(encode(result, "svg", points)).get("viewBox", "nan")
