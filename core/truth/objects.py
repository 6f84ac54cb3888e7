"""Built-in solids with exact truth: what a scanner sees, and how far a reconstruction is from it.

Each solid is an implicit function of about 100 units across, with its number of components and their
genus; nothing is read from files.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from core.errors import InvalidParameter
from core.surface.results import Mesh
from core.truth.fields import Field, ball, capsule, carved, ellipsoid, gradient, ring, union

__all__ = ["Solid", "distances", "normals", "on_surface", "reference_mesh", "solid", "solid_names"]

Floats = NDArray[np.float64]

_STEP = 1e-5  # of the extent, for differences: their error is 1e-10 of the curvature
_FEET = 24  # rounds towards the nearest point; far fewer do near the surface


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A solid with a smooth closed surface.

    Attributes
    ----------
    name, description : str
    field : callable
        From (N, 3) points to (N,) values: negative inside, zero on the surface.
    box : (2, 3) array
        Lower and upper corner of a box around it, with some room.
    genera : tuple of int
        The genus of each component.
    """

    name: str
    description: str
    field: Field
    box: Floats
    genera: tuple[int, ...]

    @property
    def components(self) -> int:
        """Number of parts that do not touch."""
        return len(self.genera)

    @property
    def genus(self) -> int:
        """The sum of the components' genera."""
        return sum(self.genera)

    @property
    def extent(self) -> float:
        """The longest edge of the box."""
        return float(np.ptp(self.box, axis=0).max())


def solid_names() -> tuple[str, ...]:
    """Return the names of the built-in solids."""
    return tuple(_SOLIDS)


def solid(name: str) -> Solid:
    """Return the solid of that name.

    Raises
    ------
    InvalidParameter
        When there is none, at ``("name",)``.

    Examples
    --------
    >>> torus = solid("torus")
    >>> torus.components, torus.genus
    (1, 1)
    """
    if name not in _SOLIDS:
        known = ", ".join(_SOLIDS)
        raise InvalidParameter(f"There is no solid of that name; the names are {known}.", ("name",))
    return _SOLIDS[name]


def normals(one: Solid, points: Floats) -> Floats:
    """Return the outward unit normals at (N, 3) points on or near the surface."""
    slope = gradient(one.field, points, _STEP * one.extent)
    unit: Floats = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    return unit


def on_surface(one: Solid, points: ArrayLike, rounds: int = 8) -> Floats:
    """Take (N, 3) points near the surface onto it, along the gradient (Newton)."""
    places = np.array(points, np.float64)
    for _ in range(rounds):
        value = one.field(places)
        slope = gradient(one.field, places, _STEP * one.extent)
        step = value / np.maximum(np.einsum("ij,ij->i", slope, slope), 0.05)  # near 1 but in creases
        places -= step[:, None] * slope
    return places


@lru_cache(maxsize=16)
def _reference(name: str, resolution: int) -> Mesh:
    from skimage.measure import marching_cubes  # noqa: PLC0415 # half a second, and only for references

    one = solid(name)
    low, high = one.box
    pitch = one.extent / resolution
    axes = [np.arange(a - pitch, b + 2.0 * pitch, pitch) for a, b in zip(low, high, strict=True)]
    values = np.empty([len(axis) for axis in axes], np.float64)
    for k, x in enumerate(axes[0]):  # a layer at a time: the whole grid with its temporaries is large
        layer = np.stack(np.meshgrid([x], axes[1], axes[2], indexing="ij"), axis=-1)
        values[k] = one.field(layer.reshape(-1, 3)).reshape(values.shape[1:])
    cubes = marching_cubes(values, 0.0, spacing=(pitch,) * 3)  # type: ignore[no-untyped-call]
    vertices, faces = cubes[0], cubes[1]
    origin = np.array([axis[0] for axis in axes])
    return Mesh(on_surface(one, vertices.astype(np.float64) + origin), faces.astype(np.int64))


def reference_mesh(one: Solid, resolution: int = 128) -> Mesh:
    """Return a closed mesh of a built-in solid whose vertices lie on the surface.

    Marching cubes on ``resolution`` cells along the longest edge of the box; then each vertex is
    taken onto the zero set. With edges h and radii of curvature r its faces sag by about h² / (8 r).
    """
    return _reference(one.name, resolution)


