"""What the application of the paper (§5.1.1) works on and answers with: scans, meshes, slices, surfaces.

Coordinates and lengths are in the frame and the units of the input.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from core.results import Curve, Warn

__all__ = [
    "ContourLevel",
    "Contours",
    "Mesh",
    "Pose",
    "RangeImage",
    "Scans",
    "Slice",
    "Slices",
    "Surface",
    "SurfaceReport",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A rigid motion x -> rotation @ x + translation: (3, 3) and (3,) arrays."""

    rotation: Floats
    translation: Floats


@dataclass(frozen=True, slots=True, eq=False)
class RangeImage:
    """A grid I x J -> R^3 (§5.1.1): (I, J, 3) array, NaN where nothing was seen, and where it stands.

    Rows and columns turn so that dP/dcolumn x dP/drow points out of the object, towards the scanner.
    """

    points: Floats
    pose: Pose | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles: ``vertices`` (V, 3), ``faces`` (F, 3) of indices, counter-clockwise seen from outside."""

    vertices: Floats
    faces: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """What the plane at one height cuts of all meshes.

    Attributes
    ----------
    height : float
        Along the axis.
    points : (P, 3) array
        Samples S_k of the contour, in the plane, in place.
    polylines : tuple of (M, 3) arrays
        The same, linked; a closed one does not repeat its first vertex.
    closed : tuple of bool
        One for each polyline.
    """

    height: float
    points: Floats
    polylines: tuple[Floats, ...] = ()
    closed: tuple[bool, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ContourLevel:
    """The contours of one level; ``completed`` when they were completed from the neighbours'."""

    height: float
    curves: tuple[Curve, ...]
    completed: bool = False
    warnings: tuple[Warn, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Scans:
    """What there is of an object: meshes and range images, or slices, or contours.

    Points of slices and vertices of contours are 2D in the planes' axes, or 3D in place.
    """

    meshes: tuple[Mesh, ...] = ()
    range_images: tuple[RangeImage, ...] = ()
    slices: tuple[Slice, ...] = ()
    contours: tuple[ContourLevel, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Slices:
    """Scans cut by parallel planes: by height, in place; ``axis`` (3,) is the unit vector across them."""

    axis: Floats
    slices: tuple[Slice, ...]
    warnings: tuple[Warn, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Contours:
    """Contours of all levels: by height, in place; ``axis`` (3,) is the unit vector across them.

    ``warnings`` holds those of all levels.
    """

    axis: Floats
    slices: tuple[ContourLevel, ...]
    warnings: tuple[Warn, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceReport:
    """What the mesh itself says of itself.

    Attributes
    ----------
    closed, manifold : bool
        Every edge has two faces; every vertex one fan of them.
    components, euler, genus : int
        Connected parts; V - E + F; the sum of the parts' genera.
    volume, area : float
    self_intersections : int
        Pairs of faces that cut each other without sharing a vertex or an edge.
    completed_levels : tuple of float
        Heights of levels completed from their neighbours'.
    rms_residual : float or None
        Distance of the scan points to the mesh; None without scans.
    method : str
        ``slabs`` or ``distance`` (signed-distance interpolation and marching cubes).
    """

    closed: bool
    manifold: bool
    components: int
    euler: int
    genus: int
    volume: float
    area: float
    self_intersections: int
    completed_levels: tuple[float, ...] = ()
    rms_residual: float | None = None
    method: str = "slabs"


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """One closed mesh with what is known of it, and the contours that it was made of.

    ``axis`` (3,) is the unit vector across their planes.
    """

    mesh: Mesh
    report: SurfaceReport
    slices: tuple[ContourLevel, ...] = ()
    warnings: tuple[Warn, ...] = ()
    axis: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
