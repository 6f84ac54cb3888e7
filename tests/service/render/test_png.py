from __future__ import annotations

import dataclasses
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from core.results import Diagnosis, Partition, Reconstruction
from render.results import OUTER, cloud, diagnosis, partition, reconstruction, skeleton, without_curves
from service.render import encode, scene
from service.render.pen import TAPE
from service.render.scenes import ALARM, COLOURS, Sheet


def picture(result: Diagnosis | Partition | Reconstruction, points: np.ndarray | None = None) -> np.ndarray:
    with Image.open(BytesIO(encode(result, "png", points))) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(int)


def share(image: np.ndarray, colour: str) -> float:
    """Part of the picture that has very nearly this colour."""
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return float((np.abs(image - wanted).max(axis=2) <= 8).mean())


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stages", [False, True])
def test_curves_are_seen_in_their_colours(dimension: int, stages: bool) -> None:
    image = picture(reconstruction(dimension, stages), cloud(50, dimension))
    assert min(image.shape[:2]) >= 200
    assert all(share(image, colour) > 0.0005 for colour in COLOURS[:2])
    assert share(image, COLOURS[2]) == 0


def test_bands_and_violations_are_seen() -> None:
    made = reconstruction()
    wide = dataclasses.replace(made.curves[0], standard_errors=np.full(4, 0.1))
    bare = dataclasses.replace(made.curves[0], standard_errors=None)
    tint = "#" + "".join(f"{round(255 - 0.35 * (255 - c)):02X}" for c in (0x00, 0x72, 0xB2))
    shares = [share(picture(dataclasses.replace(made, curves=(one,))), tint) for one in (wide, bare)]
    assert shares[0] > 0.05
    assert shares[1] < 0.001
    assert share(picture(made), ALARM) > 0


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_diagnosis_has_a_picture(dimension: int) -> None:
    image = picture(diagnosis(dimension), cloud(50, dimension))
    assert share(image, ALARM) > 0
    assert share(image, COLOURS[1]) > 0


def test_components_are_seen_in_their_colours() -> None:
    image = picture(partition(cloud(900), 3), cloud(900))
    assert all(share(image, colour) > 0.0005 for colour in COLOURS[:3])


def test_a_large_cloud_is_drawn_whole() -> None:
    rng = np.random.default_rng(0)
    points = np.vstack([rng.normal(0, 0.1, (60_000, 2)), [[5.0, 5.0]] * 2000])
    image = picture(dataclasses.replace(partition(points, 1), labels=np.zeros(len(points), int)), points)
    assert 0.0005 < share(image, COLOURS[0]) < 0.2


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1e12, 1e300])
@pytest.mark.parametrize("offset", [0.0, 1e7])
def test_any_size_and_place_gives_a_picture(scale: float, offset: float) -> None:
    result = reconstruction(scale=scale, offset=offset * scale)
    image = picture(result, cloud() * scale + offset * scale)
    assert all(share(image, colour) > 0.0005 for colour in COLOURS[:2])


@pytest.mark.parametrize(
    "points", [np.zeros((1, 2)), np.full((5, 3), 3e300), np.full((3, 2), -1e-320), np.empty((0, 2))]
)
def test_points_without_extent_give_a_picture(points: np.ndarray) -> None:
    assert picture(without_curves(reconstruction()), points).size > 0


def test_very_many_points_at_one_place_give_a_picture() -> None:
    nothing = without_curves(reconstruction())
    assert picture(nothing, np.ones((50_000, 2))).size > 0


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_tape_is_filled_but_for_its_hole(dimension: int) -> None:
    made = without_curves(skeleton(dimension))
    assert made.tape is not None
    filled = tuple(dataclasses.replace(polygon, holes=()) for polygon in made.tape)
    shares = [share(picture(one), TAPE) for one in (made, dataclasses.replace(made, tape=filled))]
    assert 0.1 < shares[0] < shares[1]


def test_a_large_cloud_is_seen_on_its_tape() -> None:
    points = np.random.default_rng(0).uniform(OUTER.min(axis=0), OUTER.max(axis=0), (100_000, 2))
    assert share(picture(skeleton(), points), TAPE) < 0.9 * share(picture(skeleton()), TAPE)


def test_the_stages_are_one_picture_in_all_their_colours() -> None:
    image = picture(skeleton(stages=True), cloud())
    assert min(image.shape[:2]) >= 600
    sheet = scene(skeleton(stages=True), cloud())
    assert isinstance(sheet, Sheet)
    colours = [area.colour for area in sheet.panels["triangles"].areas]
    assert all(share(image, colour) > 0.001 for colour in (TAPE, *colours))


@pytest.mark.parametrize(("scale", "offset"), [(1e-300, 0.0), (1e300, 1e7)])
def test_stages_of_any_size_and_place_give_a_picture(scale: float, offset: float) -> None:
    result = skeleton(stages=True, scale=scale, offset=offset * scale)
    assert share(picture(result, cloud() * scale + offset * scale), TAPE) > 0.01


@pytest.mark.parametrize("points", [np.zeros((20, 2)), np.full((20, 3), 3e300)])
def test_stages_without_extent_give_a_picture(points: np.ndarray) -> None:
    result = skeleton(points.shape[1], stages=True)
    bare = dataclasses.replace(without_curves(result), tape=(), graph=None)
    assert picture(bare, points).size > 0
