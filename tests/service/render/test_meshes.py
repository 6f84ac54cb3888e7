from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from core.surface.results import Mesh, Surface, SurfaceReport
from service.render import encode
from service.render.meshes import mesh_of

FORMS = ("stl", "obj", "ply", "glb")
KEPT = ("obj", "ply")  # to the last digit
SINGLE = 2.0**-23


def ball(subdivisions: int = 2, scale: float = 1.0, offset: float = 0.0) -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=subdivisions)
    return Mesh(np.array(made.vertices) * scale + offset, np.array(made.faces, np.int64))


def surface(mesh: Mesh) -> Surface:
    return Surface(mesh, SurfaceReport(True, True, 1, 2, 0, 1.0, 1.0, 0))


def read(content: bytes, form: str) -> Any:
    return trimesh.load(io.BytesIO(content), file_type=form, force="mesh", process=False)


def corners(mesh: Mesh | Any) -> np.ndarray:
    """The triangles (F, 3, 3), which all forms have in the same order."""
    return np.asarray(mesh.vertices)[np.asarray(mesh.faces)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e6])
@pytest.mark.parametrize("offset", [0.0, 10.0])
def test_triangles_read_back_as_they_are(form: str, scale: float, offset: float) -> None:
    mesh = ball(2, scale, offset * scale)
    back = read(encode(surface(mesh), form), form)
    exact = 0.0 if form in KEPT else SINGLE * np.abs(mesh.vertices).max()
    assert np.abs(corners(back) - corners(mesh)).max() <= exact


@pytest.mark.parametrize("form", FORMS)
def test_a_closed_surface_is_closed_and_turned_outwards_when_read_back(form: str) -> None:
    mesh = ball(3)
    back = read(encode(surface(mesh), form), form)
    back.merge_vertices()
    assert back.is_watertight
    assert back.is_winding_consistent
    assert back.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.02)


@pytest.mark.parametrize("form", FORMS)
def test_a_surface_far_off_keeps_its_shape(form: str) -> None:
    mesh = ball(2, 1.0, 5e8)
    back = read(encode(surface(mesh), form), form)
    assert np.abs(corners(back) - corners(mesh)).max() <= 2e-7


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("scale", [1e-60, 1e-40, 1e40, 1e60])
def test_a_surface_beyond_single_precision_keeps_its_shape(form: str, scale: float) -> None:
    mesh = ball(1, scale)
    back = read(encode(surface(mesh), form), form)
    assert np.abs(corners(back) - corners(mesh)).max() <= SINGLE * scale


@given(arrays.arrays(float, (6, 3), elements=st.floats(-1e99, 1e99)))
def test_any_numbers_are_kept_to_the_last_digit(vertices: np.ndarray) -> None:
    mesh = Mesh(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    for form in KEPT:
        assert np.array_equal(np.asarray(read(encode(surface(mesh), form), form).vertices), vertices)
    for form in ("stl", "glb"):
        assert encode(surface(mesh), form) == encode(surface(mesh), form)


def facets(content: bytes) -> np.ndarray:
    """Facets of a binary STL, by the letter of its description."""
    (count,) = struct.unpack("<I", content[80:84])
    assert len(content) == 84 + 50 * count
    assert not content.startswith(b"solid")  # the word by which text is known
    return np.frombuffer(content[84:], "<f4,<3f4,<3f4,<3f4,<u2".replace("<f4,", "<3f4,", 1))


def test_the_normals_of_stl_are_unit_vectors_outwards() -> None:
    read_back = facets(encode(surface(ball(3)), "stl"))
    normals, middles = read_back["f0"], (read_back["f1"] + read_back["f2"] + read_back["f3"]) / 3.0
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    assert np.einsum("ij,ij->i", normals, middles).min() > 0.9


def chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    """The two chunks of a binary glTF, with all that its specification says of their frame."""
    magic, version, total = struct.unpack("<4sII", content[:12])
    assert (magic, version, total) == (b"glTF", 2, len(content))
    size, kind = struct.unpack("<I4s", content[12:20])
    assert (size % 4, kind) == (0, b"JSON")
    text, rest = content[20 : 20 + size], content[20 + size :]
    length, kind = struct.unpack("<I4s", rest[:8])
    assert (length % 4, kind, len(rest)) == (0, b"BIN\x00", 8 + length)
    return json.loads(text), rest[8:]


@pytest.mark.parametrize("subdivisions", [0, 1, 2])
@pytest.mark.parametrize("offset", [0.0, 1e5, 123.456])
def test_gltf_is_as_its_specification_has_it(subdivisions: int, offset: float) -> None:
    mesh = ball(subdivisions, 3.0, offset)
    document, binary = chunks(encode(surface(mesh), "glb"))
    assert document["asset"]["version"] == "2.0"
    assert document["buffers"] == [{"byteLength": len(binary)}]
    arrays_ = []
    for accessor, width, kind in zip(document["accessors"], (3, 3, 1), ("<f4", "<f4", "<u4"), strict=True):
        view = document["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == accessor["count"] * width * 4
        part = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        arrays_.append(np.frombuffer(part, kind).reshape(-1, width))
    places, normals, indices = arrays_
    assert np.array_equal(indices.reshape(-1, 3), mesh.faces)
    position = document["accessors"][0]
    assert np.array_equal(np.array(position["min"], "f4"), places.min(axis=0))
    assert np.array_equal(np.array(position["max"], "f4"), places.max(axis=0))
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    assert np.einsum("ij,ij->i", normals, places / 3.0).min() > 0.98


def test_vertices_without_a_face_or_a_direction_have_a_normal_too() -> None:
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]]), np.array([[0, 1, 2]]))
    for form in FORMS:
        assert np.isfinite(corners(read(encode(surface(mesh), form), form))).all()


@pytest.mark.parametrize("form", FORMS)
def test_nothing_gives_a_file_with_nothing_in_it(form: str) -> None:
    assert encode(Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64)), form)


@pytest.mark.parametrize("form", FORMS)
def test_the_same_surface_gives_the_same_file(form: str) -> None:
    assert encode(surface(ball(2)), form) == encode(surface(ball(2)), form)


def test_what_has_no_mesh_is_told_so() -> None:
    with pytest.raises(TypeError, match="no mesh"):
        mesh_of(object())
