from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from render.results import SQUARE, cloud, partition, reconstruction, skeleton
from service.render import document, encode, feature_collection, scene, table
from service.render.scenes import Dots, Scene, Sheet


@dataclass(frozen=True)
class Spot:
    """A new type of result, as a later process may bring."""

    x: float
    y: float


@document.register
def _(result: Spot) -> dict[str, object]:
    return {"spot": [result.x, result.y]}


@feature_collection.register
def _(result: Spot, _points: object = None) -> dict[str, object]:
    return {"type": "Point", "coordinates": [result.x, result.y]}


@table.register
def _(result: Spot, _points: object = None) -> bytes:
    return b"x,y\n%r,%r\n" % (result.x, result.y)


@scene.register
def _(result: Spot, _points: object = None) -> Scene:
    return Scene("a spot", dots=(Dots(np.array([[result.x, result.y]]), "#000000"),))


@pytest.mark.parametrize(
    ("form", "begins"),
    [
        ("json", b'{"spot":[1.0,2.0]}'),
        ("geojson", b'{"type":"Point"'),
        ("csv", b"x,y\n1.0,2.0\n"),
        ("svg", b"<svg "),
        ("png", b"\x89PNG"),
    ],
)
def test_a_new_type_of_result_is_registered_form_by_form(form: str, begins: bytes) -> None:
    assert encode(Spot(1.0, 2.0), form).startswith(begins)


def test_a_picture_counts_what_it_shows() -> None:
    assert scene(reconstruction(curves=1), cloud()).title == "1 curve (pca)"
    assert scene(skeleton(), cloud()).title == "1 curve (skeleton)"
    assert scene(partition(cloud(), 2), cloud()).title == "2 components"
    assert "projected" in scene(reconstruction(3), cloud(20, 3)).title


def test_labels_beyond_the_colours_are_all_shown() -> None:
    shown = scene(partition(cloud(100), 30), cloud(100))
    assert isinstance(shown, Scene)
    assert sum(len(group.points) for group in shown.dots) == 100


def test_a_skeleton_is_seen_with_its_tape_and_its_crossings() -> None:
    shown = scene(skeleton(), cloud())
    assert isinstance(shown, Scene)
    assert [len(area.rings) for area in shown.areas] == [2, 1]
    (marks,) = shown.marks
    assert marks.points.tolist() == [SQUARE[1].tolist()]
    assert not shown.circles


def test_a_march_is_seen_with_its_balls_when_they_are_there() -> None:
    for stages, count in ((False, 0), (True, 2)):
        shown = scene(reconstruction(stages=stages), cloud())
        assert isinstance(shown, Scene)
        assert (len(shown.circles), len(shown.areas)) == (count, 0)


def test_the_stages_of_a_skeleton_are_a_sheet() -> None:
    shown = scene(skeleton(stages=True), cloud())
    assert isinstance(shown, Sheet)
    assert len(shown.panels) == 8


def test_without_the_samples_there_is_no_sheet() -> None:
    assert isinstance(scene(skeleton(stages=True)), Scene)