def distances(one: Solid, points: ArrayLike) -> Floats:
    """Return the distances of (N, 3) points to the surface of a built-in solid, shape (N,).

    The foot of each point is sought from the nearest vertex of the reference mesh: a step in the
    tangent plane towards the point, a step back onto the surface, and so on.
    """
    places = np.asarray(points, np.float64)
    mesh = reference_mesh(one)
    feet = mesh.vertices[cKDTree(mesh.vertices).query(places)[1]]
    best = np.linalg.norm(places - feet, axis=1)
    moving = np.arange(len(places))
    for _ in range(_FEET):
        feet = _nearer_feet(one, places[moving], feet)
        nearer = np.linalg.norm(places[moving] - feet, axis=1)
        still = np.abs(nearer - best[moving]) > 1e-10 * one.extent
        best[moving] = np.minimum(best[moving], nearer)
        moving, feet = moving[still], feet[still]
        if not len(moving):
            break
    return np.asarray(best)


def _nearer_feet(one: Solid, places: Floats, feet: Floats) -> Floats:
    """Move feet on the surface towards the points of which they are to be the nearest places."""
    normal = normals(one, feet)
    way = places - feet
    way -= np.einsum("ij,ij->i", way, normal)[:, None] * normal
    return on_surface(one, feet + way, 2)


def _bust() -> Field:
    """Return a head on shoulders: skull, jaw, nose, brow, ears, eye sockets, neck and chest; face to -y."""
    eyes = [ball(5.5, (side * 9.5, -26.0, 68.0)) for side in (-1.0, 1.0)]
    ears = [ellipsoid((3.5, 5.0, 8.5), (side * 24.5, 1.0, 65.0)) for side in (-1.0, 1.0)]
    skull = ellipsoid((23.0, 27.0, 27.0), (0.0, 0.0, 74.0))
    jaw = ellipsoid((16.0, 17.0, 20.0), (0.0, -8.0, 55.0))
    head = carved(union(skull, jaw, blend=10.0), *eyes, blend=4.0)
    nose = capsule((0.0, -25.5, 69.0), (0.0, -29.5, 60.0), 3.0)
    lips = ellipsoid((7.5, 4.0, 3.2), (0.0, -22.5, 50.0))
    face = union(head, nose, *ears, blend=4.0)
    neck = capsule((0.0, 2.0, 20.0), (0.0, 0.0, 55.0), 12.5)
    chest = ellipsoid((46.0, 22.0, 20.0), (0.0, 3.0, 14.0))
    base = ellipsoid((26.0, 20.0, 10.0), (0.0, 2.0, 3.0))
    return union(
        union(face, lips, blend=3.0), union(neck, union(chest, base, blend=6.0), blend=14.0), blend=6.0
    )


def _fork() -> Field:
    """Return a branching Y: one stem that becomes two arms."""
    stem = capsule((0.0, 0.0, 12.0), (0.0, 0.0, 48.0), 12.0)
    arms = [capsule((0.0, 0.0, 48.0), (side * 28.0, 6.0 * side, 88.0), 10.0) for side in (-1.0, 1.0)]
    return union(stem, *arms, blend=8.0)


def _box(*corners: float) -> Floats:
    return np.array(corners, np.float64).reshape(2, 3)


_SOLIDS = {
    one.name: one
    for one in (
        Solid("ball", "a sphere", ball(50.0), _box(-52, -52, -52, 52, 52, 52), (0,)),
        Solid(
            "ellipsoid",
            "an ellipsoid with three different axes",
            ellipsoid((30.0, 40.0, 50.0)),
            _box(-32, -42, -52, 32, 42, 52),
            (0,),
        ),
        Solid("bust", "a head on shoulders, without edges", _bust(), _box(-49, -36, -9, 49, 31, 104), (0,)),
        Solid(
            "torus",
            "a torus that stands upright",
            ring(34.0, 15.0, axis=1),
            _box(-51, -17, -51, 51, 17, 51),
            (1,),
        ),
        Solid(
            "double_torus",
            "two tori grown together",
            union(ring(20.0, 8.5, (0.0, 0.0, -22.0), 1), ring(20.0, 8.5, (0.0, 0.0, 22.0), 1), blend=6.0),
            _box(-31, -11, -53, 31, 11, 53),
            (2,),
        ),
        Solid("fork", "a stem that branches into two arms", _fork(), _box(-41, -19, -3, 41, 19, 101), (0,)),
        Solid(
            "pair",
            "a torus and an ellipsoid apart",
            union(ring(22.0, 9.0, (-20.0, 0.0, 0.0)), ellipsoid((12.0, 16.0, 30.0), (30.0, 0.0, 6.0))),
            _box(-53, -33, -26, 44, 33, 38),
            (1, 0),
        ),
    )
}
