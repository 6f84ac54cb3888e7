"""Which Delaunay triangles are small, and so belong to the tape (§4.4).

Noise spreads the samples about a curve; their mean spacing in the core of the tape is the
yardstick for edges and areas, per place. Independent samples also leave gaps along the
curve, the longest of N about ln N mean distances long: longer triangles and edges are kept
where they lie within the strip of a local ball, and so bridge along the curve only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.balls import Balls
from core.tape.delaunay import Triangulation, areas, edge_lengths
from core.tape.polygon import edge_components, fill_holes

__all__ = ["CLEAN", "Local", "SmallTriangles", "Smallness", "small_triangles"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

EDGE = 3.2  # core spacings: longest edge of a small triangle
AREA = 1.7  # squared core spacings: its area
SLENDER = 1.3  # times the longest edge: a triangle small by its area only
GAP = 8.0  # added to ln N: how sure a gap in the samples must be to count as one
HALF_STRIP = 2.5  # in sigma
FAR = 0.5  # mean distances of samples along the curve: with less noise balls may miss parts of it
CLEAN = 0.2  # mean distances of samples along the curve: less noise makes no difference
NEAREST = 6  # balls asked for a strip
SPREAD = 5  # balls whose median is the local scale
HOLE = 3.0  # times ln N squared core spacings: smaller holes in the tape are chance


@dataclass(frozen=True, slots=True)
class Smallness:
    """What an expert has fixed; None follows from the data.

    Attributes
    ----------
    f_d : float
        Typical triangles lie in balls enlarged by this.
    f_a, f_l : float or None
        Largest area and edge, in typical ones.
    level : float
        Factor on all lengths that follow from the data.
    """

    f_d: float = 1.3
    f_a: float | None = None
    f_l: float | None = None
    level: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Local:
    """Noise and density near places: arrays of the same length.

    Attributes
    ----------
    sigma : (M,) array
    density : (M,) array
        Samples per unit length of curve.
    """

    sigma: Floats
    density: Floats

    @classmethod
    def near(cls, balls: Balls, thinning: float, places: Floats) -> Local:
        """Medians over the nearest balls, whose candidates were one sample in ``1 / thinning``."""
        found = balls.found
        _, near = cKDTree(balls.centre[found][:, :2]).query(places, min(SPREAD, int(found.sum())))
        near = np.asarray(near).reshape(len(places), min(SPREAD, int(found.sum())))
        sigma, density = balls.sigma[found], balls.density[found] / thinning
        sigma, density = np.median(sigma[near], axis=1), np.median(density[near], axis=1)
        return cls(np.maximum(sigma, CLEAN / density), density)

    @property
    def spacing(self) -> Floats:
        """(M,) mean spacing of samples in the core of a Gaussian tape."""
        return np.asarray(np.sqrt(np.sqrt(2.0 * np.pi) * self.sigma / self.density))


@dataclass(frozen=True, slots=True, eq=False)
class SmallTriangles:
    """Which triangles make the tape, and why.

    Attributes
    ----------
    enclosed, small_area, short_edges : (T,) arrays of bool
        By each criterion on its own.
    accepted : (T,) array of bool
        By any of them, false holes filled.
    bridges : (B, 2) array of int
        Edges of no accepted triangle that are short enough, or lie in a strip.
    spacing : float
        Typical spacing of samples in the core of the tape.
    """

    enclosed: Bools
    small_area: Bools
    short_edges: Bools
    accepted: Bools
    bridges: Ints
    spacing: float


def small_triangles(
    mesh: Triangulation, balls: Balls, thinning: float, smallness: Smallness
) -> SmallTriangles:
    """Choose the triangles of the tape.

    Parameters
    ----------
    mesh : Triangulation
        Of the samples, with at least one triangle.
    balls : Balls
        Optimal local balls, at least one of them found.
    thinning : float
        Share of the samples that the balls were found with.
    smallness : Smallness
    """
    lengths, area = edge_lengths(mesh), areas(mesh)
    longest = lengths.max(axis=1)
    local = Local.near(balls, thinning, mesh.points[mesh.triangles].mean(axis=1))
    spacing = smallness.level * local.spacing
    log_n = float(np.log(max(len(mesh.points), 2)))
    gap = smallness.level * (log_n + GAP) / local.density
    most_area, most_edge = _limits(mesh, balls, lengths, area, spacing, smallness)
    short_edges = longest <= most_edge
    small_area = (area <= most_area) & (longest <= SLENDER * most_edge)
    strips = _Strips.of(balls, thinning)
    enclosed = _enclosed(mesh.points, mesh.triangles, strips, longest <= gap)
    chance = HOLE * log_n * spacing**2
    accepted = fill_holes(mesh, short_edges | small_area | enclosed, chance)
    accepted = _without_islands(mesh, accepted, area, np.where(most_edge < gap, 0.0, chance))
    # Where samples are so dense that no gap is longer than a short edge there is nothing to bridge.
    sparse = most_edge < gap
    short, gap = np.where(sparse, most_edge, 0.0), np.where(sparse, gap, 0.0)
    bridges = _bridges(mesh, accepted, lengths, short, gap, strips)
    return SmallTriangles(enclosed, small_area, short_edges, accepted, bridges, float(np.median(spacing)))


def _without_islands(mesh: Triangulation, accepted: Bools, area: Floats, chance: Floats) -> Bools:
    """Drop groups of triangles of less area than chance makes far out in dense noise."""
    label, count = edge_components(mesh, accepted)
    inside = label >= 0
    total = np.bincount(label[inside], area[inside], count)
    allowed = np.bincount(label[inside], (chance * area)[inside], count) / np.maximum(total, 1e-300)
    out = accepted.copy()
    out[inside] = (total >= allowed)[label[inside]]
    return out


def _limits(
    mesh: Triangulation, balls: Balls, lengths: Floats, area: Floats, spacing: Floats, smallness: Smallness
) -> tuple[Floats, Floats]:
    """Largest area and largest edge, per triangle."""
    most_area, most_edge = AREA * spacing**2, EDGE * spacing
    if smallness.f_a or smallness.f_l:
        typical = _typical(mesh, balls, smallness.f_d)
        if smallness.f_a:
            most_area = np.full(len(area), smallness.f_a * float(area[typical].mean()))
        if smallness.f_l:
            most_edge = np.full(len(area), smallness.f_l * float(lengths[typical].mean()))
    return most_area, most_edge


def _typical(mesh: Triangulation, balls: Balls, f_d: float) -> Bools:
    """The triangles inside enlarged balls; all of them where there are none."""
    found = np.flatnonzero(balls.found)
    tree = cKDTree(mesh.points)
    inside = np.zeros(len(mesh.triangles), np.bool_)
    for centre, radius in zip(balls.centre[found, :2], balls.radius[found], strict=True):
        member = np.zeros(len(mesh.points), np.bool_)
        member[tree.query_ball_point(centre, f_d * radius)] = True
        inside |= member[mesh.triangles].all(axis=1)
    return inside if inside.any() else np.ones(len(inside), np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class _Strips:
    """Strips along the balls that were found: arrays of length B.

    Attributes
    ----------
    centre, way : (B, 2) arrays
    radius, half : (B,) arrays
        Half of the length and of the width.
    far : (B,) array of bool
        Whether the strip goes on, bent, to where the next one's begins: without noise optimal balls are
        so small that they leave most of the curve out.
    """

    centre: Floats
    way: Floats
    radius: Floats
    half: Floats
    far: Bools

    @classmethod
    def of(cls, balls: Balls, thinning: float) -> _Strips:
        found = balls.found
        sigma, along = balls.sigma[found], thinning / balls.density[found]
        half = HALF_STRIP * np.maximum(sigma, CLEAN * along)
        centre, way = balls.centre[found][:, :2], balls.direction[found][:, :2]
        return cls(centre, way, balls.radius[found], half, sigma < FAR * along)


def _enclosed(points: Floats, shapes: Ints, strips: _Strips, asked: Bools) -> Bools:
    """Which of the asked triangles or edges (rows of vertices) lie within one ball's strip."""
    rows = np.flatnonzero(asked)
    corners = points[shapes[rows]]
    count = min(NEAREST, len(strips.centre))
    near = np.asarray(cKDTree(strips.centre).query(corners.mean(axis=1), count)[1]).reshape(len(rows), count)
    # A strip ends where its samples do; a gap begins there.
    more = 0.5 * np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    inside = np.zeros(len(rows), np.bool_)
    for k, ball in enumerate(near.T):
        off, way, radius = corners - strips.centre[ball][:, None], strips.way[ball], strips.radius[ball]
        along = np.abs(np.einsum("mkc,mc->mk", off, way))
        across = np.abs(off[..., 0] * way[:, None, 1] - off[..., 1] * way[:, None, 0])
        bend = np.where(strips.far[ball] & (k == 0), 1.0, 0.0)[:, None] * (along / radius[:, None]) ** 2
        reaches = (along <= (radius + more)[:, None]) | (bend > 0.0)
        inside |= np.all(reaches & (across <= strips.half[ball][:, None] * np.maximum(bend, 1.0)), axis=1)
    out = np.zeros(len(shapes), np.bool_)
    out[rows[inside]] = True
    return out


def _bridges(
    mesh: Triangulation,
    accepted: Bools,
    lengths: Floats,
    most_edge: Floats,
    gap: Floats,
    strips: _Strips,
) -> Ints:
    """Edges without an accepted triangle that are short, or bridge a gap along a strip."""
    t = mesh.triangles
    edge = np.concatenate([t[:, [1, 2]], t[:, [2, 0]], t[:, [0, 1]]])
    other = mesh.neighbours.T.ravel()
    bare = ~np.tile(accepted, 3) & ~((other >= 0) & accepted[np.maximum(other, 0)])
    length = lengths.T.ravel()
    short = bare & (length <= np.tile(most_edge, 3))
    asked = bare & ~short & (length <= np.tile(gap, 3))
    kept = short | _enclosed(mesh.points, edge, strips, asked)
    return np.unique(np.sort(edge[kept], axis=1), axis=0)
