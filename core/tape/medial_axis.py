"""The medial axis of a tape polygon from the Voronoi diagram of its resampled border (§4.5).

A Voronoi edge dual to an inner Delaunay edge belongs to the axis; most of them are hair,
one at every wiggle of the border. An edge is hair when the two border samples that it
separates are near each other along the border as well (Ogniewicz & Kuebler 1995).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.tape.delaunay import Triangulation, triangulate

__all__ = [
    "MOST_SAMPLES",
    "SPACING",
    "Border",
    "MedialAxis",
    "mean_width",
    "medial_axis",
    "resampled_border",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SPACING = 0.35  # of the mean width: border samples per disc enough for a smooth axis
MEASURED = 30  # times at most: a rough border is the longer, the finer one measures it
SETTLED = 1.02  # growth of the width by which it goes on
LEAST_SAMPLES = 12  # on a ring
MOST_SAMPLES = 100_000  # on all rings together, but for the least on each
SHAKE = 1e-3  # of the half-width: displacement of border samples
RATIO = 1.5  # arc over chord; a round cap has pi / 2 at its own end
RESIDUAL = 1.2  # arc less chord in disc radii; a round cap has pi - 2 at its own end


@dataclass(frozen=True, slots=True, eq=False)
class Border:
    """Equidistant samples of a polygon's rings.

    Attributes
    ----------
    points : (B, 2) array
    ring : (B,) array of int
    station : (B,) array
        Way along the ring, over chords that pass by its wiggles.
    lengths : (R,) array
        Lengths of the rings, measured so.
    """

    points: Floats
    ring: Ints
    station: Floats
    lengths: Floats


@dataclass(frozen=True, slots=True, eq=False)
class MedialAxis:
    """The Voronoi edges that make the axis, and what became of the others.

    Attributes
    ----------
    places : (V, 2) array
        Voronoi vertices: centres of discs that touch the border at three samples.
    radius : (V,) array
        Radii of these discs: the half-width of the tape.
    raw : (E, 2) array of int
        All Voronoi edges dual to inner Delaunay edges.
    kept : (E,) array of bool
        Which of them are no hair.
    border : Border
    """

    places: Floats
    radius: Floats
    raw: Ints
    kept: NDArray[np.bool_]
    border: Border

    @property
    def edges(self) -> Ints:
        """(K, 2) the Voronoi edges without hair."""
        return self.raw[self.kept]


def medial_axis(polygon: shapely.Geometry, border: Border, half_width: float) -> MedialAxis:
    """Compute the medial axis from border samples.

    Parameters
    ----------
    polygon : shapely.Polygon or shapely.MultiPolygon
        Valid, not empty, and best prepared.
    border : Border
        Samples of its rings.
    half_width : float
        Mean half-width of the polygon.
    """
    # Qhull is slow where many points lie on a line, and leaves points out that it cannot tell from an edge.
    shake = np.random.default_rng(0).uniform(-SHAKE, SHAKE, border.points.shape) * half_width
    mesh = triangulate(border.points + shake)
    inside = shapely.contains_xy(polygon, *mesh.points[mesh.triangles].mean(axis=1).T)
    places, radius = _circumcircles(mesh)
    raw, ends = _dual_edges(mesh, inside)
    arc, chord = _arc_and_chord(border, ends)
    disc = np.maximum(radius[raw].min(axis=1), half_width)
    kept = (arc > RATIO * chord) & (arc - chord > RESIDUAL * disc)
    return MedialAxis(places, radius, raw, kept, border)


def mean_width(polygon: shapely.Geometry) -> float:
    """Compute twice the area over the length of the border, as chords a share of the width long measure it.

    Parameters
    ----------
    polygon : shapely.Polygon or shapely.MultiPolygon
    """
    width = 2.0 * polygon.area / polygon.length
    for _ in range(MEASURED):
        last, width = width, 2.0 * polygon.area / resampled_border(polygon, SPACING * width).lengths.sum()
        if width < SETTLED * last:
            break
    return float(width)


def resampled_border(polygon: shapely.Geometry, spacing: float, chord: float | None = None) -> Border:
    """Place samples along every ring of a polygon, at most ``spacing`` apart unless they would be too many.

    Parameters
    ----------
    polygon : shapely.Polygon or shapely.MultiPolygon
    spacing : float
    chord : float, optional
        Length of the chords over which ways along the border are measured; by default the spacing.
    """
    least = polygon.length / MOST_SAMPLES
    spacing, chord = max(spacing, least), max(chord or spacing, least)
    points, ring, station, lengths = [], [], [], []
    middle = shapely.get_coordinates(polygon.centroid)
    for k, line in enumerate(shapely.get_rings(shapely.get_parts(polygon))):
        xy = _begun(shapely.get_coordinates(line), middle)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
        at = _equidistant(way[-1], spacing)
        marks = np.append(_equidistant(way[-1], chord), way[-1])
        passed = np.hypot(*np.diff(_along(marks, way, xy), axis=0).T)
        measured = np.concatenate([[0.0], np.cumsum(passed)])
        points.append(_along(at, way, xy))
        station.append(np.interp(at, marks, measured))
        ring.append(np.full(len(at), k, np.int64))
        lengths.append(measured[-1])
    return Border(
        np.concatenate(points), np.concatenate(ring), np.concatenate(station), np.array(lengths, np.float64)
    )


def _begun(xy: Floats, middle: Floats) -> Floats:
    """A ring from its outermost vertex on: libraries begin it where they like."""
    x = xy[:-1]
    first = int(np.argmax(np.hypot(*(x - middle).T)))
    return np.concatenate([x[first:], x[: first + 1]])


def _equidistant(length: float, spacing: float) -> Floats:
    count = max(int(np.ceil(length / spacing)), LEAST_SAMPLES)
    return np.asarray(np.arange(count, dtype=np.float64) * (length / count))


def _along(at: Floats, way: Floats, xy: Floats) -> Floats:
    """Places of a ring at arc lengths ``at``."""
    return np.column_stack([np.interp(at, way, xy[:, 0]), np.interp(at, way, xy[:, 1])])


def _circumcircles(mesh: Triangulation) -> tuple[Floats, Floats]:
    """Centres and radii of the triangles' circumcircles."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    det = 2.0 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    det = np.where(det == 0.0, np.finfo(np.float64).tiny, det)
    uu, vv = np.einsum("ij,ij->i", u, u), np.einsum("ij,ij->i", v, v)
    x = (v[:, 1] * uu - u[:, 1] * vv) / det
    y = (u[:, 0] * vv - v[:, 0] * uu) / det
    return a + np.column_stack([x, y]), np.hypot(x, y)


def _dual_edges(mesh: Triangulation, inside: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Pairs of inner triangles with a common edge, and that edge's two border samples."""
    first = np.repeat(np.arange(len(mesh.triangles)), 3)
    second = mesh.neighbours.ravel()
    both = (second > first) & inside[first] & inside[second]
    u = mesh.triangles[:, [1, 2, 0]].ravel()[both]
    v = mesh.triangles[:, [2, 0, 1]].ravel()[both]
    return np.column_stack([first[both], second[both]]), np.column_stack([u, v])


def _arc_and_chord(border: Border, ends: Ints) -> tuple[Floats, Floats]:
    """Way along the border between two samples (infinite from ring to ring), and straight across."""
    u, v = ends[:, 0], ends[:, 1]
    way = np.abs(border.station[u] - border.station[v])
    arc = np.minimum(way, border.lengths[border.ring[u]] - way)
    arc = np.where(border.ring[u] == border.ring[v], arc, np.inf)
    return arc, np.hypot(*(border.points[u] - border.points[v]).T)
