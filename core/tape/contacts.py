"""Where curves in a plane meet: where they cross, and where one ends on another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.refine.crossings import crossings
from core.refine.polyline import Polyline

__all__ = ["Contact", "contacts"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FAR = 4.0  # times the distance of touching: a curve that ends on itself has come back from at least there


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """A place (3,) where two curves, or one twice, meet, with the arc length there on each."""

    place: Floats
    curves: tuple[int, int]
    stations: tuple[float, float]


def contacts(curves: Sequence[Polyline], touching: float) -> list[Contact]:
    """Find proper crossings, and ends of open curves on others.

    Parameters
    ----------
    curves : sequence of Polyline
        In the plane z = 0.
    touching : float
        An open curve that stops within this distance before another curve, or a far part of itself,
        ends on it; the first station is then that of the end. Ends near other ends do not count.
    """
    met = [Contact(m.place, m.curves, m.stations) for m in crossings(curves)]
    return met + _endings(curves, _ways_to_crossings(curves, met), touching)


def _ways_to_crossings(curves: Sequence[Polyline], met: Sequence[Contact]) -> dict[tuple[int, bool], float]:
    """Arc length from each end of a curve, (curve, whether the last), to its nearest crossing."""
    length = [line.length for line in curves]
    ways: dict[tuple[int, bool], float] = {}
    for contact in met:
        for k, s in zip(contact.curves, contact.stations, strict=True):
            ways[k, False] = min(ways.get((k, False), np.inf), s)
            ways[k, True] = min(ways.get((k, True), np.inf), length[k] - s)
    return ways


def _endings(
    curves: Sequence[Polyline], ways: dict[tuple[int, bool], float], touching: float
) -> list[Contact]:
    """Ends of open curves on others; those that reach beyond are crossings already."""
    ends = [
        (k, last)
        for k, line in enumerate(curves)
        for last in (False, True)
        if not line.closed and ways.get((k, last), np.inf) > touching
    ]
    if not ends:
        return []
    targets = _Targets.of(curves)
    tips = shapely.points([curves[k].vertices[-1 if last else 0, :2] for k, last in ends])
    which, segments = targets.tree.query(tips, predicate="dwithin", distance=touching)
    out = []
    for n, (k, last) in enumerate(ends):
        foot = targets.foot(tips[n], segments[which == n], k, last, touching)
        if foot is not None:
            place, curve, station = foot
            out.append(Contact(place, (k, curve), (targets.length[k] if last else 0.0, station)))
    return out


@dataclass(frozen=True, slots=True, eq=False)
class _Targets:
    """Segments of all curves, on which ends may lie."""

    tree: shapely.STRtree
    curve: Ints
    station: Floats
    length: list[float]
    closed: list[bool]

    @classmethod
    def of(cls, curves: Sequence[Polyline]) -> _Targets:
        parts = [np.stack(line.segments(), axis=1)[:, :, :2] for line in curves]
        return cls(
            shapely.STRtree(shapely.linestrings(np.concatenate(parts))),
            np.repeat(np.arange(len(curves)), [len(part) for part in parts]),
            np.concatenate([line.stations[:-1] for line in curves]),
            [line.length for line in curves],
            [line.closed for line in curves],
        )

    def foot(
        self, tip: shapely.Point, segments: Ints, k: int, last: bool, touching: float
    ) -> tuple[Floats, int, float] | None:
        """Nearest place on another curve, or on a far part of this one; not on another end."""
        lines = self.tree.geometries[segments]
        along = shapely.line_locate_point(lines, tip)
        station, curve = self.station[segments] + along, self.curve[segments]
        length, closed = np.array(self.length)[curve], np.array(self.closed)[curve]
        way = length - station if last else station
        at_end = ~closed & ((station <= touching) | (station >= length - touching))
        fit = np.flatnonzero(~at_end & ((curve != k) | (way > FAR * touching)))
        if not len(fit):
            return None
        best = fit[np.argmin(shapely.distance(lines[fit], tip))]
        foot = shapely.line_interpolate_point(lines[best], along[best])
        if np.any(
            shapely.crosses(np.delete(lines, fit), shapely.linestrings([tip.coords[0], foot.coords[0]]))
        ):
            return None
        place = shapely.get_coordinates(foot)[0]
        return np.append(place, 0.0), int(curve[best]), float(station[best])
