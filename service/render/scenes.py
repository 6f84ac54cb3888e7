"""What a picture shows, before it is drawn: dots, paths and circles on the paper.

The encoders of SVG and PNG draw any scene; a new type of result has to say
only what is to be seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from core.results import Curve, Partition, Reconstruction
from service.render.plane import paper_of

__all__ = ["COLOURS", "GREY", "Circle", "Dots", "Path", "Scene", "scene"]

Floats = NDArray[np.float64]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's colours, distinct to colour-blind eyes too; without the yellow, faint on white."""

GREY = "#9A9A9A"
_LARGEST, _SMALLEST = 1e100, 1e-100  # beyond these, squares and ratios leave the range of floats


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Points (N, 2) of one colour; ``name`` for the legend, or empty."""

    points: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A polyline (M, 2); ``turn`` counts how often the colours were used up before, for the dashes."""

    vertices: Floats
    closed: bool
    colour: str
    turn: int
    name: str


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle, such as a local ball of the march."""

    x: float
    y: float
    radius: float

    def box(self) -> Floats:
        """Lower and upper corner."""
        return np.array(
            [[self.x - self.radius, self.y - self.radius], [self.x + self.radius, self.y + self.radius]]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything on one sheet, in input units times ``1 / unit``; y points up."""

    title: str
    dots: tuple[Dots, ...] = ()
    paths: tuple[Path, ...] = ()
    circles: tuple[Circle, ...] = ()
    unit: float = 1.0

    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of all that is shown; a unit square about nothing."""
        corners = [group.points for group in self.dots] + [path.vertices for path in self.paths]
        corners += [circle.box() for circle in self.circles]
        full = [array for array in corners if len(array)]
        if not full:
            return np.zeros(2), np.ones(2)
        return (
            np.min([array.min(axis=0) for array in full], axis=0),
            np.max([array.max(axis=0) for array in full], axis=0),
        )


@singledispatch
def scene(result: object, points: Floats | None = None) -> Scene:  # noqa: ARG001 # registered functions use it
    """Return what there is to see of a result; register a function for each new type of result."""
    raise TypeError(f"no picture is defined for {type(result).__name__}")


@scene.register
def _(result: Partition, points: Floats | None = None) -> Scene:
    """Show the points in the colours of their components, outliers in grey."""
    if points is None:
        raise TypeError("the picture of a partition needs the points")
    unit = _unit(points)
    paper = paper_of([points / unit])(points / unit)
    groups = [Dots(paper[result.labels < 0], GREY, "outliers")]
    for turn, colour in enumerate(COLOURS):
        mine = (result.labels >= 0) & (result.labels % len(COLOURS) == turn)
        name = f"component {turn}" if result.count <= len(COLOURS) else ""
        groups.append(Dots(paper[mine], colour, name))
    shown = tuple(group for group in groups if len(group.points))
    return Scene(_count(result.count, "component") + _seen(points), shown, unit=unit)


@scene.register
def _(result: Reconstruction, points: Floats | None = None) -> Scene:
    """Show the cloud in grey, the curves in colours, and the balls of the march if any (Fig. 3)."""
    sets = [curve.vertices for curve in result.curves] + ([] if points is None else [points])
    unit = _unit(*sets)
    paper = paper_of([array / unit for array in sets])
    cloud = () if points is None else (Dots(paper(points / unit), GREY, "samples"),)
    paths = tuple(
        _path(number, curve, paper(curve.vertices / unit)) for number, curve in enumerate(result.curves)
    )
    circles = []
    for ball in result.stages.balls if result.stages else ():
        x, y = paper(ball.centre[None] / unit)[0].tolist()
        circles.append(Circle(x, y, ball.radius / unit))
    title = f"{_count(len(paths), 'curve')} ({result.method}){_seen(*sets)}"
    return Scene(title, cloud, paths, tuple(circles), unit)


def _path(number: int, curve: Curve, vertices: Floats) -> Path:
    turn, colour = divmod(number, len(COLOURS))
    name = f"curve {number} ({'closed' if curve.closed else 'open'})"
    return Path(vertices, curve.closed, COLOURS[colour], turn, name)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _seen(*sets: Floats) -> str:
    return ", projected on the best plane" if sets and sets[0].shape[1] == 3 else ""


def _unit(*sets: Floats) -> float:
    """Return 1, or for sizes near the ends of the floats the power of two that brings them near 1."""
    largest = max((float(np.abs(array).max()) for array in sets if len(array)), default=1.0)
    if largest == 0 or _SMALLEST < largest < _LARGEST:
        return 1.0
    return math.ldexp(
        1.0, max(math.frexp(largest)[1] - 1, -1021)
    )  # a subnormal unit would overflow as 1 / unit
