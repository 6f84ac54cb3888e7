"""Triangle meshes: PLY, STL and OBJ, read by trimesh.

A reader that others wrote meets files that others made: sizes that a file announces are checked against its
length first, whatever goes wrong in the reader is an unreadable body, and nothing that a file names
is opened.
"""

from __future__ import annotations

import re
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Mesh
from service.intake.errors import IntakeError, refuse
from service.intake.ply import read_header

__all__ = ["MESH_KINDS", "decode_mesh"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MESH_KINDS = ("ply", "stl", "obj")
"""What `decode_mesh` reads; also the endings of the files' names."""

_STL_HEAD, _STL_FACE = 84, 50  # bytes of a binary STL file: before the faces, and of each face
_MATERIALS = re.compile(rb"^[ \t]*(?:mtllib|usemtl)\b[^\r\n]*", re.MULTILINE)


def decode_mesh(body: bytes, kind: str, max_points: int | None = None) -> Mesh:
    """Read a triangle mesh; polygons are cut into triangles, and equal vertices become one.

    Parameters
    ----------
    body : bytes
    kind : {"ply", "stl", "obj"}
    max_points : int, optional
        How many vertices it may have, and half as many as faces.

    Returns
    -------
    Mesh
        With at least one face; faces with two equal vertices are left out.

    Raises
    ------
    IntakeError
        400 for a body that is no such file, 413 for too many vertices or faces, 415 for another kind,
        422 for a mesh without faces, vertices that are not finite or faces that name none.
    """
    if kind not in MESH_KINDS:
        raise refuse("unsupported-media-type", f"meshes are read as one of {', '.join(MESH_KINDS)}")
    _check_sizes(body, kind)
    vertices, faces = _arrays(_loaded(body, kind), kind)
    _check(vertices, faces)
    mesh = _merged(vertices, faces)
    if max_points is not None and (len(mesh.vertices) > max_points or len(mesh.faces) > 2 * max_points):
        detail = (
            f"{len(mesh.vertices)} vertices are more than the {max_points} allowed, or twice that in faces"
        )
        raise refuse("too-many-points", detail)
    return mesh


def _check_sizes(body: bytes, kind: str) -> None:
    """Refuse what announces more than it holds, or is plainly something else."""
    if kind == "ply":
        read_header(body)
    elif kind == "stl" and not _is_text_stl(body):
        faces = int.from_bytes(body[_STL_HEAD - 4 : _STL_HEAD], "little")
        if len(body) != _STL_HEAD + _STL_FACE * faces:
            raise _broken(kind, "its length is not that of the faces that it announces")


def _is_text_stl(body: bytes) -> bool:
    """Tell whether an STL file is text; binary ones may begin with the same word."""
    return body.lstrip()[:5].lower() == b"solid" and b"facet" in body[:1000].lower()


def _loaded(body: bytes, kind: str) -> Any:
    """Let trimesh read the file, without materials and with nothing to open."""
    import trimesh  # noqa: PLC0415 # half a second of imports

    if kind == "obj":
        body = _MATERIALS.sub(b"", body)
    try:
        return trimesh.load(
            BytesIO(body),
            file_type=kind,
            force="mesh",
            process=False,
            maintain_order=True,
            skip_materials=True,
            allow_remote=False,
        )
    except Exception as error:  # whatever it is, it is the file
        raise _broken(kind, "it cannot be read") from error


def _arrays(loaded: Any, kind: str) -> tuple[Floats, Ints]:
    """Return vertices and faces of what was read."""
    try:
        faces = np.asarray(loaded.faces, np.int64).reshape(-1, 3)
        vertices = np.asarray(loaded.vertices, np.float64).reshape(-1, 3)
    except AttributeError:  # a cloud of points
        faces, vertices = np.zeros((0, 3), np.int64), np.zeros((0, 3))
    except (TypeError, ValueError) as error:
        raise _broken(kind, "it cannot be read") from error
    return vertices, faces


def _check(vertices: Floats, faces: Ints) -> None:
    if not len(faces):
        raise _wrong("has no faces", "too_short")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise _wrong("has a face that names a vertex that is not there", "index_out_of_range")
    if not np.isfinite(vertices).all():
        raise _wrong("has a vertex that is not finite", "finite_number")


def _merged(vertices: Floats, faces: Ints) -> Mesh:
    """Make equal vertices one, and leave out what is then no triangle, and vertices without a face."""
    used, compact = np.unique(faces, return_inverse=True)
    distinct, index = _distinct(vertices[used])
    merged = index[compact].reshape(-1, 3)
    a, b, c = merged.T
    sound = merged[(a != b) & (b != c) & (c != a)]
    if not len(sound):
        raise _wrong("has no faces with three different vertices", "too_short")
    return Mesh(distinct, sound)


def _distinct(rows: Floats) -> tuple[Floats, Ints]:
    """Return the different rows of an array, and which of them each row is."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    differs = np.any(ordered[1:] != ordered[:-1], axis=1)
    index = np.empty(len(rows), np.int64)
    index[order] = np.concatenate(([0], np.cumsum(differs)))
    return ordered[np.concatenate(([True], differs))], index


def _broken(kind: str, reason: str) -> IntakeError:
    detail = f"the body is not a sound {kind.upper()} file: {reason}"
    return refuse("unreadable-body", detail, ("body",), f"{kind}_invalid")


def _wrong(reason: str, code: str) -> IntakeError:
    return refuse("invalid-points", f"the mesh {reason}", ("body", "meshes"), code)
