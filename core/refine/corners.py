"""Corners: places where a curve turns within the noise, kept sharp.

A regression whose windows are eight sigma wide rounds a corner off. Where the rounded
course turns sharply, a rival is built from the straight continuation of both sides, meeting in a
point; the samples decide between the two by their squared distances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["Corner", "find_corners", "sharpened"]

Floats = NDArray[np.float64]

LEAST_TURN = np.radians(35.0)
LOOK = 8.0  # in sigma: a rounded corner turns within this distance either side
ROUNDED = 2.0  # in sigma: samples nearer to the corner belong to either side
SIDE = 25.0  # in sigma: length of the sides that are continued
SIDE_SAMPLES = 12
CLEAR = 3.0  # in sigma: sides end this much before the next corner
WEIGHT = 8.0  # nats by which the corner must explain the samples better, besides ln n


@dataclass(frozen=True, slots=True, eq=False)
class Corner:
    """A corner: its station on the smooth curve, its place, and the stations between which it rules."""

    station: float
    place: Floats
    low: float
    high: float


def find_corners(points: Floats, station: Floats, line: Polyline, sigma: float) -> list[Corner]:
    """Find the corners of a curve.

    Parameters
    ----------
    points : (N, 3) array
        Samples of this curve.
    station : (N,) array
        Arc lengths of their feet on it.
    line : Polyline
        The curve, smooth as the regression left it.
    sigma : float
        Noise standard deviation.

    Returns
    -------
    list of Corner
        In order of station.
    """
    length = line.length
    if len(points) < 4 * SIDE_SAMPLES or not 0.0 < sigma < 0.01 * length:
        return []
    order = np.argsort(station)
    points, station = points[order], station[order]
    spacing = length / len(points)
    look = max(LOOK * sigma, 3.0 * spacing)
    out: list[Corner] = []
    sharp = _sharp_stations(line, look)
    longest = max(SIDE * sigma, look + SIDE_SAMPLES * spacing)
    for s, clear in zip(sharp, _clearance(sharp, line), strict=True):
        side = min(longest, float(clear) - CLEAR * sigma)
        corner = _rival(points, station, line, float(s), sigma, look, side)
        if corner is not None and (not out or corner.low > out[-1].high):
            out.append(corner)
    return out


def _sharp_stations(line: Polyline, look: float) -> Floats:
    """Stations of the local maxima of the turn between the directions ``look`` before and after."""
    length = line.length
    s = np.linspace(0.0, length, int(np.clip(8.0 * length / look, 32, 20000)), endpoint=not line.closed)
    inside = np.ones(len(s), np.bool_) if line.closed else (s > 2.0 * look) & (s < length - 2.0 * look)
    before = line.at(s - 0.5 * look) - line.at(s - 1.5 * look)
    after = line.at(s + 1.5 * look) - line.at(s + 0.5 * look)
    norms = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    cosine = np.einsum("ij,ij->i", before, after) / np.maximum(norms, 1e-300)
    turn = np.where(inside, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    reach = 8
    padded = np.concatenate([turn[-reach:], turn, turn[:reach]]) if line.closed else np.pad(turn, reach)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=1)
    return np.asarray(s[(turn >= around) & (turn > LEAST_TURN)])


def _clearance(sharp: Floats, line: Polyline) -> Floats:
    """Arc length from each sharp station to the nearest other one."""
    if len(sharp) < 2:
        return np.full(len(sharp), line.length)
    gaps = np.diff(sharp)
    around = line.length - sharp[-1] + sharp[0] if line.closed else line.length
    return np.asarray(np.minimum(np.append(around, gaps), np.append(gaps, around)))


def _rival(
    points: Floats, station: Floats, line: Polyline, s: float, sigma: float, look: float, side: float
) -> Corner | None:
    """Build the corner at ``s`` from its sides; None unless the samples prefer it to the smooth course."""
    offset = station - s
    if line.closed:
        offset = (offset + 0.5 * line.length) % line.length - 0.5 * line.length
    gap = ROUNDED * sigma
    left = points[(offset > -side) & (offset < -gap)]
    right = points[(offset > gap) & (offset < side)]
    if min(len(left), len(right)) < SIDE_SAMPLES:
        return None
    here = line.at(np.array([s]))[0]
    meeting = _meeting(_Side.of(left, here, sigma), _Side.of(right, here, sigma), here, look)
    if meeting is None:
        return None
    place, first, last = meeting
    window = np.abs(offset) < look
    samples = points[window]
    if len(samples) < 6:
        return None
    smooth = line.at(s + np.linspace(-1.5 * look, 1.5 * look, 49))
    sharp = np.concatenate([first, place[None], last])
    gain = _misfit(samples, smooth, sigma) - _misfit(samples, sharp, sigma)
    if gain < WEIGHT + np.log(len(samples)):
        return None
    return Corner(s, place, s - look, s + look)


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """A side of a corner: a parabola over its own principal axis, which points to the corner."""

    centre: Floats
    axis: Floats
    coefficients: Floats  # (3, 3): offsets = [1, t, t^2] @ coefficients

    @classmethod
    def of(cls, samples: Floats, corner: Floats, sigma: float) -> _Side:
        centre = samples.mean(axis=0)
        offset = samples - centre
        axis = np.linalg.eigh(offset.T @ offset)[1][:, -1]
        axis = axis if axis @ (corner - centre) > 0.0 else -axis
        t = offset @ axis
        across = offset - t[:, None] * axis
        basis = np.stack([np.ones_like(t), t, t * t], axis=1)
        fit = np.linalg.lstsq(basis, across, rcond=None)[0]
        # A bend that the noise explains is none: it would throw the continuation off.
        straight = np.linalg.lstsq(basis[:, :2], across, rcond=None)[0]
        gain = np.sum((across - basis[:, :2] @ straight) ** 2) - np.sum((across - basis @ fit) ** 2)
        if gain < 9.0 * sigma**2:
            fit = np.concatenate([straight, np.zeros((1, 3))])
        return cls(centre, axis, fit)

    def at(self, t: Floats) -> Floats:
        """Points (K, 3) at the places ``t`` along the axis."""
        basis = np.stack([np.ones_like(t), t, t * t], axis=1)
        return np.asarray(self.centre + t[:, None] * self.axis + basis @ self.coefficients)


def _meeting(a: _Side, b: _Side, near: Floats, look: float) -> tuple[Floats, Floats, Floats] | None:
    """Where two sides meet when they are continued: the place, and the sides from ``look`` before it."""
    ta, tb = float((near - a.centre) @ a.axis), float((near - b.centre) @ b.axis)
    ways = np.linspace(-1.5 * look, 2.5 * look, 161)
    course_a, course_b = a.at(ta + ways), b.at(tb + ways)
    away = np.linalg.norm(course_a[:, None] - course_b[None], axis=2)
    i, j = np.unravel_index(int(np.argmin(away)), away.shape)
    if away[i, j] > 0.1 * look or min(i, j) == 0 or max(i, j) == len(ways) - 1:
        return None
    place = 0.5 * (course_a[i] + course_b[j])
    before = np.linspace(ta - 2.5 * look, ta + ways[i], 25)[:-1]
    after = np.linspace(tb + ways[j], tb - 2.5 * look, 25)[1:]
    return place, a.at(before), b.at(after)


def _misfit(samples: Floats, course: Floats, sigma: float) -> float:
    """Half the sum of squared distances in units of the variance: nats."""
    reach = 10.0 * sigma
    feet = project(samples, [Polyline(course, False)], reach)
    return float(0.5 * np.sum(np.minimum(feet.distance, reach) ** 2) / sigma**2)


def sharpened(line: Polyline, corners: list[Corner]) -> Polyline:
    """Insert corners into a smooth curve as vertices, in place of its course around them.

    Parameters
    ----------
    line : Polyline
    corners : list of Corner
        In order of station.
    """
    if not corners:
        return line
    stations = line.stations[: len(line.vertices)]
    keep = np.ones(len(stations), np.bool_)
    for corner in corners:
        offset = np.abs(stations - corner.station)
        if line.closed:
            offset = np.minimum(offset, line.length - offset)
        keep &= offset >= corner.high - corner.station
    places = np.array([corner.place for corner in corners])
    at = np.concatenate([stations[keep], [corner.station for corner in corners]])
    order = np.argsort(at, kind="stable")
    return Polyline(np.concatenate([line.vertices[keep], places])[order], line.closed)
