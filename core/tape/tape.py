"""The tape polygon T_sigma, approximated by small triangles (§4.3, 4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.cloud.balls import Balls
from core.tape.delaunay import Triangulation, triangulate
from core.tape.polygon import tape_polygon
from core.tape.small_triangles import HOLE, Smallness, SmallTriangles, small_triangles

__all__ = ["Tape", "approximate_tape"]

CLOSE = 1.0  # in sigma: clefts narrower than twice this are closed,
CLEFT = 2.5  # or than twice this many spacings of samples, where those are nearer
HALF_WIDTH = 0.5  # of that: what every edge of the tape has at least
STRAIGHT = 0.1  # of that: how far chains of edges may be off when they are simplified
LEAST_HOLE = np.pi  # in sigma squared
SPARSE = 0.3  # of the distance between samples along the curve: half-width of a tape with little noise
THINNEST = 1e-4  # of the extent: the same where that is less
QUARTER = 4  # chords a quarter circle


@dataclass(frozen=True, slots=True, eq=False)
class Tape:
    """The tape polygon and what it was made from.

    Attributes
    ----------
    polygon : shapely.MultiPolygon
        Outer loops and holes L_0 ... L_m (§4.4.1).
    mesh : Triangulation
        Delaunay triangles of the samples.
    small : SmallTriangles
        Which of them are kept.
    """

    polygon: shapely.MultiPolygon
    mesh: Triangulation
    small: SmallTriangles


def approximate_tape(
    points: NDArray[np.float64],
    balls: Balls,
    thinning: float,
    sigma: float,
    extent: float,
    smallness: Smallness,
) -> Tape | None:
    """Build the tape of a planar point set.

    Parameters
    ----------
    points : (N, 2) array
    balls : Balls
        Optimal local balls, at least one of them found.
    thinning : float
        Share of the samples that the balls were found with.
    sigma : float
        Noise estimate.
    extent : float
        Radius of the point set.
    smallness : Smallness

    Returns
    -------
    Tape or None
        None when all points are collinear: then there is no triangle.
    """
    mesh = triangulate(points)
    if not len(mesh.triangles):
        return None
    small = small_triangles(mesh, balls, thinning, smallness)
    polygon = tape_polygon(mesh, small.accepted)
    sigma = smallness.level * max(sigma, THINNEST * extent)
    reach = min(CLOSE * sigma, max(CLEFT * small.spacing, THINNEST * extent))
    along = thinning / float(np.median(balls.density[balls.found]))
    reach = max(reach, SPARSE * along)
    parts = [polygon]
    if len(small.bridges):  # long lines with few vertices are widened much faster than their edges
        lines = shapely.line_merge(shapely.multilinestrings(points[small.bridges]))
        parts.append(shapely.simplify(lines, STRAIGHT * reach))
    body = shapely.GeometryCollection(parts).buffer(reach, quad_segs=QUARTER)
    body = body.buffer((HALF_WIDTH - 1.0) * reach, quad_segs=QUARTER)
    log_n = float(np.log(max(len(points), 2)))
    least = max(HOLE * log_n * small.spacing**2, LEAST_HOLE * sigma**2)
    return Tape(_without_small_holes(body, least), mesh, small)


def _without_small_holes(body: shapely.Geometry, least: float) -> shapely.MultiPolygon:
    """Fill holes and drop islands of less area than ``least``: iid samples leave them by chance."""
    parts = shapely.get_parts(body)
    large = parts[shapely.area(parts) >= least]
    parts = large if len(large) else parts
    return shapely.MultiPolygon(
        [
            shapely.Polygon(part.exterior, [h for h in part.interiors if shapely.Polygon(h).area >= least])
            for part in parts
            if not part.is_empty
        ]
    )
