"""What a contestant is told of a point set. Tapeline is told nothing of it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Answer", "Told", "subset"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FEW = 3000  # samples for those peers whose time explodes; the others of the set are not used


@dataclass(frozen=True, slots=True)
class Told:
    """The truth that the peers may use; lengths in the units of the points.

    Attributes
    ----------
    sigma : float
        The noise.
    length : float
        Of all true curves together.
    closed : tuple of bool
        Of each true curve.
    starts : tuple of (24, 2) lists
        A coarse polygon of each true curve.
    every : bool
        Whether slow peers must use every sample, as when their time is measured.
    """

    sigma: float
    length: float
    closed: tuple[bool, ...]
    starts: tuple[list[list[float]], ...] = ()
    every: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        return asdict(self)

    @classmethod
    def of_json(cls, known: dict[str, Any]) -> Told:
        """Make it from what JSON held."""
        return cls(
            known["sigma"], known["length"], tuple(known["closed"]), tuple(known["starts"]), known["every"]
        )

    def largest_gap(self, n: int) -> float:
        """Return the largest gap to be expected between neighbours of n independent samples."""
        return float(np.log(max(n, 3)) * self.length / n)


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a contestant found: ready curves, or a graph that others must read.

    Attributes
    ----------
    curves : list of ((M, 2) vertices, closed), or None
    vertices, edges : (V, 2) and (E, 2) arrays, or None
        A graph whose edges are straight.
    """

    curves: list[tuple[Floats, bool]] | None = None
    vertices: Floats | None = None
    edges: Ints | None = None


def subset(points: Floats, told: Told) -> Floats:
    """Return at most :data:`FEW` of the points, unless every one counts; they come in random order."""
    return points if told.every else points[:FEW]
