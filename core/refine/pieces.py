"""A curve with corners: its smooth pieces are fitted one by one, one-sidedly at the corners."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from core.refine.corners import Corner, sharpened
from core.refine.course import Rules, fit_course
from core.refine.polyline import Polyline
from core.refine.shares import Share

__all__ = ["Cornered", "cornered", "fit_pieces"]

Floats = NDArray[np.float64]

LEAST_SAMPLES = 12
CLEAR = 3.0  # in sigma: samples of one side that may have come from the other lie so near to both
CLEAR_SHARE = 0.6  # of a side, at most


@dataclass(frozen=True, slots=True, eq=False)
class Cornered:
    """A curve with its corners; a closed one begins at a corner.

    Attributes
    ----------
    line : Polyline
    marks : (P + 1,) array of int
        Its P pieces lie between these vertices of the ring.
    corners : tuple of Corner
        In the order of the marks.
    """

    line: Polyline
    marks: NDArray[np.int64]
    corners: tuple[Corner, ...]


def cornered(line: Polyline, corners: list[Corner]) -> Cornered:
    """Put corners into a smooth curve.

    Parameters
    ----------
    line : Polyline
        Open or closed.
    corners : list of Corner
        At least one, in order of station.
    """
    sharp = sharpened(line, corners)
    marks = np.array([int(np.argmin(np.linalg.norm(sharp.vertices - c.place, axis=1))) for c in corners])
    if not sharp.closed:
        return Cornered(sharp, np.concatenate([[0], marks, [len(sharp.vertices) - 1]]), tuple(corners))
    # Begin at a corner, and come back to it.
    sharp = Polyline(np.roll(sharp.vertices, -marks[0], axis=0), True)
    turned = (marks - marks[0]) % len(sharp.vertices)
    return Cornered(sharp, np.append(turned, len(sharp.vertices)), tuple(corners))


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """A course over arc length from the beginning of a piece."""

    station: Floats
    place: Floats
    error: Floats

    @classmethod
    def of(cls, place: Floats, error: Floats, start: float = 0.0) -> _Stretch:
        steps = np.linalg.norm(np.diff(place, axis=0), axis=1)
        return cls(start + np.concatenate([[0.0], np.cumsum(steps)]), place, error)

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Places and errors at arc lengths; clamped to the ends."""
        place = np.stack([np.interp(s, self.station, self.place[:, k]) for k in range(3)], axis=1)
        return place, np.interp(s, self.station, self.error)


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """The end of a piece at a corner: its side, where that rules alone, and where it ends."""

    side: _Stretch
    clear: float
    reach: float


def fit_pieces(
    samples: Floats, share: Share, curve: Cornered, sigma: float, rules: Rules
) -> tuple[Polyline, Floats]:
    """Refit a curve between its corners.

    Near a corner its own sides rule, which share their samples by likelihood; away from it the regression.

    Parameters
    ----------
    samples : (N, 3) array
    share : Share
        Which of them are this curve's, with their feet on it.
    curve : Cornered
    sigma : float
        Noise estimate.
    rules : Rules

    Returns
    -------
    line : Polyline
        With the corners among its vertices.
    error : (M,) array
        Standard error at the vertices; NaN where no fit holds them.
    """
    closed = curve.line.closed
    ring, stations = curve.line.ring, curve.line.stations
    before = [*curve.corners[1:], curve.corners[0]] if closed else [*curve.corners, None]
    after = list(curve.corners) if closed else [None, *curve.corners]
    vertices, errors = [], []
    for (first, last), start, stop in zip(pairwise(curve.marks.tolist()), after, before, strict=True):
        low = float(stations[first])
        head = _head(start, sigma)
        tail = _tail(stop, sigma)
        given = _Stretch.of(ring[first : last + 1], np.full(last + 1 - first, np.nan))
        piece, error = _piece(samples, share, given, low, head, tail, sigma, rules)
        keep = slice(0, -1) if stop is not None else slice(None)
        vertices.append(piece[keep])
        errors.append(error[keep])
    return Polyline(np.concatenate(vertices), closed), np.concatenate(errors)


