"""What a mesh says of itself: computed from its faces, nothing assumed of how it was made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from core.surface.results import Mesh, SurfaceReport
from core.surface.self_intersections import self_intersections

__all__ = ["is_sound", "report_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def report_of(mesh: Mesh, method: str = "slabs", completed_levels: tuple[float, ...] = ()) -> SurfaceReport:
    """Closed, manifold, topology, volume, area and self-intersections of a mesh.

    The Euler characteristic counts the vertices that faces use. The genus of an open mesh is that
    of the mesh with each border filled.
    """
    faces = mesh.faces
    used = int(np.count_nonzero(np.bincount(faces.ravel())))
    edges = _Edges.of(faces)
    components = _parts(edges.across // 3, 3)
    euler = used - edges.count + len(faces)
    borders = edges.borders()
    normals = _normals(mesh)
    return SurfaceReport(
        closed=edges.closed,
        manifold=edges.manifold and edges.fans() == used,
        components=components,
        euler=euler,
        genus=max(0, (2 * components - borders - euler) // 2),
        volume=_volume(mesh, normals),
        area=float(0.5 * np.sqrt(np.einsum("ij,ij->i", normals, normals)).sum()),
        self_intersections=self_intersections(mesh),
        completed_levels=completed_levels,
        method=method,
    )


def is_sound(report: SurfaceReport) -> bool:
    """Whether the mesh bounds a solid: closed, manifold, no face cutting another, inside inside."""
    return report.closed and report.manifold and not report.self_intersections and report.volume > 0.0


def volume_of(mesh: Mesh) -> float:
    """Signed volume, positive when faces are counter-clockwise seen from outside."""
    return _volume(mesh, _normals(mesh))


def _volume(mesh: Mesh, normals: Floats) -> float:
    centred = mesh.vertices - mesh.vertices.mean(axis=0) if len(mesh.vertices) else mesh.vertices
    return float(np.einsum("ij,ij->", centred[mesh.faces[:, 0]], normals) / 6.0)


def _normals(mesh: Mesh) -> Floats:
    """Normals (F, 3), as long as twice the area."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
    return np.column_stack((uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx))


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Half-edges paired; half-edge 3 f + k runs from corner k of face f to the next.

    Attributes
    ----------
    count : int
        Of undirected edges.
    across : (H,) array of int
        For each half-edge the other one of its edge, if there is one only and in the opposite
        direction; else itself.
    loose : (L, 2) array of int
        Ends of half-edges that are alone on their edge.
    closed, manifold : bool
    """

    count: int
    across: Ints
    loose: Ints
    closed: bool
    manifold: bool

    @classmethod
    def of(cls, faces: Ints) -> _Edges:
        start, end = faces.ravel(), faces[:, (1, 2, 0)].ravel()
        keys = np.minimum(start, end) * (int(faces.max(initial=0)) + 1) + np.maximum(start, end)
        order = np.argsort(keys)
        keys = keys[order]
        firsts = np.flatnonzero(np.concatenate(([True], keys[1:] != keys[:-1]))[: len(keys)])
        counts = np.diff(np.append(firsts, len(keys)))
        twice, once = firsts[counts == 2], order[firsts[counts == 1]]
        one, other = order[twice], order[twice + 1]
        opposite = start[one] == end[other]
        oriented = bool(opposite.all()) and not np.any(start == end)
        across = np.arange(len(keys))
        across[one[opposite]], across[other[opposite]] = other[opposite], one[opposite]
        return cls(
            len(firsts),
            across,
            np.column_stack((start[once], end[once])),
            closed=bool((counts == 2).all()) and oriented and len(faces) > 0,
            manifold=bool((counts <= 2).all()) and oriented,
        )

    def fans(self) -> int:
        """Number of classes of corners that faces join which share an edge there."""
        corners = np.arange(len(self.across))
        after = self.across - self.across % 3 + (self.across + 1) % 3
        return _parts(np.where(self.across == corners, corners, after), 1)

    def borders(self) -> int:
        """Number of loops of loose edges."""
        vertices, ends = np.unique(self.loose, return_inverse=True)
        links = coo_array((np.ones(len(self.loose)), tuple(ends.reshape(-1, 2).T)), (len(vertices),) * 2)
        return int(connected_components(links, directed=False)[0]) if len(vertices) else 0


def _parts(links: Ints, each: int) -> int:
    """Number of connected parts of things that have links to so many others each, one after another."""
    count = len(links) // each
    starts = np.arange(0, len(links) + 1, each)
    weights: Floats = np.ones(len(links))
    graph: csr_array[np.float64, tuple[int, int]] = csr_array((weights, links, starts), (count, count))
    return int(connected_components(graph, directed=False)[0]) if count else 0
