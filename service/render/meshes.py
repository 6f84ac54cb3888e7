"""Meshes as STL, OBJ, PLY and glTF, written directly, since their numbers shall be kept.

The usual exporters round PLY to single and OBJ to eight digits; here both keep doubles to the last
digit. STL and glTF have single precision by their nature: a surface far from the origin or beyond its
range becomes an STL of text, whose numbers have no such bounds, and glTF always has the middle of the
surface, in double precision, as the translation of its node.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Mesh, Surface
from service.render.documents import dump_json, floats

__all__ = ["mesh_of", "normals_of", "write_glb", "write_obj", "write_ply", "write_stl"]

Floats = NDArray[np.float64]

_SINGLE = 2.0**-24  # relative rounding error of single precision
_LOST = 1e-5  # of the extent: more than this is seen
_LARGEST, _SMALLEST = 1e30, 1e-30  # sizes that single precision holds, with some room


@singledispatch
def mesh_of(result: object) -> Mesh:
    """Return the mesh of a result; register a function for each new type of result."""
    raise TypeError(f"{type(result).__name__} has no mesh")


@mesh_of.register
def _(result: Mesh) -> Mesh:
    return result


@mesh_of.register
def _(result: Surface) -> Mesh:
    return result.mesh


def write_ply(mesh: Mesh) -> bytes:
    """Write binary PLY, little-endian, with vertices of double precision."""
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + mesh.vertices.astype("<f8").tobytes() + faces.tobytes()


def write_obj(mesh: Mesh) -> bytes:
    """Write OBJ; numbers read back to the same floats, and indices count from 1, as the format has it."""
    vertices, faces = floats(mesh.vertices), mesh.faces.astype(np.int64) + 1
    return b"".join([b"# tapeline\n", _lines(b"v ", vertices), _lines(b"f ", faces)])


def _lines(key: bytes, rows: NDArray[Any]) -> bytes:
    """Write a line a row: JSON, which ``orjson`` writes fastest, with other marks in between."""
    if not len(rows):
        return b""
    inside = dump_json(rows)[2:-2].replace(b"],[", b"\n" + key)
    return key + inside.replace(b",", b" ") + b"\n"


def write_stl(mesh: Mesh) -> bytes:
    """Write binary STL; text where single precision would be seen, or does not reach."""
    corners = mesh.vertices[mesh.faces]
    normals, _ = normals_of(mesh)
    if len(corners) and not _fits(mesh.vertices):
        return _stl_text(corners, normals)
    facets = np.zeros(len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    facets["normal"], facets["corners"] = normals, corners
    return b"tapeline".ljust(80) + np.array(len(facets), "<u4").tobytes() + facets.tobytes()


_FACET = (
    b"facet normal %s %s %s\nouter loop\nvertex %s %s %s\nvertex %s %s %s\nvertex %s %s %s\n"
    b"endloop\nendfacet\n"
)


def _stl_text(corners: Floats, normals: Floats) -> bytes:
    numbers = np.concatenate([normals, corners.reshape(-1, 9)], axis=1).ravel()
    written = tuple(dump_json(floats(numbers))[1:-1].split(b","))
    return b"solid tapeline\n" + _FACET * len(corners) % written + b"endsolid tapeline\n"


def _fits(vertices: Floats) -> bool:
    """Say whether single precision holds these coordinates to within what is seen."""
    low, high = _corners(vertices)
    extent, farthest = float((high - low).max()), float(np.abs([low, high]).max())
    return farthest < _LARGEST and extent > _SMALLEST and farthest * _SINGLE <= _LOST * extent


def _corners(vertices: Floats) -> tuple[Floats, Floats]:
    """Lower and upper corner; zeros about nothing."""
    if not len(vertices):
        return np.zeros(3), np.zeros(3)
    return vertices.min(axis=0), vertices.max(axis=0)


# --- glTF 2.0 -----------------------------------------------------------------------------------------

_FLOAT, _UNSIGNED = 5126, 5125
_ARRAY, _ELEMENTS = 34962, 34963
_JSON, _BINARY = b"JSON", b"BIN\x00"


def write_glb(mesh: Mesh) -> bytes:
    """Write binary glTF 2.0: positions about the middle, which is the node's translation, and normals."""
    if not len(mesh.faces):
        return _glb({"asset": _ASSET, "scene": 0, "scenes": [{}]}, b"")
    low, high = _corners(mesh.vertices)
    middle = low + (high - low) / 2.0
    unit = _scale(float((high - low).max()))
    places = ((mesh.vertices - middle) / unit).astype("<f4")
    _, normals = normals_of(mesh)
    parts = (places.tobytes(), normals.astype("<f4").tobytes(), mesh.faces.astype("<u4").tobytes())
    starts = np.cumsum([0, *map(len, parts)]).tolist()  # all of them multiples of four, as is required
    node = {"mesh": 0, "translation": middle.tolist()} | ({} if unit == 1.0 else {"scale": [unit] * 3})
    document = {
        "asset": _ASSET,
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            _accessor(0, _FLOAT, len(places), "VEC3")
            | {"min": places.min(axis=0).tolist(), "max": places.max(axis=0).tolist()},
            _accessor(1, _FLOAT, len(places), "VEC3"),
            _accessor(2, _UNSIGNED, mesh.faces.size, "SCALAR"),
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": target}
            for start, part, target in zip(starts[:-1], parts, (_ARRAY, _ARRAY, _ELEMENTS), strict=True)
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }
    return _glb(document, b"".join(parts))


_ASSET = {"version": "2.0", "generator": "tapeline"}


def _scale(extent: float) -> float:
    """Return 1, or what brings an extent beyond single precision into its range."""
    return 1.0 if _SMALLEST < extent < _LARGEST else extent or 1.0


def _accessor(view: int, component: int, count: int, kind: str) -> dict[str, Any]:
    return {"bufferView": view, "componentType": component, "count": count, "type": kind}


def _glb(document: dict[str, Any], binary: bytes) -> bytes:
    text = dump_json(document)
    text = text.ljust(-(-len(text) // 4) * 4)
    chunks = _chunk(_JSON, text) + (_chunk(_BINARY, binary) if binary else b"")
    return b"glTF" + np.array([2, 12 + len(chunks)], "<u4").tobytes() + chunks


def _chunk(kind: bytes, content: bytes) -> bytes:
    return np.array(len(content), "<u4").tobytes() + kind + content


# --- normals ------------------------------------------------------------------------------------------


def _across(mesh: Mesh) -> Floats:
    """Return a normal of each face (F, 3), as long as the face is large, in units of the extent."""
    low, high = _corners(mesh.vertices)
    extent = float((high - low).max())
    places = (mesh.vertices - low) / (extent or 1.0)  # so that squares stay in the range
    first, second, third = (places[mesh.faces[:, k]] for k in range(3))
    return np.cross(second - first, third - first)


def normals_of(mesh: Mesh) -> tuple[Floats, Floats]:
    """Return unit normals of the faces (F, 3) and at the vertices (V, 3): means of their faces' by area."""
    across = _across(mesh)
    corners, count = mesh.faces.ravel(), len(mesh.vertices)
    sums = [np.bincount(corners, np.repeat(across[:, k], 3), count) for k in range(3)]
    return _unit(across), _unit(np.column_stack(sums))


def _unit(vectors: Floats) -> Floats:
    """Scale vectors to length 1; those without a direction point up: readers want none of length 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    up = np.broadcast_to([0.0, 0.0, 1.0], vectors.shape)
    return np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), up)
