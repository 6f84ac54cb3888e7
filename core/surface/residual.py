"""How far scan points lie from a mesh: exact distances to its triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Mesh

__all__ = ["distances_to", "rms_residual"]

Floats = NDArray[np.float64]

_SAMPLES = 20_000  # points that are measured: the standard error of their RMS is below 1 %


def rms_residual(points: Floats, mesh: Mesh) -> float | None:
    """Return the RMS distance of (N, 3) points to a mesh; of very many, a regular part is measured.

    None without points or without faces.
    """
    if not len(points) or not len(mesh.faces):
        return None
    some = points[:: -(-len(points) // _SAMPLES)]
    return float(np.sqrt(np.mean(distances_to(some, mesh) ** 2)))


def distances_to(points: Floats, mesh: Mesh) -> Floats:
    """Return the distances of (N, 3) points to the triangles of a mesh, shape (N,).

    Boxes around the triangles make a tree; branches that are farther than the nearest triangle so far are
    left out.

    Examples
    --------
    >>> corner = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    >>> distances_to(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), corner).round(6).tolist()
    [0.57735, 1.0]
    """
    from core.surface.boxes import order_of, tree_of  # noqa: PLC0415 # numba, which requests need not import
    from core.surface.triangles import nearest  # noqa: PLC0415

    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    order = order_of((a + b + c) / 3.0)
    corners = np.stack((a, b, c), axis=1)[order]
    a, b, c = (corners[:, k] for k in range(3))
    tree = tree_of(np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c))
    squares: Floats = nearest(np.ascontiguousarray(points, np.float64), corners, tree)
    return np.sqrt(squares)
