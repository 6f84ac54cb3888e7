"""A virtual range scanner: views of a solid from all sides, with noise, pose error and occlusion.

Rays run through the pixels of a grid, side by side (orthographic) or spread from one place; each
stops where it first meets the surface, so that parts hide others as they do for a real scanner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.errors import InvalidParameter
from core.surface.results import Pose, RangeImage
from core.truth.objects import Solid

__all__ = ["Scanner", "scan"]

Floats = NDArray[np.float64]

_STRIDE = 0.9  # of the distance to the surface that the field promises
_STEPS = 400  # at most along a ray; rays that slide along the surface take the most
_HALVINGS = 40
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class Scanner:
    """How a solid is scanned; lengths are in its units.

    Attributes
    ----------
    views : int
        Views from places spread evenly over a sphere.
    pixels : int
        Rows and columns of each grid.
    noise : float
        Standard deviation along the ray.
    pose_error : float
        Standard deviation of each coordinate of the error with which the pose of a view is known;
        its rotation shifts the outermost points by about as much.
    distance : float or None
        Distance of the scanner from the middle of the solid, in its radii; None for parallel rays.
    seed : int
        The same scanner gives the same scans.
    """

    views: int = 12
    pixels: int = 200
    noise: float = 0.1
    pose_error: float = 0.0
    distance: float | None = None
    seed: int = 0


def scan(one: Solid, scanner: Scanner | None = None) -> tuple[RangeImage, ...]:
    """Scan a solid.

    Returns
    -------
    tuple of RangeImage
        In the scanner's own frame, with their poses as known: with the pose error in them.

    Raises
    ------
    InvalidParameter
        For a scanner without views or pixels, with negative noise, or inside the solid.

    Examples
    --------
    >>> from core.truth.objects import solid
    >>> images = scan(solid("ball"), Scanner(views=3, pixels=40))
    >>> len(images), images[0].points.shape
    (3, (40, 40, 3))
    """
    scanner = scanner or Scanner()
    _check(scanner)
    rng = np.random.default_rng(scanner.seed)
    middle = one.box.mean(axis=0)
    radius = float(np.linalg.norm(one.box[1] - middle))
    return tuple(
        _view(one, scanner, _facing(direction, rng), middle, radius, rng)
        for direction in _directions(scanner.views)
    )


def _check(scanner: Scanner) -> None:
    for name, least in (("views", 1), ("pixels", 2), ("noise", 0.0), ("pose_error", 0.0)):
        if not getattr(scanner, name) >= least:
            raise InvalidParameter(f"{name} must be at least {least}.", (name,))
    if scanner.distance is not None and not scanner.distance > 1.0:
        raise InvalidParameter("The scanner must stand outside the solid: distance > 1.", ("distance",))


def _directions(count: int) -> Floats:
    """Return unit vectors spread evenly over the sphere, (count, 3), on a spiral."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = _GOLDEN * np.arange(count)
    wide = np.sqrt(1.0 - z**2)
    return np.stack((wide * np.cos(turn), wide * np.sin(turn), z), axis=1)


