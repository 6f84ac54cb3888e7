"""Crossings that may be none: branches that run side by side, or touch and turn away, within the noise.

Where two branches meet they must soon be apart again, else the course of neither is known. And the samples
about a crossing lie on two lines, y = +-t x; about two branches that bend away from each other they lie on a
hyperbola, y^2 = t^2 x^2 + h^2. The likelihood of the samples tells one from the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.branches import LEAST_GAP
from core.refine.crossings import Meeting, crossings
from core.refine.polyline import Polyline

__all__ = ["Doubt", "doubtful_meetings"]

Floats = NDArray[np.float64]

ARMS = np.arange(6.0, 18.5, 2.0)  # in sigma: at one of these distances branches are apart
BOX = 7.0  # in sigma: samples about a crossing by which it is judged
MOST_SAMPLES = 20_000
LEAST_SAMPLES = 40
SLOPES = np.array([0.7, 0.85, 1.0, 1.2, 1.45])  # factors: a wrong reading has wrong directions
HALF_GAPS = np.array([0.0, 0.7, 0.9, 1.15, 1.45, 1.8, 2.25, 2.8])  # in sigma
NATS = 7.0  # by which two branches that touch describe the samples better than two that cross
FLAT = 30.0  # degrees: branches that meet at less touch rather than cross, unless the samples tell
FLAT_HALF_GAP = 0.9  # in sigma: of such a touch at least
STRAY = 1e-3  # density of outliers, in units of sigma
STEEPEST = 1.05  # slope of an arm against the bisector; the other bisector has the steeper one


@dataclass(frozen=True, slots=True, eq=False)
class Doubt:
    """A crossing that may be none, and how far apart the two branches are there."""

    place: Floats
    gap: float


def doubtful_meetings(points: Floats, curves: Sequence[Polyline], sigma: float) -> list[Doubt]:
    """Find the crossings of curves in a plane that may be none.

    Parameters
    ----------
    points : (N, 3) array
        Samples, in the plane z = 0.
    curves : sequence of Polyline
    sigma : float
        Noise standard deviation.
    """
    if not sigma > 0.0:
        return []
    out: list[Doubt] = []
    for met in crossings(curves):
        if any(np.linalg.norm(met.place - one.place) < 10.0 * sigma for one in out):
            continue
        apart = _apart(curves, met, sigma)
        if apart is not None and apart < LEAST_GAP * sigma:
            out.append(Doubt(met.place, apart))
            continue
        gap = _touching(points, curves, met, sigma)
        if gap is not None:
            out.append(Doubt(met.place, gap))
    return out


def _apart(curves: Sequence[Polyline], met: Meeting, sigma: float) -> float | None:
    """How far apart branches get next to their crossing, on the side where they do less.

    None next to the end of a curve, where they are not followed.
    """
    one, other = (curves[k] for k in met.curves)
    s, t = met.stations
    reach = ARMS * sigma
    for line, station in ((one, s), (other, t)):
        if not line.closed and not ARMS[-1] * sigma < station < line.length - ARMS[-1] * sigma:
            return None
    arms = one.at(s + reach), one.at(s - reach)
    others = other.at(t + reach), other.at(t - reach)
    sides = [[np.linalg.norm(a - b, axis=1) for b in others] for a in arms]
    # Of the two arms of the other branch the nearer one runs beside this arm.
    return min(min(float(b.max()) for b in a) for a in sides)


def _touching(points: Floats, curves: Sequence[Polyline], met: Meeting, sigma: float) -> float | None:
    """Distance of two branches that touch where curves were seen to cross; None where they cross."""
    u, w = (_direction(curves[k], s, BOX * sigma) for k, s in zip(met.curves, met.stations, strict=True))
    if u is None or w is None:
        return None
    near = points[np.all(np.abs(points - met.place) < 3.0 * BOX * sigma, axis=1)]
    w = w if u @ w >= 0.0 else -w
    best: float | None = None
    for along, across in ((u + w, u - w), (u - w, u + w)):
        slope = float(np.linalg.norm(across) / max(float(np.linalg.norm(along)), 1e-300))
        if slope > STEEPEST or slope < 1e-3:
            continue
        x = (near - met.place) @ along / np.linalg.norm(along) / sigma
        y = (near - met.place) @ across / np.linalg.norm(across) / sigma
        inside = (np.abs(x) < BOX) & (np.abs(y) < 1.5 * slope * BOX + 5.0)
        gap = _likeliest(x[inside], y[inside], slope, met.angle < FLAT)
        best = gap if best is None else max(best, gap or 0.0)
    return None if best is None else best * sigma


def _direction(line: Polyline, station: float, reach: float) -> Floats | None:
    if not line.closed and not reach < station < line.length - reach:
        return None
    ends = line.at(np.array([station - reach, station + reach]))
    chord = ends[1] - ends[0]
    size = float(np.linalg.norm(chord))
    return chord / size if size > 0.0 else None


def _likeliest(x: Floats, y: Floats, slope: float, flat: bool) -> float | None:
    """Gap of the likeliest hyperbola, unless two lines are as likely; of flat ones, unless much likelier."""
    if len(x) < LEAST_SAMPLES:
        return None
    weight = max(1.0, len(x) / MOST_SAMPLES)
    if weight > 1.0:
        few = np.argsort(x * x + y * y)[:: int(np.ceil(weight))]
        x, y = x[few], y[few]
    told = np.array([[_told(x, y, slope * factor, h) for factor in SLOPES] for h in HALF_GAPS]).max(axis=1)
    least = FLAT_HALF_GAP if flat else HALF_GAPS[0]
    k = int(np.argmax(np.where(least > HALF_GAPS, -np.inf, told)))
    return float(2.0 * HALF_GAPS[k]) if told[k] > told[0] + (-NATS if flat else NATS) else None


def _told(x: Floats, y: Floats, slope: float, half_gap: float) -> float:
    """Log likelihood of y, given x."""
    spread = np.sqrt(1.0 + slope * slope)  # noise across a slanting branch, seen along y
    course = np.sqrt((slope * x) ** 2 + half_gap**2)
    density = np.exp(-0.5 * ((y - course) / spread) ** 2) + np.exp(-0.5 * ((y + course) / spread) ** 2)
    return float(np.log(0.4 / spread * 0.5 * density + STRAY).sum())
