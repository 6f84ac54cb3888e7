"""Sets of neighbouring corners, whose sides run from one to the next and are fitted together."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline
from core.refine.sides import Nodes, Strokes, fit_strokes, line_nodes, straight_enough, strokes_along

__all__ = ["SIDE_SAMPLES", "CornerSet", "SmoothCurve", "fitted", "knots_of", "polished"]

Floats = NDArray[np.float64]

LOOK = 8.0  # in sigma: a rounded corner turns within this distance either side
SIDE = 25.0  # in sigma: length of the sides that are continued
SIDE_SAMPLES = 12
CLEAR = 3.0  # in sigma: sides end this much before the next bend
CROWD = 60.0  # samples a sigma of length: more would not tell more
BEYOND = 6.0  # in sigma: how far the course beyond the sides adds to the density


@dataclass(frozen=True, slots=True, eq=False)
class SmoothCurve:
    """A smooth curve and its samples in order of their stations."""

    points: Floats
    station: Floats
    line: Polyline
    sigma: float

    @property
    def spacing(self) -> float:
        """Of the samples along the curve."""
        return self.line.length / len(self.points)

    @property
    def look(self) -> float:
        """How far the regression rounds a corner off."""
        return max(LOOK * self.sigma, 3.0 * self.spacing)

    @property
    def longest(self) -> float:
        """Length of a side that meets nothing."""
        return max(SIDE * self.sigma, self.look + SIDE_SAMPLES * self.spacing)

    def between(self, low: float, high: float, crowd: float = CROWD) -> Floats:
        """Samples between two stations, every k-th where they are more than enough."""
        offset = self.station - low
        if self.line.closed:
            offset = offset % self.line.length
        inside = np.flatnonzero((offset >= 0.0) & (offset <= high - low))
        enough = crowd * (high - low) / self.sigma
        return self.points[inside[:: int(len(inside) / enough) + 1]]


def knots_of(kept: Floats, bends: Floats, curve: SmoothCurve) -> list[tuple[Floats, bool]]:
    """Knots of each set of corners whose sides run from one to the next; and whether they make a ring."""
    if not len(kept):
        return []
    length, closed = curve.line.length, curve.line.closed
    ahead = np.append(kept, kept[0] + length)
    gaps = np.diff(ahead)
    # No side runs over a bend that is none of the corners.
    others = np.sort(np.concatenate([bends, bends + length]))
    between = np.searchsorted(others, ahead[1:] - 1e-9 * length) - np.searchsorted(
        others, ahead[:-1] + 1e-9 * length
    )
    linked = (gaps <= curve.longest) & (between == 0)
    linked[-1] &= closed
    if linked.all() and len(kept) > 2:
        return [(ahead, True)]
    first = int(np.flatnonzero(~linked)[0]) + 1 if closed and not linked.all() else 0
    turned = np.concatenate([kept[first:], kept[:first] + length])
    breaks = np.flatnonzero(~np.roll(linked, -first)[:-1]) + 1
    return [(_with_ends(group, kept, bends, curve), False) for group in np.split(turned, breaks)]


def _with_ends(group: Floats, kept: Floats, bends: Floats, curve: SmoothCurve) -> Floats:
    """Corners with the far ends of their outer sides."""
    low = group[0] - _room(group[0], -1.0, kept, bends, curve)
    high = group[-1] + _room(group[-1], 1.0, kept, bends, curve)
    return np.concatenate([[low], group, [high]])


def _room(s: float, way: float, kept: Floats, bends: Floats, curve: SmoothCurve) -> float:
    """Length of the side that leaves a corner towards no other one."""
    length, sigma = curve.line.length, curve.sigma
    room = curve.longest
    # Other corners are rounded off in the course that lies beyond the side; other bends are as they are.
    for others, margin in ((kept, curve.look), (bends, CLEAR * sigma)):
        away = way * (others - s)
        if curve.line.closed:
            away = away % length
        away = away[(away > 1e-9 * length) & (away < length * (1.0 - 1e-9))]
        if len(away):
            gap = float(away.min())
            room = min(room, max(gap - margin, 0.5 * gap if others is kept else 0.0, min(gap, curve.look)))
    if not curve.line.closed:
        room = min(room, length - s if way > 0.0 else s)
    return min(room, 0.45 * length)


@dataclass(frozen=True, slots=True, eq=False)
class CornerSet:
    """Sides of a set of corners, fitted together."""

    knots: Floats
    strokes: Strokes
    samples: Floats
    beyond: Nodes

    @property
    def corners(self) -> Floats:
        """Stations of the corners."""
        return self.knots[:-1] if self.strokes.ring else self.knots[1:-1]

    def sides(self, j: int) -> tuple[int, int]:
        """Strokes before and after corner ``j``."""
        return ((j - 1) % self.strokes.count, j) if self.strokes.ring else (j, j + 1)

    def place(self, j: int) -> Floats:
        """Corner ``j``."""
        return np.asarray(self.strokes.control[2 * j if self.strokes.ring else 2 * j + 2])

    @property
    def node_stations(self) -> Floats:
        """Stations that the nodes would have on the smooth curve."""
        stroke = self.strokes.fraction.astype(np.int64)
        return np.asarray(self.knots[stroke] + (self.strokes.fraction - stroke) * np.diff(self.knots)[stroke])


def fitted(knots: Floats, ring: bool, curve: SmoothCurve) -> CornerSet:
    """Fit the sides of neighbouring corners together."""
    line, sigma = curve.line, curve.sigma
    samples = curve.between(float(knots[0]), float(knots[-1]))
    beyond = Nodes.none()
    if not ring:
        reach = min(BEYOND * sigma, 0.5 * (line.length - (knots[-1] - knots[0])))
        for low, high in ((knots[0] - reach, knots[0]), (knots[-1], knots[-1] + reach)):
            if reach > 0.0:
                beyond = beyond.joined(line_nodes(line, float(low), float(high), sigma))
    start = strokes_along(line, knots, ring, sigma)
    if not len(samples):
        return CornerSet(knots, start, samples, beyond)
    bent = fit_strokes(samples, start, beyond, sigma)[0]
    strokes = fit_strokes(samples, straight_enough(bent), beyond, sigma)[0]
    return CornerSet(knots, strokes, samples, beyond)


def polished(fit: CornerSet, curve: SmoothCurve) -> CornerSet:
    """The same, fitted to all samples."""
    samples = curve.between(float(fit.knots[0]), float(fit.knots[-1]), np.inf)
    if len(samples) <= len(fit.samples):
        return fit
    return replace(
        fit, strokes=fit_strokes(samples, fit.strokes, fit.beyond, curve.sigma)[0], samples=samples
    )
