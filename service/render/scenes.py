"""What a picture shows, before it is drawn: shapes on the paper, and sheets of several pictures.

The encoders of SVG and PNG draw any scene; a new type of result has to say
only what is to be seen, in :mod:`service.render.pictures`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ALARM",
    "COLOURS",
    "GREY",
    "Area",
    "Band",
    "Circle",
    "Dots",
    "Marks",
    "Path",
    "Picture",
    "Scene",
    "Segments",
    "Sheet",
]

Floats = NDArray[np.float64]
Bounds = tuple[Floats, Floats]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's colours, distinct to colour-blind eyes too; without the yellow, faint on white."""

GREY = "#9A9A9A"
LINE = "#6F6F6F"
ALARM = "#C00000"
"""What is wrong somewhere: darker and redder than any colour of a curve."""


@dataclass(frozen=True, slots=True, eq=False)
class Area:
    """What lies inside an odd number of closed ``rings`` (M, 2); ``line`` is the colour of its border."""

    rings: tuple[Floats, ...]
    colour: str
    line: str = "none"
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Thin straight lines (E, 2, 2) of one colour."""

    ends: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Points (N, 2) of one colour; ``name`` for the legend, or empty."""

    points: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle, such as a local ball; ``name`` for the legend, or empty."""

    x: float
    y: float
    radius: float
    colour: str = LINE
    name: str = ""

    def box(self) -> Floats:
        """Lower and upper corner."""
        return np.array(
            [[self.x - self.radius, self.y - self.radius], [self.x + self.radius, self.y + self.radius]]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A polyline (M, 2); ``turn`` counts how often the colours were used up before, for the dashes.

    A ``fine`` one lets the band beneath it be seen.
    """

    vertices: Floats
    closed: bool
    colour: str
    turn: int
    name: str
    fine: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """A translucent band along a path: what its closed ``rings`` (M, 2) go around, whichever way."""

    rings: tuple[Floats, ...]
    colour: str
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """Places (N, 2) to draw the eye to, as small rings on top of all."""

    points: Floats
    colour: str
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Pixels (H, W, 4) of red, green, blue and opacity, 0 to 255, the lowest row first, and where they lie.

    ``low`` and ``high`` (2,) are the corners of the first and the last pixel.
    """

    pixels: NDArray[np.uint8]
    low: Floats
    high: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """One picture, in input units times ``1 / unit``; y points up.

    What comes first here is drawn first, and lies below the rest. A ``bare`` one has coordinates that
    mean nothing to who looks at it, and is shown without axes.
    """

    title: str
    pictures: tuple[Picture, ...] = ()
    areas: tuple[Area, ...] = ()
    segments: tuple[Segments, ...] = ()
    dots: tuple[Dots, ...] = ()
    circles: tuple[Circle, ...] = ()
    bands: tuple[Band, ...] = ()
    paths: tuple[Path, ...] = ()
    marks: tuple[Marks, ...] = ()
    unit: float = 1.0
    bare: bool = False

    def bounds(self) -> Bounds:
        """Lower and upper corner of all that is shown; a unit square about nothing."""
        full = [array for array in self._arrays() if len(array)]
        if not full:
            return np.zeros(2), np.ones(2)
        return (
            np.min([array.min(axis=0) for array in full], axis=0),
            np.max([array.max(axis=0) for array in full], axis=0),
        )

    def key(self) -> dict[str, str]:
        """Colours by what they stand for, but for paths and their bands: those are only to be told apart."""
        groups: tuple[Area | Dots | Segments | Circle | Marks, ...]
        groups = (*self.areas, *self.dots, *self.segments, *self.circles, *self.marks)
        return {group.name: group.colour for group in groups if group.name}

    def _arrays(self) -> Iterator[Floats]:
        yield from (np.array([picture.low, picture.high]) for picture in self.pictures)
        for area in self.areas:
            yield from area.rings
        yield from (group.ends.reshape(-1, 2) for group in self.segments)
        yield from (group.points for group in self.dots)
        yield from (circle.box() for circle in self.circles)
        for band in self.bands:
            yield from band.rings
        yield from (path.vertices for path in self.paths)
        yield from (group.points for group in self.marks)


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Several pictures of one thing, by name; they show the same part of the plane at the same scale.

    That part is the ``box``, if there is one: lower and upper corner.
    """

    title: str
    panels: dict[str, Scene]
    box: Bounds | None = None

    @property
    def columns(self) -> int:
        """How many pictures stand side by side: the wider each is, the fewer."""
        width, height = np.subtract(*reversed(self.bounds()))
        return 2 if width > 1.5 * height else 4

    def bounds(self) -> Bounds:
        """Lower and upper corner of the box or the last picture: what sticks out of it elsewhere is cut."""
        if self.box is not None:
            return self.box
        *_, last = self.panels.values()
        return last.bounds()
