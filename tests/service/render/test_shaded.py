from __future__ import annotations

from base64 import b64decode
from io import BytesIO
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from core.surface.results import Mesh
from render.surfaces import CUBE, UP, ball, cube, surface
from service.render import encode, scene, shaded
from service.render.raster import fill
from service.render.scenes import Scene

Axis = tuple[float, float, float]


def pixels(mesh: Mesh, axis: Axis = UP, count: int = 200) -> np.ndarray:
    _, picture = shaded(mesh, np.array(axis), count)
    assert picture is not None
    return picture.pixels.astype(int)


def opened() -> Mesh:
    """The cube without the two sides that are seen best, so that one looks inside."""
    mesh = cube()
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    return Mesh(mesh.vertices, mesh.faces[(middles[:, 1] > 1e-9) & (middles[:, 2] < 1 - 1e-9)])


# --- triangles to pixels ----------------------------------------------------------------------------


def drawn(corners: list[list[list[float]]], values: list[list[float]], size: int = 20) -> np.ndarray:
    depth, image = np.full((size, size), -np.inf), np.full((size, size), np.nan)
    fill(np.array(corners), np.array(values), depth, image)
    return image


def test_two_triangles_fill_a_square_without_a_gap() -> None:
    corners = [
        [[2.0, 3.0, 0], [12.0, 3.0, 0], [12.0, 18.0, 0]],
        [[2.0, 3.0, 0], [12.0, 18.0, 0], [2.0, 18.0, 0]],
    ]
    image = drawn(corners, [[1.0] * 3] * 2)
    inside = np.zeros((20, 20), bool)
    inside[3:18, 2:12] = True
    assert np.array_equal(np.isfinite(image), inside)


def test_values_are_interpolated() -> None:
    corners = [[[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0]]]
    image = drawn(corners, [[1.0, 5.0, 3.0]])
    row, column = np.mgrid[:20, :20] + 0.5
    assert image == pytest.approx(1.0 + column / 10.0 + row / 20.0)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_triangle_is_seen_whatever_the_order(order: list[int]) -> None:
    far = [[-50.0, -50.0, 0.0], [100.0, -50.0, 0.0], [-50.0, 100.0, 0.0]]
    near = [[0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [0.0, 10.0, 1.0]]
    image = drawn([[far, near][k] for k in order], [[[1.0] * 3, [2.0] * 3][k] for k in order])
    assert image[2, 2] == 2.0
    assert image[15, 2] == 1.0


def test_triangles_that_cut_each_other_are_seen_to_do_so() -> None:
    wide = np.array([[-50.0, -50.0, 0.0], [100.0, -50.0, 0.0], [-50.0, 100.0, 0.0]])
    tilted = wide.copy()
    tilted[:, 2] = wide[:, 0] - 10.0
    image = drawn([wide.tolist(), tilted.tolist()], [[1.0] * 3, [2.0] * 3])
    assert image[:, :9] == pytest.approx(1.0)
    assert image[:, 11:] == pytest.approx(2.0)


def test_a_triangle_from_behind_is_told_and_one_from_the_edge_not_seen() -> None:
    behind = [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [20.0, 0.0, 0.0]]
    edge = [[0.0, 0.0, 9.0], [10.0, 10.0, 9.0], [20.0, 20.0, 9.0]]
    image = drawn([behind, edge], [[3.0] * 3] * 2)
    assert image[2, 2] == pytest.approx(-3.0)


# --- surfaces ---------------------------------------------------------------------------------------


def test_a_sphere_is_a_disc_that_fills_the_picture() -> None:
    image = pixels(ball(48))
    assert image.shape[:2] == pytest.approx((200, 200), abs=1)
    assert (image[..., 3] / 255.0).mean() == pytest.approx(np.pi / 4.0, abs=0.01)


def test_light_falls_from_above() -> None:
    image = pixels(ball(48))
    bright = image[..., :3].sum(axis=2)
    assert bright[150, 100] > bright[50, 100]  # the lowest row comes first


@pytest.mark.parametrize("axis", [UP, (0.0, 1.0, 0.0), (1.0, 2.0, 2.0), (0.0, 0.0, -1.0)])
def test_a_surface_stands_upright_along_its_axis(axis: Axis) -> None:
    tall = CUBE * [1.0, 1.0, 3.0]
    frame = np.linalg.qr(np.column_stack([axis, np.eye(3)[:, :2] + 0.1]))[0]
    frame *= np.sign(frame[:, :1].T @ np.array(axis))
    turned = tall @ np.column_stack([frame[:, 1], frame[:, 2], frame[:, 0]]).T
    image = pixels(Mesh(turned, cube().faces), axis)
    assert image.shape[0] == 200
    assert image.shape[1] < 130


def test_the_faces_of_a_cube_are_flat_and_differ() -> None:
    image = pixels(cube())
    whole = image[image[..., 3] == 255][:, :3]
    colours, counts = np.unique(whole, axis=0, return_counts=True)
    assert len(colours[counts > 0.1 * len(whole)]) == 3


def test_the_inside_has_another_colour() -> None:
    def warm(image: np.ndarray) -> float:
        return float(((image[..., 0] > image[..., 2] + 20) & (image[..., 3] > 0)).mean())

    assert warm(pixels(cube())) == 0.0
    assert warm(pixels(opened())) > 0.1


@pytest.mark.parametrize("scale", [1e-90, 1e-3, 1e90])
def test_the_picture_does_not_depend_on_units(scale: float) -> None:
    assert np.array_equal(pixels(cube(scale)), pixels(cube()))


@pytest.mark.parametrize("offset", [-7.0, 1e6])
def test_the_picture_does_not_depend_on_the_place(offset: float) -> None:
    assert np.abs(pixels(cube(1.0, offset)) - pixels(cube())).mean() < 0.1


def test_what_is_shown_is_told() -> None:
    shown = scene(surface(ball()))
    assert isinstance(shown, Scene)
    assert shown.title == f"1 component, genus 0, closed, {len(ball().faces)} faces"
    torn = scene(surface(opened(), closed=False))
    assert "not closed" in torn.title


def test_a_picture_of_vectors_holds_the_shaded_one() -> None:
    root = ET.fromstring(encode(surface(ball()), "svg"))  # noqa: S314 # our own
    (image,) = root.iter("{http://www.w3.org/2000/svg}image")
    kind, _, content = image.get("href", "").partition(",")
    assert kind == "data:image/png;base64"
    with Image.open(BytesIO(b64decode(content))) as picture:
        seen = np.asarray(picture.convert("RGBA")).astype(int)
    _, expected = shaded(ball(), np.array(UP))
    assert expected is not None
    assert np.array_equal(seen[::-1], expected.pixels)
    _, _, width, height = map(float, root.get("viewBox", "").split())
    assert float(image.get("width", "")) <= width
    assert float(image.get("height", "")) <= height


def test_a_picture_of_pixels_shows_the_surface() -> None:
    with Image.open(BytesIO(encode(surface(ball()), "png"))) as image:
        seen = np.asarray(image.convert("RGB")).astype(int)
    blue = (seen[..., 2] > seen[..., 0] + 15).mean()
    assert 0.2 < blue < 0.8


@pytest.mark.parametrize("form", ["svg", "png"])
def test_a_surface_without_faces_or_extent_gives_a_picture(form: str) -> None:
    nothing = Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64))
    point = Mesh(np.ones((3, 3)), np.array([[0, 1, 2]]))
    for mesh in (nothing, point):
        assert encode(surface(mesh), form)
