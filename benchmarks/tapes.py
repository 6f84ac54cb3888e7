"""Tapes whose exact axis is known: how much of a skeleton is hair, and what it leaves out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from core.truth.curves import ParametricCurve
from core.truth.metrics import distances, resample

__all__ = ["end_gap", "hair", "noisy_tape", "shortened"]

Floats = NDArray[np.float64]
Polyline = tuple[Floats, bool]

_VERTICES = 4000  # of the axis
_CAP = 64  # segments of a quarter of a round end


def noisy_tape(
    curve: ParametricCurve, half_width: float, noise: float, spacing: float, seed: int
) -> shapely.Polygon:
    """Return the places within ``half_width`` of a curve, with a rough border.

    The axis of the tape is the curve itself, provided that it nowhere bends tighter than
    ``half_width`` and keeps twice as much between its branches; an open curve has round ends.

    Parameters
    ----------
    curve : ParametricCurve
        In the plane.
    half_width : float
        In the units of the curve, like ``noise`` and ``spacing``.
    noise : float
        Standard deviation of every border vertex along the border's normal.
    spacing : float
        Distance between border vertices before they are moved.
    seed : int
    """
    rng = np.random.default_rng(seed)
    axis = curve.polyline(_VERTICES)
    line = shapely.linearrings(axis) if curve.closed else shapely.linestrings(axis)
    exact = shapely.buffer(line, half_width, quad_segs=_CAP)
    outer, *inner = (_rough(ring, noise, spacing, rng) for ring in (exact.exterior, *exact.interiors))
    sound = shapely.get_parts(shapely.make_valid(shapely.Polygon(outer, inner), method="structure"))
    largest: shapely.Polygon = sound[np.argmax(shapely.area(sound))]
    return largest


def hair(lines: Sequence[Floats], curve: ParametricCurve, distance: float) -> float:
    """Return the share of the length of a skeleton that is farther than ``distance`` from the true axis.

    Parameters
    ----------
    lines : sequence of (M, 2) arrays
        The edges of the skeleton.
    curve : ParametricCurve
    distance : float
    """
    places = np.concatenate(resample([(line, False) for line in lines]))
    return float(np.mean(distances(places, _axis(curve)) > distance))


def shortened(lines: Sequence[Floats], curve: ParametricCurve, distance: float) -> float:
    """Return the length of the true axis that no place of a skeleton is within ``distance`` of."""
    places = np.concatenate(resample(_axis(curve)))
    missed = distances(places, [(line, False) for line in lines]) > distance
    return float(np.mean(missed)) * curve.length


def end_gap(lines: Sequence[Floats], curve: ParametricCurve) -> float:
    """Return the distance from a skeleton to the end of the true axis that it stays farthest from."""
    if curve.closed:
        return 0.0
    ends = curve.evaluate([0.0, 1.0])
    return float(distances(ends, [(line, False) for line in lines]).max())


def _axis(curve: ParametricCurve) -> list[Polyline]:
    return [(curve.polyline(_VERTICES), curve.closed)]


def _rough(ring: shapely.LinearRing, noise: float, spacing: float, rng: np.random.Generator) -> Floats:
    """Resample a ring evenly, and move every vertex along the normal."""
    count = max(8, round(ring.length / spacing))
    place = np.arange(count) * ring.length / count
    vertices = shapely.get_coordinates(shapely.line_interpolate_point(ring, place))
    along = np.roll(vertices, -1, axis=0) - np.roll(vertices, 1, axis=0)
    normal = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1, keepdims=True)
    moved: Floats = vertices + noise * rng.standard_normal((count, 1)) * normal
    return moved
