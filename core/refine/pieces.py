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


@dataclass(frozen=True, slots=True, eq=False)
class Cornered:
    """A curve with its corners; a closed one begins at a corner.

    Attributes
    ----------
    line : Polyline
    marks : (P + 1,) array of int
        Its P pieces lie between these vertices of the ring.
    """

    line: Polyline
    marks: NDArray[np.int64]


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
        return Cornered(sharp, np.concatenate([[0], marks, [len(sharp.vertices) - 1]]))
    # Begin at a corner, and come back to it.
    sharp = Polyline(np.roll(sharp.vertices, -marks[0], axis=0), True)
    return Cornered(sharp, np.append(np.sort((marks - marks[0]) % len(sharp.vertices)), len(sharp.vertices)))


def fit_pieces(
    samples: Floats, share: Share, curve: Cornered, sigma: float, rules: Rules
) -> tuple[Polyline, Floats]:
    """Refit a curve between its corners.

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
        Standard error at the vertices.
    """
    sharp = curve.line
    ring, stations = sharp.ring, sharp.stations
    vertices, errors = [], []
    for first, last in pairwise(curve.marks.tolist()):
        low, high = stations[first], stations[last]
        # Samples whose foot is the corner itself belong to no side.
        mine = share.only((share.station > low) & (share.station < high))
        piece = ring[first : last + 1].copy()
        error = np.zeros(len(piece))
        if mine.mass >= LEAST_SAMPLES and high > low:
            course = fit_course(
                samples[mine.index], mine.station - low, mine.distance, high - low, False, sigma, rules,
                weight=mine.weight,
            )  # fmt: skip
            piece, error = course.vertices, course.error
            piece[0] = ring[first] if first > 0 or sharp.closed else piece[0]
            piece[-1] = ring[last] if last < len(ring) - 1 or sharp.closed else piece[-1]
        vertices.append(piece[:-1])
        errors.append(error[:-1])
    if not sharp.closed:
        vertices.append(piece[-1:])
        errors.append(error[-1:])
    return Polyline(np.concatenate(vertices), sharp.closed), np.concatenate(errors)
