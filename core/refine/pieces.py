"""A curve with corners: its smooth pieces are fitted one by one, one-sidedly at the corners."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from core.refine.corners import Corner, sharpened
from core.refine.course import Rules, fit_course
from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["fit_pieces"]

Floats = NDArray[np.float64]

LEAST_SAMPLES = 12


def fit_pieces(
    points: Floats, line: Polyline, corners: list[Corner], sigma: float, rules: Rules
) -> tuple[Polyline, Floats]:
    """Refit a curve between its corners.

    Parameters
    ----------
    points : (N, 3) array
        Samples of this curve.
    line : Polyline
        The smooth curve, open or closed.
    corners : list of Corner
        At least one, in order of station.
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
    sharp = sharpened(line, corners)
    marks = np.array([int(np.argmin(np.linalg.norm(sharp.vertices - c.place, axis=1))) for c in corners])
    if sharp.closed:  # begin at a corner, and come back to it
        sharp = Polyline(np.roll(sharp.vertices, -marks[0], axis=0), True)
        marks = np.append(np.sort((marks - marks[0]) % len(sharp.vertices)), len(sharp.vertices))
    else:
        marks = np.concatenate([[0], marks, [len(sharp.vertices) - 1]])
    feet = project(points, [sharp], rules.cut * sigma)
    ring, stations = sharp.ring, sharp.stations
    vertices, errors = [], []
    for first, last in pairwise(marks.tolist()):
        low, high = stations[first], stations[last]
        # Samples whose foot is the corner itself belong to no side.
        mine = (feet.curve == 0) & (feet.station > low) & (feet.station < high)
        piece = ring[first : last + 1].copy()
        error = np.zeros(len(piece))
        if np.count_nonzero(mine) >= LEAST_SAMPLES and high > low:
            course = fit_course(
                points[mine], feet.station[mine] - low, feet.distance[mine], high - low, False, sigma, rules
            )
            piece, error = course.vertices, course.error
            piece[0] = ring[first] if first > 0 or sharp.closed else piece[0]
            piece[-1] = ring[last] if last < len(ring) - 1 or sharp.closed else piece[-1]
        vertices.append(piece[:-1])
        errors.append(error[:-1])
    if not sharp.closed:
        vertices.append(piece[-1:])
        errors.append(error[-1:])
    return Polyline(np.concatenate(vertices), sharp.closed), np.concatenate(errors)
