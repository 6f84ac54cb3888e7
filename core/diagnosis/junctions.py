"""Places where branches are near each other because they meet: crossings, and ends on other branches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.crossings import crossings
from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["Junctions"]

Floats = NDArray[np.float64]

FLATTEST = np.radians(25.0)  # branches that meet at less run side by side,
NARROWEST = np.radians(8.0)  # unless they are the two sides of a corner
TURNED = np.radians(110.0)  # within an arm either side: a corner, whose sides come near each other
ROOM = 3.0  # in sigma: how much farther than straight branches would
SLACK = 1.5  # may they be near each other
TOUCH = 4.0  # in sigma: an end this near another branch is on it
ARM = 10.0  # in sigma: over which the direction of an end is taken


@dataclass(frozen=True, slots=True, eq=False)
class Junctions:
    """Where branches meet.

    Attributes
    ----------
    places : (K, 3) array
    angles : (K,) array
        At which they meet, in radians; no less than branches that do not run side by side.
    sigma : float
    """

    places: Floats
    angles: Floats
    sigma: float

    @classmethod
    def of(cls, curves: Sequence[Polyline], sigma: float, flat: bool) -> Junctions:
        """Find the crossings of curves in a plane, and the ends that lie on another branch.

        Parameters
        ----------
        curves : sequence of Polyline
        sigma : float
            Noise standard deviation.
        flat : bool
            Whether they lie in a plane.
        """
        met = [(m.place, float(np.radians(m.angle))) for m in (crossings(curves) if flat else [])]
        met = [(place, max(angle, FLATTEST)) for place, angle in met + _ends(curves, sigma)]
        met += [tip for line in curves for tip in _tips(line, sigma)]
        places = np.array([place for place, _ in met]).reshape(-1, 3)
        return cls(places, np.array([angle for _, angle in met]), sigma)

    def explain(self, place: Floats, gap: float) -> bool:
        """Whether branches are near each other at a place because they meet next to it."""
        if not len(self.places):
            return False
        reach = (0.5 * max(gap, self.sigma) / np.sin(0.5 * self.angles)) * SLACK
        away = np.linalg.norm(self.places - place, axis=1)
        return bool(np.any(away < reach + ROOM * self.sigma))

    def is_near(self, place: Floats, reach: float) -> bool:
        """Whether branches meet within a reach, or within the noise, of a place."""
        away = np.linalg.norm(self.places - place, axis=1)
        return bool(np.any(away < reach + ROOM * self.sigma))


def _ends(curves: Sequence[Polyline], sigma: float) -> list[tuple[Floats, float]]:
    """Ends of open curves that lie on another branch."""
    out: list[tuple[Floats, float]] = []
    if not sigma > 0.0:
        return out
    for k, line in enumerate(curves):
        if line.closed:
            continue
        for way in (np.array([0.0, ARM * sigma]), line.length - np.array([0.0, ARM * sigma])):
            tip, back = line.at(way)
            others = [
                _without(each, way[0], 3.0 * ARM * sigma) if j == k else each for j, each in enumerate(curves)
            ]
            others = [each for each in others if len(each.vertices) > 1]
            if not others:
                continue
            feet = project(np.stack([tip, back]), others, max(TOUCH, 2.0 * ARM) * sigma)
            if feet.distance[0] < TOUCH * sigma:
                rise = min(float(feet.distance[1]), ARM * sigma)
                out.append((tip, float(np.arcsin(rise / (ARM * sigma)))))
    return out


def _without(line: Polyline, station: float, reach: float) -> Polyline:
    """The rest of a curve beyond a reach from one of its ends."""
    stations = line.stations[: len(line.vertices)]
    return Polyline(line.vertices[np.abs(stations - station) > reach], False)


def _tips(line: Polyline, sigma: float) -> list[tuple[Floats, float]]:
    """Places where a curve turns back, and the angle between its two sides."""
    if not 0.0 < sigma < 0.01 * line.length:
        return []
    s = _every(line, 2.0 * sigma)
    inner = 0.6 * ARM * sigma
    here = line.at(s)
    before, after = here - line.at(s - inner), line.at(s + inner) - here
    norms = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", before, after) / np.maximum(norms, 1e-300), -1.0, 1.0))
    around = np.max([np.roll(turn, k) for k in (-2, -1, 0, 1, 2)], axis=0)
    at = s[(turn > TURNED) & (turn >= around) & (norms > 0.0)]
    spread = [
        np.linalg.norm(line.at(at + k * ARM * sigma) - line.at(at - k * ARM * sigma), axis=1) for k in (1, 2)
    ]
    angle = 2.0 * np.arcsin(np.clip((spread[1] - spread[0]) / (2.0 * ARM * sigma), 0.0, 1.0))
    angle = np.where(angle < NARROWEST, FLATTEST, angle)
    return [(place, float(each)) for place, each in zip(line.at(at), angle, strict=True)]


def _every(line: Polyline, step: float) -> Floats:
    """Stations about a step apart, clear of the ends of an open curve."""
    count = int(min(line.length / step, 20_000))
    if line.closed:
        return np.linspace(0.0, line.length, count, endpoint=False)
    return np.linspace(0.0, line.length, count)[4:-4]
