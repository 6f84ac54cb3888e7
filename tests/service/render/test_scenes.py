from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from render.results import cloud, partition, reconstruction
from service.render import document, encode, feature_collection, scene, table
from service.render.scenes import Dots, Scene


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
    return Scene("a spot", (Dots(np.array([[result.x, result.y]]), "#000000"),))


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


def test_a_scene_counts_what_it_shows() -> None:
    assert scene(reconstruction(curves=1), cloud()).title == "1 curve (pca)"
    assert scene(partition(cloud(), 2), cloud()).title == "2 components"
    assert "projected" in scene(reconstruction(3), cloud(20, 3)).title


def test_the_bounds_hold_everything() -> None:
    shown = scene(reconstruction(stages=True), cloud())
    low, high = shown.bounds()
    for points in [*(group.points for group in shown.dots), *(path.vertices for path in shown.paths)]:
        assert (points >= low).all()
        assert (points <= high).all()
    for circle in shown.circles:
        assert low[0] <= circle.x - circle.radius
        assert circle.y + circle.radius <= high[1]


def test_labels_beyond_the_colours_are_all_shown() -> None:
    shown = scene(partition(cloud(100), 30), cloud(100))
    assert sum(len(group.points) for group in shown.dots) == 100
