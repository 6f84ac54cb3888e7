import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.mesh_report import is_sound, report_of, volume_of
from core.surface.results import Mesh
from tests.core.surface.meshes import TETRAHEDRON, box


def joined(*meshes):
    starts = np.cumsum([0] + [len(one.vertices) for one in meshes])
    faces = [one.faces + start for one, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([one.vertices for one in meshes]), np.concatenate(faces))


def flipped(mesh):
    return Mesh(mesh.vertices, mesh.faces[:, ::-1].copy())


def torus(n=24, m=12, big=3.0, small=1.0):
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    radius = big + small * np.cos(v)
    vertices = np.stack((radius * np.cos(u), radius * np.sin(u), small * np.sin(v)), axis=-1).reshape(-1, 3)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    a, b, c, d = (p % n * m + q % m for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    return Mesh(vertices, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d)))))


def test_a_box():
    report = report_of(box((1.0, 2.0, 3.0), (3.0, 5.0, 4.0)))
    assert (report.closed, report.manifold, report.components, report.euler, report.genus) == (
        True,
        True,
        1,
        2,
        0,
    )
    assert report.volume == pytest.approx(6.0)
    assert report.area == pytest.approx(2 * (6 + 2 + 3))
    assert report.self_intersections == 0
    assert is_sound(report)


def test_a_torus_and_a_box_apart():
    report = report_of(joined(torus(), box((5.0, 5.0, 5.0), (6.0, 6.0, 6.0))))
    assert (report.components, report.euler, report.genus) == (2, 2, 1)
    assert is_sound(report)


def test_the_torus_has_its_volume_in_the_limit():
    assert volume_of(torus(400, 200)) == pytest.approx(2 * np.pi**2 * 3.0, rel=1e-3)


def test_a_missing_face_opens_the_mesh_but_leaves_it_manifold():
    report = report_of(Mesh(box().vertices, box().faces[1:]))
    assert (report.closed, report.manifold, report.euler, report.genus) == (False, True, 1, 0)
    assert not is_sound(report)


def test_one_face_turned_is_neither_oriented_nor_closed():
    faces = box().faces.copy()
    faces[3] = faces[3, ::-1]
    report = report_of(Mesh(box().vertices, faces))
    assert not report.closed
    assert not report.manifold


def test_boxes_that_share_a_vertex_or_an_edge_only_are_no_manifold():
    for high in ((2.0, 2.0, 2.0), (2.0, 2.0, 1.0)):
        low = (1.0, 1.0, high[2] - 1.0)
        both = joined(box(), box(low, high))
        _, first, inverse = np.unique(both.vertices, axis=0, return_index=True, return_inverse=True)
        report = report_of(Mesh(both.vertices[first], inverse.ravel()[both.faces]))
        assert not report.manifold


def test_inside_out_is_not_sound():
    report = report_of(flipped(box()))
    assert report.closed
    assert report.volume == pytest.approx(-1.0)
    assert not is_sound(report)


def test_no_faces():
    report = report_of(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64)))
    assert (report.closed, report.components, report.euler, report.volume) == (False, 0, 0, 0.0)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-6, 1e6))
def test_the_report_does_not_depend_on_place_size_and_order(seed, scale):
    rng = np.random.default_rng(seed)
    mesh = joined(torus(8, 5), box((5.0, 5.0, 5.0), (6.0, 6.0, 6.0)), TETRAHEDRON)
    names = rng.permutation(len(mesh.vertices))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    vertices = np.empty_like(mesh.vertices)
    vertices[names] = scale * (mesh.vertices @ turn + rng.normal(size=3))
    faces = np.roll(names[mesh.faces], rng.integers(3), axis=1)[rng.permutation(len(mesh.faces))]
    one, other = report_of(mesh), report_of(Mesh(vertices, faces))
    for name in ("closed", "manifold", "components", "euler", "genus", "self_intersections"):
        assert getattr(one, name) == getattr(other, name)
    assert other.volume == pytest.approx(one.volume * scale**3)
    assert other.area == pytest.approx(one.area * scale**2)
