"""Meshes and measures that the tests of surfaces share."""

from __future__ import annotations

import numpy as np

from core.surface.results import Mesh

TETRAHEDRON = Mesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
)


def box(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0)) -> Mesh:
    """Twelve triangles around a box, normals outward."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return Mesh(np.asarray(low) + corners * (np.asarray(high) - np.asarray(low)), np.array(faces))


def normals(mesh: Mesh) -> np.ndarray:
    """Unit normals of the faces."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def signed_area(flat: np.ndarray) -> float:
    """Area of a closed polygon, positive when it runs counter-clockwise."""
    x, y = flat.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def edges_of(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """The undirected edges, and how many faces each has."""
    sides = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)
