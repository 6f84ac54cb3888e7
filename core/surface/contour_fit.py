"""Closed contours fitted to the samples of a slice, from first guesses that are near.

Like :mod:`core.refine` each curve becomes the local regression of its samples on the arc length of their
feet (Hastie & Stuetzle 1989), of order four, free of the bias that curvature gives. Contours are closed
and keep apart, and there are hundreds of them: what open ends, crossings and varying noise need is
left out. The half-width of the windows varies along the contour: at each place it is the one of least
C_p (Mallows 1973) around there. Samples count by bins, whose own curvature is allowed for.

The order of samples tells which are neighbours on a polyline, whose noise is alike; apart from that, and
from rounding, it does not matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.cloud.points import inverse_power_of_two
from core.refine.regression import PENALTY
from core.surface.closed_regression import (
    LEVELS,
    NARROWEST,
    bins_of,
    half_widths,
    nearest_on,
    vertices_of,
)
from core.surface.draft import GAP

__all__ = ["Fitted", "fit_contour"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bins = tuple[Ints, Floats]

CUT = 4.0  # in sigma: farther samples say nothing of the noise
SEEN = 8.0  # in sigma: farther samples say nothing of the course; a bend that is rounded off is nearer
FINE = 1.0  # distances between samples: without noise, what deviates less may be a corner
NORMAL = 1.4826  # standard deviations of normal noise in a median distance
LEAST_SAMPLES = 12
PASSES = 3
FEWEST = 8.0  # samples in half a window
RUNAWAY = 1.5  # times as far from the guess's first vertex as its own extent, or as any sample
RATIO = 1.4  # of neighbouring half-widths
LAGS, BEYOND = 3, 9  # places in a row up to which noise is alike; up to which only bias is
MOST_ALIKE = 3.0  # samples in a row that count as one: slices of meshes share vertices of triangles
CHANGE = 3.0  # times as narrow or wide as in the first pass half-widths may be in the next
FIRST_JUDGED, JUDGED = 48, 96  # places, of which C_p is known for every half-width
PASSING = 192  # vertices of the contours of passes but the last
MOST_BINS = 2048
FEWEST_VERTICES, MOST_VERTICES = 64, 4000
BENT = 0.05  # quantile of the lengths of chords that curvature allows


class Fitted(NamedTuple):
    """A contour, and where its samples lie.

    Attributes
    ----------
    vertices : (M, 2) array
        Equally far apart, the first one not repeated.
    station, distance : (N,) arrays
        Arc length of the foot of each sample, and the distance to it.
    length : float
    sigma : float
        RMS distance of the samples that took part.
    """

    vertices: Floats
    station: Floats
    distance: Floats
    length: float
    sigma: float


def fit_contour(points: Floats, guess: Floats, segments: Ints) -> Fitted | None:
    """Fit a closed contour to its samples.

    Parameters
    ----------
    points : (N, 2) array
    guess : (M, 2) array
        A first guess of the contour, the first vertex not repeated.
    segments : (N,) array of int
        Segment of the guess near which each sample lies; from there its foot is looked for downhill.

    Returns
    -------
    Fitted or None
        None where there are too few samples, or where they lead nowhere.
    """
    origin, scale = guess[:1], float(np.ptp(guess, axis=0).max())
    if len(points) < LEAST_SAMPLES or not 0.0 < scale < np.inf:
        return None
    unit = inverse_power_of_two(scale)  # squares of lengths must neither overflow nor vanish
    found = _fitted(unit * (points - origin), unit * (guess - origin), segments)
    if found is None:
        return None
    return Fitted(
        found.vertices / unit + origin,
        found.station / unit,
        found.distance / unit,
        found.length / unit,
        found.sigma / unit,
    )


def _fitted(points: Floats, ring: Floats, segments: Ints) -> Fitted | None:
    """Fit a contour about as large as one."""
    size, stations = len(points), _stations(ring)
    station, distance = nearest_on(points, ring, stations, segments)
    filled, station = _filled(points, station, ring, stations)
    widths, alike, most = np.empty(0), 1.0, np.inf
    for turn in range(PASSES):
        station, distance = _feet(filled, ring, stations, station)
        length = float(stations[-1])
        sigma, used = _noise(distance[:size], length)
        if used < LEAST_SAMPLES or not sigma < np.inf:
            return None
        seen = max(SEEN * sigma, 2.0 * FINE * length / size)
        bins = bins_of(filled, station, distance, seen, length, _bin_count(length, sigma, used))
        if turn == 1:
            alike = _alike(distance[:size], CUT * sigma)
        if turn < PASSES - 1:
            least = max(NARROWEST * sigma, FEWEST * length / used)
            if turn:
                least, most = max(least, float(widths.min()) / CHANGE), float(widths.max()) * CHANGE
            price = PENALTY * alike * sigma**2
            places, ratio = (JUDGED, RATIO) if turn else (FIRST_JUDGED, RATIO**2)
            widths = half_widths(bins, least, most, length, price, ratio, places)
        count = PASSING
        if turn == PASSES - 1:
            count = _vertex_count(vertices_of(bins, widths, length, sigma, JUDGED)[1], length)
        ring, _ = vertices_of(bins, widths, length, sigma, count)
        stations = _stations(ring)
        station *= stations[-1] / length
    if not np.abs(ring).max() <= RUNAWAY * max(float(np.abs(points).max()), 1.0):
        return None
    station, distance = _feet(points, ring, stations, station[:size])
    return Fitted(
        ring, station, np.abs(distance), float(stations[-1]), _noise(distance, float(stations[-1]))[0]
    )


def _stations(ring: Floats) -> Floats:
    """Arc length at the vertices of a closed polyline; last its whole length."""
    step = np.diff(ring, axis=0, append=ring[:1])
    return np.concatenate(([0.0], np.cumsum(np.hypot(step[:, 0], step[:, 1]))))


def _feet(points: Floats, ring: Floats, stations: Floats, near: Floats) -> tuple[Floats, Floats]:
    """Arc lengths of the feet of samples, and signed distances; ``near`` tells about where they are."""
    segment = np.clip(np.searchsorted(stations, near, side="right") - 1, 0, len(ring) - 1)
    return nearest_on(points, ring, stations, segment)  # type: ignore[no-any-return]


def _filled(points: Floats, station: Floats, ring: Floats, stations: Floats) -> tuple[Floats, Floats]:
    """Samples and their feet, with more on the ring in gaps: a polynomial across would go anywhere."""
    length, size = float(stations[-1]), len(points)
    spacing = length / size
    limit = (np.log(size) + GAP) * spacing
    known = np.sort(station)
    gap = np.diff(known, append=known[0] + length)
    wide = gap > limit
    more = [
        np.arange(low + limit / 2.0, low + wide - limit / 2.0, spacing)
        for low, wide in zip(known[wide].tolist(), gap[wide].tolist(), strict=True)
    ]
    if not more:
        return points, station
    extra = np.concatenate(more) % length
    closed = np.vstack((ring, ring[:1]))
    places = np.stack([np.interp(extra, stations, closed[:, k]) for k in range(2)], axis=1)
    return np.concatenate((points, places)), np.concatenate((station, extra))


def _noise(distance: Floats, length: float) -> tuple[float, int]:
    """RMS distance of samples but outliers, and their number."""
    away = np.abs(distance)
    median = float(np.partition(away, len(away) // 2)[len(away) // 2])
    near = away[away <= max(CUT * NORMAL * median, FINE * length / len(away))]
    return float(np.sqrt(np.dot(near, near) / max(len(near), 1))), len(near)


def _bin_count(length: float, sigma: float, samples: int) -> int:
    """A multiple of a power of two, which merges well: bins a twelfth of the narrowest window wide."""
    wished = 12.0 * length / max(NARROWEST * sigma, 1e-6 * length)
    wished = min(max(wished, 100.0), MOST_BINS, max(samples / 2.0, 16.0))
    unit = 1 << min(max(int(np.log2(wished)) - 4, 0), LEVELS - 1)
    return int(max(int(wished / unit), 1) * unit)


def _alike(distance: Floats, limit: float) -> float:
    """How many samples in a row count as one: 1 plus twice the correlations of their noise.

    What farther ones still share is no noise: the contour is not yet the right one there.
    """
    signed = np.where(np.abs(distance) <= limit, distance, 0.0)
    variance = float(np.dot(signed, signed)) / len(signed)
    shared = [
        float(np.dot(signed[lag:], signed[:-lag])) / (len(signed) - lag) for lag in range(1, BEYOND + 1)
    ]
    bias = max(sum(shared[LAGS:]) / (BEYOND - LAGS), 0.0)
    noise = sum(max(one - bias, 0.0) for one in shared[:LAGS])
    return min(1.0 + 2.0 * noise / (variance - bias), MOST_ALIKE) if variance > bias else 1.0


def _vertex_count(chords: Floats, length: float) -> int:
    """As many vertices as curvature needs, but for a few chords."""
    chord = max(float(np.quantile(chords, BENT)), 1e-9 * length)
    return int(min(max(length / chord, FEWEST_VERTICES), MOST_VERTICES))