def _head(corner: Corner | None, sigma: float) -> _End | None:
    """The beginning of a piece at a corner."""
    if corner is None:
        return None
    place = np.concatenate([corner.place[None], corner.after])
    return _end(_Stretch.of(place, np.append(corner.errors[1], corner.errors[2])), corner, sigma)


def _tail(corner: Corner | None, sigma: float) -> _End | None:
    """The end of a piece at a corner, with stations that run from the corner backwards."""
    if corner is None:
        return None
    place = np.concatenate([corner.before, corner.place[None]])[::-1]
    return _end(_Stretch.of(place, np.append(corner.errors[0], corner.errors[1])[::-1]), corner, sigma)


def _end(side: _Stretch, corner: Corner, sigma: float) -> _End:
    reach = float(side.station[-1])
    return _End(side, min(CLEAR * sigma / _sine(corner), CLEAR_SHARE * reach), reach)


def _sine(corner: Corner) -> float:
    """Sine of half the angle between the sides of a corner."""
    a, b = (
        corner.before[len(corner.before) // 2] - corner.place,
        corner.after[len(corner.after) // 2] - corner.place,
    )
    cosine = float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-300)
    return max(float(np.sqrt(0.5 * (1.0 - min(cosine, 1.0)))), 1e-3)


def _piece(
    samples: Floats,
    share: Share,
    given: _Stretch,
    low: float,
    head: _End | None,
    tail: _End | None,
    sigma: float,
    rules: Rules,
) -> tuple[Floats, Floats]:
    """One piece: vertices and standard errors, from corner to corner."""
    length = float(given.station[-1])
    a, b = (0.0 if one is None else one.clear for one in (head, tail))
    course, spacing = given, _spacing(given)
    touching = head is not None and tail is not None and head.reach + tail.reach > length - 2.0 * sigma
    if not touching and length - b > a:
        mine = share.only((share.station > low + a) & (share.station < low + length - b))
        if mine.mass >= LEAST_SAMPLES:
            fit = fit_course(
                samples[mine.index], mine.station - low - a, mine.distance, length - a - b, False, sigma,
                rules, weight=mine.weight,
            )  # fmt: skip
            spacing = (length - a - b) / max(len(fit.vertices) - 1, 1)
            station = np.linspace(a, length - b, len(fit.vertices))
            course = _Stretch(station, fit.vertices, fit.error)
    count = max(int(np.ceil(length / max(rules.spacing or spacing, 1e-9 * length))), 1)
    s = np.linspace(0.0, length, count + 1)
    if head is not None and tail is not None and touching:
        return _met(head, tail, s, length)
    place, error = course.at(s)
    for one, away in ((head, s), (tail, length - s)):
        if one is not None:
            place, error = _blended(place, error, away, one)
    return place, error


def _met(head: _End, tail: _End, s: Floats, length: float) -> tuple[Floats, Floats]:
    """A piece of nothing but the sides of its corners, which both give half of the gap where they meet."""
    meeting = length * head.reach / (head.reach + tail.reach)
    here, there = (
        end.side.at(np.array([at]))[0][0] for end, at in ((head, meeting), (tail, length - meeting))
    )
    first, first_error = head.side.at(s)
    last, last_error = tail.side.at(length - s)
    first = first + 0.5 * (there - here) * (s[:, None] / meeting) ** 2
    last = last + 0.5 * (here - there) * ((length - s[:, None]) / (length - meeting)) ** 2
    near = s <= meeting
    return np.where(near[:, None], first, last), np.where(near, first_error, last_error)


def _spacing(stretch: _Stretch) -> float:
    return float(stretch.station[-1]) / max(len(stretch.station) - 1, 1)


def _blended(place: Floats, error: Floats, away: Floats, end: _End) -> tuple[Floats, Floats]:
    """A course that becomes its corner's side towards the corner."""
    side, side_error = end.side.at(away)
    ramp = np.clip((end.reach - away) / max(end.reach - end.clear, 1e-300), 0.0, 1.0)
    both = np.where(np.isnan(error), side_error, error + ramp * (side_error - error))
    return place + ramp[:, None] * (side - place), np.where(ramp > 0.0, both, error)
