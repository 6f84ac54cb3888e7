from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
import shapely

from render.results import SQUARE, cloud, diagnosis, partition, reconstruction, skeleton
from service.render import document, encode, feature_collection, report, scene, table
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


@report.register
def _(result: Spot) -> str:
    return f"a spot at {result.x}, {result.y}"


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
        ("txt", b"a spot at 1.0, 2.0"),
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
    crossings, violations = shown.marks
    assert crossings.points.tolist() == violations.points.tolist() == [SQUARE[1].tolist()]
    assert (crossings.name, violations.name) == ("crossings", "branches too near")
    assert not shown.circles


def test_curves_that_were_fitted_have_a_band_of_two_standard_errors() -> None:
    result = reconstruction()
    shown = scene(result, cloud())
    assert isinstance(shown, Scene)
    (band,) = shown.bands
    errors = result.curves[0].standard_errors
    assert errors is not None
    left, right = band.rings
    assert np.linalg.norm(left - SQUARE, axis=1) == pytest.approx(2 * errors)
    assert np.linalg.norm(right[::-1] - SQUARE, axis=1) == pytest.approx(2 * errors)
    assert [path.fine for path in shown.paths] == [True, False]


def test_the_band_of_an_open_curve_goes_around_it() -> None:
    made = reconstruction()
    curve = dataclasses.replace(made.curves[1], standard_errors=np.array([0.1, 0.2]))
    shown = scene(dataclasses.replace(made, curves=(curve,)))
    assert isinstance(shown, Scene)
    ((ring,),) = (band.rings for band in shown.bands)
    assert shapely.Polygon(ring).area == pytest.approx(3.0 * (0.4 + 0.8) / 2)


def test_the_band_is_as_wide_whatever_the_units() -> None:
    shown = [scene(reconstruction(scale=scale)) for scale in (1.0, 2.0**900)]
    rings = [one.bands[0].rings[0] for one in shown if isinstance(one, Scene)]
    assert np.allclose(*(ring / np.ptp(ring) for ring in rings))


def test_a_diagnosis_shows_the_noise_the_longest_gap_and_what_is_wrong() -> None:
    shown = scene(diagnosis(), cloud())
    assert isinstance(shown, Scene)
    assert [len(group.points) for group in shown.dots] == [48, 2]
    assert [circle.radius for circle in shown.circles] == [0.02, 0.04, 0.2]
    assert list(shown.key()) == ["samples", "outliers", "2 sigma", "longest gap", "branches too near"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_noise_that_does_not_vary_is_drawn_once_a_component_at_a_sample(dimension: int) -> None:
    made = diagnosis(dimension)
    points = cloud(50, dimension)
    even = dataclasses.replace(made, sampling=dataclasses.replace(made.sampling, sigma_along=()))
    shown = scene(even, points)
    assert isinstance(shown, Scene)
    *noise, _ = shown.circles
    assert [circle.radius for circle in noise] == [0.02, 0.04]
    places = np.concatenate([group.points for group in shown.dots])
    for circle in noise:
        assert np.linalg.norm(places - [circle.x, circle.y], axis=1).min() == pytest.approx(0, abs=1e-12)


def test_the_picture_of_a_diagnosis_needs_the_points() -> None:
    with pytest.raises(TypeError, match="points"):
        scene(diagnosis())


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
