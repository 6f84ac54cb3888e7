from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.results import Mesh
from service.intake import IntakeError
from service.intake.meshes import decode_mesh

QUAD = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
)
STL = (
    "solid a\nfacet normal 0 0 1\nouter loop\n"
    "vertex 0 0 0\nvertex 1 0 0\nvertex {} 1 0\nendloop\nendfacet\nendsolid\n"
)
KINDS = ("ply", "ply ascii", "stl", "stl_ascii", "obj")


def exported(mesh: trimesh.Trimesh, kind: str) -> bytes:
    if kind == "ply ascii":
        return bytes(mesh.export(file_type="ply", encoding="ascii"))
    body = mesh.export(file_type=kind)
    return body.encode() if isinstance(body, str) else bytes(body)


def refusal(body: bytes, kind: str, max_points: int | None = None) -> IntakeError:
    with pytest.raises(IntakeError) as caught:
        decode_mesh(body, kind, max_points)
    return caught.value


@pytest.mark.parametrize("kind", KINDS)
def test_every_format_gives_the_same_closed_mesh(kind: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=3.0)
    mesh = decode_mesh(exported(ball, kind), kind[:3])
    assert mesh.vertices.shape == ball.vertices.shape
    assert mesh.faces.shape == ball.faces.shape
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int64
    again = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert again.is_watertight
    assert again.volume == pytest.approx(ball.volume, rel=1e-6)


def test_polygons_are_cut_into_triangles() -> None:
    for body, kind in ((QUAD + b"f 1 2 3 4\n", "obj"), (PLY + b"4 0 1 2 3\n", "ply")):
        mesh = decode_mesh(body, kind)
        corners = mesh.vertices[mesh.faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert len(mesh.faces) == 2
        assert normal.sum(axis=0) / 2 == pytest.approx([0.0, 0.0, 1.0])


def test_materials_and_textures_are_passed_over_and_nothing_is_opened() -> None:
    body = b"mtllib /etc/passwd\n" + QUAD + b"vt 0 0\nusemtl none\nf 1/1 2/1 3/1\n"
    assert len(decode_mesh(body, "obj").faces) == 1
    body = PLY.replace(b"element vertex", b"comment TextureFile /etc/passwd\nelement vertex") + b"3 0 1 2\n"
    assert len(decode_mesh(body, "ply").faces) == 1


@pytest.mark.parametrize(
    ("body", "kind", "status"),
    [
        (b"", "ply", 400),
        (b"", "stl", 400),
        (b"", "obj", 422),
        (b"\0" * 84, "stl", 422),
        (b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 100, "stl", 400),
        (PLY + b"3 0 1 7\n", "ply", 422),
        (PLY + b"3 0 1 -1\n", "ply", 422),
        (PLY, "ply", 422),
        (PLY.replace(b"vertex 4", b"vertex 40000000000"), "ply", 400),
        (PLY.replace(b"property float z\n", b""), "ply", 400),
        (PLY.replace(b"element face 1\nproperty list uchar int vertex_indices\n", b""), "ply", 422),
        (QUAD, "obj", 422),
        (QUAD + b"f 1 2 9\n", "obj", 400),
        (QUAD + b"f 1 2 1\n", "obj", 422),
        (QUAD.replace(b"0 1 0", b"0 nan 0") + b"f 1 2 4\n", "obj", 422),
        (QUAD.replace(b"0 1 0", b"0 1e999 0") + b"f 1 2 4\n", "obj", 422),
        (QUAD.replace(b"0 1 0", b"0 one 0") + b"f 1 2 4\n", "obj", 400),
        (STL.format("nan").encode(), "stl", 422),
        (STL.format("east").encode(), "stl", 400),
        (b"3 points", "xyz", 415),
    ],
)
def test_what_is_no_mesh_is_refused(body: bytes, kind: str, status: int) -> None:
    assert refusal(body, kind).status == status


def test_too_many_vertices_are_refused() -> None:
    body = exported(trimesh.creation.icosphere(subdivisions=1), "stl")
    assert len(decode_mesh(body, "stl", 42).vertices) == 42
    assert refusal(body, "stl", 39).status == 413


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS))
def test_bytes_changed_or_cut_off_by_chance_are_read_or_refused(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    body = bytearray(exported(trimesh.creation.icosahedron(), kind))
    for place in rng.integers(0, len(body), size=4):
        body[place] = rng.integers(0, 256)
    if rng.random() < 0.3:
        del body[rng.integers(0, len(body)) :]
    mesh = read_or_refused(bytes(body), kind[:3])
    if mesh is not None:
        assert np.isfinite(mesh.vertices).all()
        assert 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices)


def read_or_refused(body: bytes, kind: str) -> Mesh | None:
    """The mesh, or None when it was refused with one of the statuses for it."""
    try:
        return decode_mesh(body, kind)
    except IntakeError as error:
        if error.status not in {400, 422}:
            raise
        return None
