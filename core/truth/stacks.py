"""Random stacks of contours that are hard on whoever spans a surface through them.

Levels overlap, branch and end; contours have holes with islands in them, cross themselves and each
other, touch at points, share edges with others of their own level and of the next one, occur twice,
and levels are empty or unevenly spaced.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.results import Curve
from core.surface.results import ContourLevel

__all__ = ["closed_curve", "random_stack"]

Floats = NDArray[np.float64]

MOST_LEVELS = 7
MOST_CONTOURS = 4
LATTICE = 6  # cells along each side of the square in which lattice contours lie
EMPTY = 0.12  # share of levels
SIZE = 10.0


def random_stack(seed: int) -> tuple[ContourLevel, ...]:
    """Two to seven levels; the first one is not empty. The same seed gives the same stack."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, MOST_LEVELS + 1))
    steps = np.exp(rng.normal(0.0, rng.choice([0.0, 0.8]), count))
    heights = rng.uniform(-5.0, 5.0) + np.cumsum(steps)
    loops: list[list[Floats]] = [_level(rng)]
    for _ in range(count - 1):
        loops.append([] if rng.uniform() < EMPTY else _next_level(loops[-1], rng))
    return tuple(
        ContourLevel(float(height), tuple(closed_curve(loop) for loop in level))
        for height, level in zip(heights, loops, strict=True)
    )


def closed_curve(vertices: Floats) -> Curve:
    """The closed polygon through (M, d) vertices."""
    steps = np.roll(vertices, -1, axis=0) - vertices
    return Curve(vertices, True, 0, float(np.sqrt((steps**2).sum(axis=1)).sum()), len(vertices), 0.0)


def _level(rng: np.random.Generator) -> list[Floats]:
    """Contours of one level, whatever comes."""
    kinds = (_blob, _nest, _rectangles, _tangle, _staircase)
    return [
        loop
        for _ in range(rng.integers(1, MOST_CONTOURS + 1))
        for loop in kinds[rng.integers(len(kinds))](rng)
    ]


def _next_level(last: list[Floats], rng: np.random.Generator) -> list[Floats]:
    """A level that shares some of its contours, or parts of them, with the one before it."""
    out = [_changed(loop, rng) for loop in last if rng.uniform() < 0.6]
    return out + _level(rng) if not out or rng.uniform() < 0.4 else out


def _changed(loop: Floats, rng: np.random.Generator) -> Floats:
    """A contour again: as it was, moved by a cell or anyhow, scaled, with some vertices moved or left out."""
    cell = SIZE / LATTICE
    centre = loop.mean(axis=0)
    match rng.integers(7):
        case 0:
            return loop
        case 1:
            return loop + cell * rng.integers(-1, 2, 2)
        case 2:
            return loop + rng.normal(0.0, cell, 2)
        case 3:
            return np.asarray(centre + rng.uniform(0.4, 1.6) * (loop - centre))
        case 4:
            return np.asarray(
                np.where(
                    rng.uniform(size=(len(loop), 1)) < 0.3, loop + rng.normal(0.0, 0.5, loop.shape), loop
                )
            )
        case 5:
            # Nearly the same, at the resolution of the grid and below.
            return loop + rng.normal(0.0, SIZE * 10.0 ** rng.uniform(-9.0, -4.0), loop.shape)
        case _:
            kept = rng.uniform(size=len(loop)) < 0.7
            return loop[kept] if kept.sum() >= 3 else loop[::-1]


def _blob(rng: np.random.Generator) -> list[Floats]:
    """A wavy closed curve."""
    count = int(rng.integers(5, 60))
    turn = 2.0 * np.pi * np.arange(count) / count
    radius = SIZE * rng.uniform(0.05, 0.4) * (1.0 + rng.uniform(0.0, 0.4) * np.sin(rng.integers(2, 6) * turn))
    return [rng.uniform(0.0, SIZE, 2) + radius[:, None] * np.column_stack((np.cos(turn), np.sin(turn)))]


def _nest(rng: np.random.Generator) -> list[Floats]:
    """A blob with a hole, an island in the hole, and so on."""
    (outer,) = _blob(rng)
    centre = outer.mean(axis=0)
    return [centre + 0.65**depth * (outer - centre) for depth in range(rng.integers(2, 5))]


def _rectangles(rng: np.random.Generator) -> list[Floats]:
    """Rectangles on a lattice: they share edges, parts of edges and corners."""
    out = []
    for _ in range(rng.integers(1, 4)):
        x, y = rng.integers(0, LATTICE, 2)
        width, height = rng.integers(1, LATTICE // 2 + 1, 2)
        corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
        out.append(corners * (SIZE / LATTICE))
    return out


def _tangle(rng: np.random.Generator) -> list[Floats]:
    """A closed polygon that crosses itself, on the lattice or off it."""
    vertices = rng.uniform(0.0, SIZE, (int(rng.integers(3, 9)), 2))
    return [np.rint(vertices * LATTICE / SIZE) * (SIZE / LATTICE) if rng.uniform() < 0.5 else vertices]


def _staircase(rng: np.random.Generator) -> list[Floats]:
    """Squares in a row that touch at their corners only, or share an edge."""
    cell = SIZE / LATTICE
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    step = np.array([(1.0, 1.0), (1.0, 0.0), (1.0, -1.0)][rng.integers(3)])
    first = rng.integers(0, LATTICE, 2)
    return [cell * (first + k * step + square) for k in range(rng.integers(2, 5))]
