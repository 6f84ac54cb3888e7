"""What a mesh says of itself: computed from its faces, nothing assumed of how it was made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
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
    used = np.unique(faces)
    edges = _Edges.of(faces)
    fans = _parts(3 * len(faces), *edges.corner_links())
    components = _parts(len(faces), edges.first // 3, edges.second // 3)
    euler = int(len(used) - edges.count + len(faces))
    borders = edges.borders()
    return SurfaceReport(
        closed=edges.closed,
        manifold=edges.manifold and fans == len(used),
        components=components,
        euler=euler,
        genus=max(0, (2 * components - borders - euler) // 2),
        volume=volume_of(mesh),
        area=float(0.5 * np.sqrt((_normals(mesh) ** 2).sum(axis=1)).sum()),
        self_intersections=self_intersections(mesh),
        completed_levels=completed_levels,
        method=method,
    )


def is_sound(report: SurfaceReport) -> bool:
    """Whether the mesh bounds a solid: closed, manifold, no face cutting another, inside inside."""
    return report.closed and report.manifold and not report.self_intersections and report.volume > 0.0


def volume_of(mesh: Mesh) -> float:
    """Signed volume, positive when faces are counter-clockwise seen from outside."""
    centred = mesh.vertices - mesh.vertices.mean(axis=0) if len(mesh.vertices) else mesh.vertices
    a = centred[mesh.faces[:, 0]]
    return float((a * _normals(mesh)).sum() / 6.0)


def _normals(mesh: Mesh) -> Floats:
    """Normals (F, 3), as long as twice the area."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normals: Floats = np.cross(b - a, c - a)
    return normals


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Half-edges paired; half-edge 3 f + k runs from corner k of face f to the next.

    Attributes
    ----------
    count : int
        Of undirected edges.
    first, second : (P,) arrays of int
        Half-edges that are alone in both directions of their edge.
    loose : (L,) array of int
        Half-edges without another in the opposite direction.
    ends : (H, 2) array of int
    closed, manifold : bool
    """

    count: int
    first: Ints
    second: Ints
    loose: Ints
    ends: Ints
    closed: bool
    manifold: bool

    @classmethod
    def of(cls, faces: Ints) -> _Edges:
        ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
        total = int(faces.max(initial=0)) + 1
        keys = ends.min(axis=1) * total + ends.max(axis=1)
        order = np.argsort(keys, kind="stable")
        starts = np.flatnonzero(np.concatenate(([True], np.diff(keys[order]) != 0))[: len(keys)])
        counts = np.diff(np.append(starts, len(keys)))
        twice = starts[counts == 2]
        first, second = order[twice], order[twice + 1]
        opposite = ends[first, 0] == ends[second, 1]
        oriented = bool(opposite.all()) and not np.any(ends[:, 0] == ends[:, 1])
        return cls(
            len(starts),
            first[opposite],
            second[opposite],
            order[starts[counts == 1]],
            ends,
            closed=bool((counts == 2).all()) and oriented and len(faces) > 0,
            manifold=bool((counts <= 2).all()) and oriented,
        )

    def corner_links(self) -> tuple[Ints, Ints]:
        """Pairs of corners (3 f + k) of one vertex in faces that share an edge there."""
        a, b = self.first, self.second
        return np.concatenate((a, _next(a))), np.concatenate((_next(b), b))

    def borders(self) -> int:
        """Number of loops of loose edges."""
        vertices, ends = np.unique(self.ends[self.loose], return_inverse=True)
        ends = ends.reshape(-1, 2)
        return _parts(len(vertices), ends[:, 0], ends[:, 1])


def _next(half_edges: Ints) -> Ints:
    return half_edges - half_edges % 3 + (half_edges + 1) % 3


def _parts(count: int, a: Ints, b: Ints) -> int:
    """Number of connected parts of ``count`` things with links a - b."""
    links = coo_array((np.ones(len(a)), (a, b)), (count, count))
    return int(connected_components(links, directed=False)[0]) if count else 0
