"""Piecewise-linear curves as arrays: length, resampling, segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Polyline"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Polyline:
    """A PL curve in working coordinates.

    Attributes
    ----------
    vertices : (M, 3) array
        A closed curve does not repeat its first vertex.
    closed : bool
    """

    vertices: Floats
    closed: bool

    @property
    def ring(self) -> Floats:
        """(M + closed, 3) the vertices, the first one repeated when closed."""
        return np.concatenate([self.vertices, self.vertices[:1]]) if self.closed else self.vertices

    @property
    def stations(self) -> Floats:
        """(M + closed,) arc length at the ring's vertices."""
        steps = np.linalg.norm(np.diff(self.ring, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length(self) -> float:
        """Total length, the closing edge included."""
        return float(self.stations[-1])

    def at(self, s: NDArray[np.floating]) -> Floats:
        """Points at the arc lengths ``s`` (K,), as (K, 3); clamped to the ends, periodic when closed."""
        stations, ring = self.stations, self.ring
        s = np.mod(s, stations[-1]) if self.closed and stations[-1] > 0 else s
        return np.stack([np.interp(s, stations, ring[:, k]) for k in range(3)], axis=1)

    def resampled(self, spacing: float, least: int = 8) -> Polyline:
        """The same course with equidistant vertices about ``spacing`` apart."""
        length = self.length
        pieces = max(int(np.ceil(length / spacing)) if spacing > 0 else least, least)
        count = pieces if self.closed else pieces + 1
        return Polyline(self.at(np.arange(count) * np.float64(length / pieces)), self.closed)

    def segments(self) -> tuple[Floats, Floats]:
        """Start and end points of the segments, each (S, 3)."""
        ring = self.ring
        return ring[:-1], ring[1:]
