"""Parts of results as shapes on the paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.results import Ball, Crossing, Curve, TapePolygon
from service.render.plane import paper_of
from service.render.scenes import COLOURS, Area, Circle, Marks, Path

__all__ = ["BORDER", "TAPE", "Pen"]

Floats = NDArray[np.float64]

TAPE, BORDER = "#DCEAF4", "#8FB3CC"
_INK = "#000000"
_LARGEST, _SMALLEST = 1e100, 1e-100  # beyond these, squares and ratios leave the range of floats


@dataclass(frozen=True, slots=True)
class Pen:
    """Projects on one paper, in input units times ``1 / unit``."""

    unit: float
    paper: Callable[[Floats], Floats]

    @classmethod
    def of(cls, sets: Iterable[Floats]) -> Pen:
        """Choose unit and paper for all (N, d) arrays that are to be drawn."""
        arrays = list(sets)
        unit = _unit(arrays)
        return cls(unit, paper_of([array / unit for array in arrays]))

    def __call__(self, places: Floats) -> Floats:
        """Project (N, d) places."""
        return self.paper(places / self.unit)

    def curve(self, number: int, curve: Curve) -> Path:
        """Give a curve its colour by its number."""
        name = f"curve {number} ({'closed' if curve.closed else 'open'})"
        return self.path(number, curve.vertices, curve.closed, name)

    def path(self, number: int, vertices: Floats, closed: bool, name: str) -> Path:
        """Give a polyline its colour by its number."""
        turn, colour = divmod(number, len(COLOURS))
        return Path(self(vertices), closed, COLOURS[colour], turn, name)

    def crossings(self, crossings: Iterable[Crossing]) -> tuple[Marks, ...]:
        """Mark where curves cross, if they do."""
        places = [crossing.location for crossing in crossings]
        return (Marks(self(np.array(places)), _INK, "crossings"),) if places else ()

    def circle(self, ball: Ball) -> Circle:
        """Draw a ball as large as it is."""
        x, y = self(ball.centre[None])[0].tolist()
        return Circle(x, y, ball.radius / self.unit)

    def tape(self, tape: Iterable[TapePolygon], name: str = "") -> tuple[Area, ...]:
        """Fill each polygon but for its holes."""
        return tuple(
            Area(tuple(self(ring) for ring in (polygon.outer, *polygon.holes)), TAPE, BORDER, name)
            for polygon in tape
        )


def _unit(arrays: Iterable[Floats]) -> float:
    """Return 1, or for sizes near the ends of the floats the power of two that brings them near 1."""
    largest = max((float(np.abs(array).max()) for array in arrays if len(array)), default=1.0)
    if largest == 0 or _SMALLEST < largest < _LARGEST:
        return 1.0
    return math.ldexp(
        1.0, max(math.frexp(largest)[1] - 1, -1021)
    )  # a subnormal unit would overflow as 1 / unit
