"""Parts of results as shapes on the paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.results import Ball, Crossing, Curve, TapePolygon, Violation
from service.render.plane import paper_of
from service.render.scenes import ALARM, COLOURS, Area, Band, Circle, Marks, Path

__all__ = ["BAND", "BORDER", "TAPE", "Pen"]

Floats = NDArray[np.float64]

TAPE, BORDER = "#DCEAF4", "#8FB3CC"
BAND = "±2 standard errors"
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
        path = self.path(number, curve.vertices, curve.closed, name)
        return replace(path, fine=curve.standard_errors is not None)

    def path(self, number: int, vertices: Floats, closed: bool, name: str) -> Path:
        """Give a polyline its colour by its number."""
        turn, colour = divmod(number, len(COLOURS))
        return Path(self(vertices), closed, COLOURS[colour], turn, name)

    def bands(self, curves: Iterable[Curve]) -> tuple[Band, ...]:
        """Draw two standard errors to both sides of the curves that have them, in the curves' colours."""
        return tuple(
            self._band(number, curve, curve.standard_errors)
            for number, curve in enumerate(curves)
            if curve.standard_errors is not None and len(curve.vertices) > 1
        )

    def _band(self, number: int, curve: Curve, errors: Floats) -> Band:
        line = self(curve.vertices)
        reach = float(np.ptp(line, axis=0).max())  # errors beyond all bounds shall not blow the picture up
        half = np.minimum(2.0 * (errors / self.unit), reach)[:, None] * _normals(line, curve.closed)
        left, right = line + half, (line - half)[::-1]
        rings = (left, right) if curve.closed else (np.concatenate([left, right]),)
        return Band(rings, COLOURS[number % len(COLOURS)], BAND)

    def violations(self, violations: Iterable[Violation]) -> tuple[Marks, ...]:
        """Mark where the sample is not Nyquist-compliant, kind by kind."""
        kinds: dict[str, list[Floats]] = {}
        for violation in violations:
            kinds.setdefault(violation.kind, []).append(violation.location)
        return tuple(
            Marks(self(np.array(places)), ALARM, kind.replace("-", " ")) for kind, places in kinds.items()
        )

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


def _normals(line: Floats, closed: bool) -> Floats:
    """Unit normals (M, 2) at the vertices of a polyline; zero where it has no direction."""
    ends = (line[-1:], line[:1]) if closed else (line[:1], line[-1:])
    padded = np.concatenate([ends[0], line, ends[1]])
    along = padded[2:] - padded[:-2]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    unit = np.divide(along, length, out=np.zeros_like(along), where=length > 0)
    return np.column_stack([-unit[:, 1], unit[:, 0]])


def _unit(arrays: Iterable[Floats]) -> float:
    """Return 1, or for sizes near the ends of the floats the power of two that brings them near 1."""
    largest = max((float(np.abs(array).max()) for array in arrays if len(array)), default=1.0)
    if largest == 0 or _SMALLEST < largest < _LARGEST:
        return 1.0
    return math.ldexp(
        1.0, max(math.frexp(largest)[1] - 1, -1021)
    )  # a subnormal unit would overflow as 1 / unit
