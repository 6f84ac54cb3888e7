"""Hairpins: where a curve turns back within a few sigma of itself.

The ends of two branches that run side by side look like one branch that turns back. Whether it does
is asked of the samples; here is where to ask, and what the curves are if it does not.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = ["hairpins", "without"]

WINDOW = 12.0  # in sigma: half the length within which a hairpin turns
TURN = 2.6  # radians
PARALLEL = 0.75  # of the distance at the window's ends, half way to the turn
APART = 3.0  # in sigma: nearer branches are one to the eye
STEP = 1.0  # in sigma
GAP = 5.0  # in sigma: half of what is taken out
MOST_STATIONS = 20_000
LEAST_PIECE = 12.0  # in sigma


def hairpins(line: Polyline, sigma: float) -> list[float]:
    """Find the stations where a curve turns back.

    Parameters
    ----------
    line : Polyline
    sigma : float
        Noise about it.
    """
    length = line.length
    # With so little noise ends of neighbouring branches are not mistaken for a turn.
    if not length / MOST_STATIONS < STEP * sigma < 0.25 * length / WINDOW:
        return []
    count = int(length / (STEP * sigma))
    step = length / count
    s = np.arange(count + (0 if line.closed else 1)) * step
    x = line.at(s)
    edge = np.diff(np.concatenate([x, x[:1]]) if line.closed else x, axis=0)
    ahead = _directions(edge, max(round(WINDOW * sigma / step / 3.0), 1), line.closed)
    reach = max(round(WINDOW * sigma / step / 1.5), 1)
    if line.closed:
        cosine = np.einsum("ij,ij->i", np.roll(ahead, reach, axis=0), np.roll(ahead, -reach, axis=0))
        at = s
    elif len(ahead) > 2 * reach:
        cosine = np.einsum("ij,ij->i", ahead[: -2 * reach], ahead[2 * reach :])
        at = s[reach : reach + len(cosine)]
    else:
        return []
    turn = np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)), np.float64)
    found = _apart(np.asarray(at, np.float64), turn, 2.0 * WINDOW * sigma, length if line.closed else np.inf)
    middles = [_middle(line, place, WINDOW * sigma) for place in found]
    return [place for place in middles if _is_parallel(line, place, WINDOW * sigma)]


def _middle(line: Polyline, place: float, reach: float) -> float:
    """Where near a place the branches either side are nearest to each other: the turn's middle."""
    places = place + np.linspace(-0.5, 0.5, 25) * reach
    return float(places[np.argmin(_width(line, places, reach))])


def _is_parallel(line: Polyline, place: float, reach: float) -> bool:
    """Whether the branches run side by side, unlike those of a sharp corner."""
    near, far = (float(_width(line, np.array([place]), r)[0]) for r in (0.5 * reach, reach))
    return near > max(PARALLEL * far, APART / WINDOW * reach)


def _width(line: Polyline, places: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Distance between the stations so far before and behind each place."""
    return np.asarray(np.linalg.norm(line.at(places + reach) - line.at(places - reach), axis=1))


def _directions(edge: NDArray[np.float64], width: int, closed: bool) -> NDArray[np.float64]:
    """Mean directions of the edges about each."""
    padded = np.pad(edge, ((width, width), (0, 0)), mode="wrap" if closed else "edge")
    total = np.concatenate([np.zeros((1, 3)), np.cumsum(padded, axis=0)])
    mean = total[2 * width + 1 :] - total[: -2 * width - 1]
    return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None])


def _apart(at: NDArray[np.float64], turn: NDArray[np.float64], apart: float, period: float) -> list[float]:
    """The sharpest turns, none near a sharper one."""
    out: list[float] = []
    for k in np.argsort(-turn, kind="stable").tolist():
        if turn[k] < TURN:
            break
        ways = [abs(float(at[k]) - other) for other in out]
        if all(min(way, period - way) > apart for way in ways):
            out.append(float(at[k]))
    return sorted(out)


def without(line: Polyline, places: Sequence[float], sigma: float) -> list[Polyline]:
    """Cut a curve at stations, and take a little out around each.

    Parameters
    ----------
    line : Polyline
    places : sequence of float
        Stations, ascending.
    sigma : float
    """
    if not places:
        return [line]
    gap, length = GAP * sigma, line.length
    if line.closed:
        spans = [(a + gap, b - gap) for a, b in zip(places, [*places[1:], places[0] + length], strict=True)]
    else:
        bounds = [-gap, *places, length + gap]
        spans = [(a + gap, b - gap) for a, b in itertools.pairwise(bounds)]
    return [
        Polyline(line.at(np.linspace(low, high, int(np.clip((high - low) / sigma, 8, MOST_STATIONS)))), False)
        for low, high in spans
        if high - low > LEAST_PIECE * sigma
    ]