def _facing(direction: Floats, rng: np.random.Generator) -> Floats:
    """Return the rotation whose third column is ``direction``, turned about it by chance."""
    helper = np.eye(3)[np.argmin(np.abs(direction))]
    right = np.cross(helper, direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    turn = rng.uniform(0.0, 2.0 * np.pi)
    across = np.cos(turn) * right + np.sin(turn) * up
    return np.stack((across, np.cross(direction, across), direction), axis=1)


def _view(
    one: Solid, scanner: Scanner, rotation: Floats, middle: Floats, radius: float, rng: np.random.Generator
) -> RangeImage:
    """Take one view; the scanner looks along its own -z."""
    origins, rays = _rays(scanner, radius)
    depth = _first_hits(one, origins @ rotation.T + middle, rays @ rotation.T, 2.0 * radius * _reach(scanner))
    depth += scanner.noise * rng.standard_normal(len(depth))
    points = origins + depth[:, None] * rays
    pose = _misplaced(Pose(rotation, middle), scanner.pose_error, radius, rng)
    return RangeImage(points.reshape(scanner.pixels, scanner.pixels, 3), pose)


def _reach(scanner: Scanner) -> float:
    """Return how far rays go, in diameters of the solid."""
    return 1.0 if scanner.distance is None else scanner.distance


def _rays(scanner: Scanner, radius: float) -> tuple[Floats, Floats]:
    """Return origins and unit directions of the rays, columns along x and rows along y of the scanner."""
    ticks = ((np.arange(scanner.pixels) + 0.5) / scanner.pixels * 2.0 - 1.0) * radius
    y, x = (one.ravel() for one in np.meshgrid(ticks, ticks, indexing="ij"))
    if scanner.distance is None:
        return np.stack((x, y, np.full(len(x), radius)), axis=1), np.tile([0.0, 0.0, -1.0], (len(x), 1))
    away = scanner.distance * radius
    # the outermost rays just touch the sphere around the solid
    spread = 1.0 / np.sqrt(scanner.distance**2 - 1.0) * away / radius
    rays = np.stack((x * spread, y * spread, np.full(len(x), -away)), axis=1)
    return np.tile([0.0, 0.0, away], (len(x), 1)), rays / np.linalg.norm(rays, axis=1, keepdims=True)


def _first_hits(one: Solid, origins: Floats, rays: Floats, reach: float) -> Floats:
    """Return the way along each ray to the surface, NaN for a miss.

    Sphere tracing: each step is as long as the field promises that the way is free; where the field has
    changed its sign the root is bracketed, and halved out.
    """
    hits = np.full(len(rays), np.nan)
    way, end = _inside_box(one, origins, rays, reach)
    active = np.flatnonzero(way < end)
    before = way.copy()
    found: list[NDArray[np.int64]] = []
    least = 1e-4 * one.extent
    for _ in range(_STEPS):
        if not len(active):
            break
        value = one.field(origins[active] + way[active, None] * rays[active])
        inside = value <= 0.0
        found.append(active[inside])
        active, value = active[~inside], value[~inside]
        before[active] = way[active]
        way[active] += np.maximum(_STRIDE * value, least)
        active = active[way[active] < end[active]]
    if found and len(hit := np.concatenate(found)):
        hits[hit] = _halved(one, origins[hit], rays[hit], before[hit], way[hit])
    return hits


def _inside_box(one: Solid, origins: Floats, rays: Floats, reach: float) -> tuple[Floats, Floats]:
    """Return where each ray enters and leaves the box of the solid; the end comes first for a miss."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = ((corner - origins) / rays for corner in one.box)
    near = np.nanmax(np.where(np.isnan(first), -np.inf, np.minimum(first, second)), axis=1)
    far = np.nanmin(np.where(np.isnan(first), np.inf, np.maximum(first, second)), axis=1)
    return np.maximum(near, 0.0), np.minimum(far, reach)


def _halved(one: Solid, origins: Floats, rays: Floats, outside: Floats, inside: Floats) -> Floats:
    """Return the root between a place outside and one inside, by bisection."""
    for _ in range(_HALVINGS):
        middle = (outside + inside) / 2.0
        within = one.field(origins + middle[:, None] * rays) <= 0.0
        inside = np.where(within, middle, inside)
        outside = np.where(within, outside, middle)
    return (outside + inside) / 2.0


def _misplaced(pose: Pose, error: float, radius: float, rng: np.random.Generator) -> Pose:
    """Return a pose with an error: a small rotation about the middle of the solid, and a shift."""
    x, y, z = rng.standard_normal(3) * (error / radius)
    shift = error * rng.standard_normal(3)
    angle = float(np.sqrt(x * x + y * y + z * z))
    if angle == 0.0:
        return pose
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + np.sin(angle) / angle * skew + (1.0 - np.cos(angle)) / angle**2 * skew @ skew
    return Pose(turn @ pose.rotation, pose.translation + shift)
