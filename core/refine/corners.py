"""Corners: places where a curve turns within the noise, kept sharp.

A regression whose windows are eight sigma wide rounds a corner off. Where the rounded course turns sharply,
rivals are built: two parabolic strokes that meet in a corner, fitted together with those of neighbouring
corners, and the same with the corner rounded off by an arc. The samples decide by their likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.corner_evidence import LEAST_TURN, sharp_ones
from core.refine.corner_sets import SIDE_SAMPLES, CornerSet, SmoothCurve, fitted, knots_of, polished
from core.refine.polyline import Polyline

__all__ = ["Corner", "find_corners", "sharpened"]

Floats = NDArray[np.float64]

LEAST_NOISE = 0.02  # of the spacing of samples
MOST_NOISE = 0.02  # of the length: where the whole curve is fifty sigma long, there is no telling
APART = 0.6  # in lengths over which the regression rounds off: nearer bends are one
FREE = 0.8  # share of a side towards no other corner that rules the curve
LEVEL = 1e-6  # radians: between straight chords the turn stays the same, and rounding must not choose
ROUNDS = 5


@dataclass(frozen=True, slots=True, eq=False)
class Corner:
    """A corner and the course that its sides give to the curve around it.

    Attributes
    ----------
    station : float
        Of the corner on the smooth curve.
    place : (3,) array
    low, high : float
        Stations between which its sides rule.
    before, after : (M, 3) arrays
        Courses of the sides from ``low`` to the corner and from there to ``high``, without the corner.
    errors : tuple of (M,) arrays and float
        Standard errors across the course: of ``before``, of the corner, of ``after``.
    """

    station: float
    place: Floats
    low: float
    high: float
    before: Floats
    after: Floats
    errors: tuple[Floats, float, Floats]


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
    if len(points) < 4 * SIDE_SAMPLES or not 0.0 < sigma < MOST_NOISE * line.length:
        return []
    order = np.argsort(station)
    # Samples without noise show a corner no better than their spacing lets them.
    sigma = max(sigma, LEAST_NOISE * line.length / len(points))
    curve = SmoothCurve(points[order], station[order], line, sigma)
    bends = _sharp_stations(line, curve.look)
    kept = bends
    fits: list[CornerSet] = []
    whole: list[bool] = []
    known: dict[bytes, tuple[CornerSet, NDArray[np.bool_]]] = {}
    for _ in range(ROUNDS):
        fits, sharp = [], []
        for knots, ring in knots_of(kept, bends, curve):
            key = knots.tobytes()
            if key not in known:
                fit = fitted(knots, ring, curve)
                known[key] = fit, sharp_ones(fit, curve)
            fits.append(known[key][0])
            sharp.append(known[key][1])
        whole = [bool(one.all()) for one in sharp]
        if all(whole):
            break
        kept = np.sort(np.concatenate([f.corners[p] for f, p in zip(fits, sharp, strict=True)]) % line.length)
    sure = [polished(fit, curve) for fit, all_sharp in zip(fits, whole, strict=True) if all_sharp]
    return _corners(sure, curve)


def _sharp_stations(line: Polyline, look: float) -> Floats:
    """Stations where the turn has a local maximum, seen from afar or from near."""
    found = np.concatenate([_turns(line, look), _turns(line, 0.5 * look)])
    if not len(found):
        return found
    # Those from afar come first, and rule out others beside them.
    away = np.abs(found[:, None] - found)
    if line.closed:
        away = np.minimum(away, line.length - away)
    kept: list[int] = []
    for k in range(len(found)):
        if all(away[k, j] > APART * look for j in kept):
            kept.append(k)
    return np.sort(found[kept])


def _turns(line: Polyline, look: float) -> Floats:
    """Stations of the local maxima of the turn between the directions ``look`` before and after."""
    length = line.length
    s = np.linspace(0.0, length, int(np.clip(8.0 * length / look, 32, 20000)), endpoint=not line.closed)
    inside = np.ones(len(s), np.bool_) if line.closed else (s > 2.0 * look) & (s < length - 2.0 * look)
    before = line.at(s - 0.5 * look) - line.at(s - 1.5 * look)
    after = line.at(s + 1.5 * look) - line.at(s + 0.5 * look)
    norms = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    cosine = np.einsum("ij,ij->i", before, after) / np.maximum(norms, 1e-300)
    turn = np.where(inside, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    reach = 6
    padded = np.concatenate([turn[-reach:], turn, turn[:reach]]) if line.closed else np.pad(turn, reach)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=1)
    return _middles(s, (turn > around - LEVEL) & (turn > LEAST_TURN), line)


def _middles(s: Floats, top: NDArray[np.bool_], line: Polyline) -> Floats:
    """Middles of the runs of equidistant stations that are marked; around a closed line there is none."""
    if top.all():
        return np.zeros(0)
    # Seen from a station between runs, none goes over the seam.
    base = int(np.argmin(top)) if line.closed else 0
    ahead = np.roll(top, -base)
    edges = np.diff(np.concatenate([[0], ahead.astype(np.int8), [0]]))
    middle = 0.5 * (np.flatnonzero(edges > 0) + np.flatnonzero(edges < 0) - 1)
    return np.asarray((s[base] + (s[1] - s[0]) * middle) % line.length)


def _corners(fits: Sequence[CornerSet], curve: SmoothCurve) -> list[Corner]:
    """Corners with their sides, in order of station."""
    if not fits:
        return []
    length, closed = curve.line.length, curve.line.closed
    order = sorted(
        (float(s) % length if closed else float(s), f, j)
        for f, fit in enumerate(fits)
        for j, s in enumerate(fit.corners)
    )
    stations = np.array([s for s, _, _ in order])
    around = length if closed else np.inf
    gaps = np.diff(np.concatenate([[stations[-1] - around], stations, [stations[0] + around]]))
    return [
        _corner(fits[f], j, s, (float(gaps[k]), float(gaps[k + 1])), curve)
        for k, (s, f, j) in enumerate(order)
    ]


def _corner(fit: CornerSet, j: int, s: float, gaps: tuple[float, float], curve: SmoothCurve) -> Corner:
    """Corner ``j`` of a set, with its sides as far as half way to the next corners."""
    before, after = fit.sides(j)
    lengths = [float(fit.knots[k + 1] - fit.knots[k]) for k in (before, after)]
    shares = [min(FREE, 0.5 * gap / length) for gap, length in zip(gaps, lengths, strict=True)]
    counts = [
        max(int(np.ceil(share * length / (0.5 * curve.sigma) - 1e-6)), 8)  # rounding must not add one
        for share, length in zip(shares, lengths, strict=True)
    ]
    t_before = 1.0 - shares[0] * np.linspace(1.0, 0.0, counts[0] + 1)[:-1]
    t_after = shares[1] * np.linspace(0.0, 1.0, counts[1] + 1)[1:-1]
    flat = not np.any(np.ptp(curve.points[:, 2]))
    e_before = fit.strokes.error_at(before, np.append(t_before, 1.0), flat)
    e_after = fit.strokes.error_at(after, np.append(0.0, t_after), flat)
    return Corner(
        s,
        fit.place(j),
        s - shares[0] * lengths[0],
        s + shares[1] * lengths[1],
        fit.strokes.at(before, t_before),
        fit.strokes.at(after, t_after),
        (e_before[:-1], float(max(e_before[-1], e_after[0])), e_after[1:]),
    )


def sharpened(line: Polyline, corners: list[Corner]) -> Polyline:
    """Put corners with their sides into a smooth curve, in place of its course around them.

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
        offset = stations - corner.low
        if line.closed:
            offset = offset % line.length
        keep &= (offset < 0.0) | (offset > corner.high - corner.low)
    courses = [np.concatenate([c.before, c.place[None], c.after]) for c in corners]
    slots = np.searchsorted(stations[keep], [c.station for c in corners])
    pieces = np.split(line.vertices[keep], slots)
    woven = [pieces[0]]
    for course, piece in zip(courses, pieces[1:], strict=True):
        woven += [course, piece]
    return Polyline(np.concatenate(woven), line.closed)
