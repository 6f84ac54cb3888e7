"""Slices, contours and surfaces to be rendered: made by hand, so that every number in them is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.results import Curve
from core.surface.axis import axis_frame
from core.surface.results import ContourLevel, Contours, Mesh, Slice, Slices, Surface, SurfaceReport

Floats = NDArray[np.float64]

UP = (0.0, 0.0, 1.0)
CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
SIDES = np.array(
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
)  # counter-clockwise seen from outside


def cube(scale: float = 1.0, offset: float = 0.0) -> Mesh:
    """The unit cube; scaled, then moved."""
    return Mesh(CUBE * scale + offset, np.concatenate([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]]))


def ball(n: int = 24, radius: float = 1.0) -> Mesh:
    """A sphere of rings and a vertex at each pole."""
    down = np.pi * np.arange(1, n) / n
    around = np.pi * np.arange(2 * n) / n
    rings = np.stack(
        [
            np.outer(np.sin(down), np.cos(around)),
            np.outer(np.sin(down), np.sin(around)),
            np.outer(np.cos(down), np.ones(2 * n)),
        ],
        axis=2,
    )
    vertices = np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    k = np.arange(2 * n)
    after, last = (k + 1) % (2 * n), (n - 2) * 2 * n
    faces = [np.column_stack([np.full(2 * n, len(vertices) - 2), k, after])]
    for ring in range(n - 2):
        low, high = ring * 2 * n, (ring + 1) * 2 * n
        faces += [
            np.column_stack([low + k, high + k, high + after]),
            np.column_stack([low + k, high + after, low + after]),
        ]
    faces.append(np.column_stack([last + after, last + k, np.full(2 * n, len(vertices) - 1)]))
    return Mesh(radius * vertices, np.concatenate(faces))


def surface(mesh: Mesh, axis: tuple[float, float, float] = UP, closed: bool = True) -> Surface:
    report = SurfaceReport(closed, True, 1, 2, 0, 1.0, 6.0, 0)
    return Surface(mesh, report, axis=np.array(axis))


def square(side: float) -> Floats:
    return side * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def curve(vertices: Floats, closed: bool = True, component: int = 0) -> Curve:
    return Curve(vertices, closed, component, 4.0, 40, 0.01, np.full(len(vertices), 0.02))


def contours(
    count: int = 4, axis: tuple[float, float, float] = UP, scale: float = 1.0, offset: float = 0.0
) -> Contours:
    """Squares that shrink with the height, the second of two levels completed; the last one has nothing."""
    frame = axis_frame(axis)
    levels = [
        ContourLevel(
            0.5 * k * scale,
            (curve(frame.lift(scale * square(1.0 - 0.5 * k / count), 0.5 * k * scale) + offset),),
            completed=k == 1,
        )
        for k in range(count)
    ]
    return Contours(frame.axes[2], (*levels, ContourLevel(0.5 * count * scale, ())))


def slices(
    count: int = 4, axis: tuple[float, float, float] = UP, scale: float = 1.0, offset: float = 0.0
) -> Slices:
    """A closed square and an open line on each level but the last."""
    frame = axis_frame(axis)
    levels = []
    for k in range(count):
        ring = frame.lift(scale * square(1.0 - 0.5 * k / count), 0.5 * k * scale) + offset
        line = frame.lift(scale * np.array([[1.5, 0.0], [1.5, 0.7], [1.4, 1.0]]), 0.5 * k * scale) + offset
        levels.append(Slice(0.5 * k * scale, np.concatenate([ring, line]), (ring, line), (True, False)))
    return Slices(frame.axes[2], (*levels, Slice(0.5 * count * scale, np.empty((0, 3)))))
