"""How far scan points lie from a mesh: exact distances to its triangles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.surface.results import Mesh

__all__ = ["distances_to", "rms_residual"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_SAMPLES = 20_000  # points that are measured: the standard error of their RMS is below 1 %
_FIRST, _LAST = 8, 512  # triangles that are tried for each point, at first and at most
_CHUNK = 1_000_000  # pairs of a point and a triangle at a time


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

    Triangles are tried by the distance of their centres, those of one size together, until no other one
    can be nearer; or 512 of a size have been tried, where all of them are much the same: a point
    that far off is too far by less than the size of a triangle.

    Examples
    --------
    >>> corner = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    >>> distances_to(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), corner).round(6).tolist()
    [0.57735, 1.0]
    """
    corners = mesh.vertices[mesh.faces]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    best = np.array(cKDTree(mesh.vertices[np.unique(mesh.faces)]).query(points)[0], np.float64)
    for some in _sizes(radii):
        _approach(points, corners[some], centres[some], float(radii[some].max()), best)
    return best


def _sizes(radii: Floats) -> Iterator[Ints]:
    """Yield the triangles of each size, within a factor of two, the smallest first."""
    octave = np.frexp(radii)[1]
    for one in np.unique(octave):
        yield np.flatnonzero(octave == one)


def _approach(points: Floats, corners: Floats, centres: Floats, radius: float, best: Floats) -> None:
    """Lower the distances ``best`` to those of triangles with circles of at most that radius."""
    from core.surface.triangles import approach  # noqa: PLC0415 # numba, which requests need not import

    tree = cKDTree(centres)
    waiting, count = np.arange(len(points)), min(_FIRST, len(centres))
    while len(waiting):
        left = []
        for some in np.array_split(waiting, -(-len(waiting) * count // _CHUNK)):
            away, which = (np.reshape(one, (len(some), count)) for one in tree.query(points[some], count))
            approach(points, some, corners, which, away, radius, best)
            left.append(some[away[:, -1] - radius < best[some]])
        if count in {len(centres), _LAST}:
            return
        waiting, count = np.concatenate(left), min(4 * count, _LAST, len(centres))
