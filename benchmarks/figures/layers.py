"""What a panel is made of: clouds, triangles, tapes, skeletons and curves, each drawn into given axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from benchmarks.plots import CLOUD, RESULT, TAPE, TRUTH, closed_line
from core.results import Ball, Curve, Graph, TapePolygon

__all__ = [
    "COLOURS",
    "draw_balls",
    "draw_border",
    "draw_cloud",
    "draw_curves",
    "draw_graph",
    "draw_skeleton",
    "draw_tape",
    "draw_triangles",
    "frame",
    "heading",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COLOURS = (RESULT, "#0b6e99", "#e08a00", "#4b8b3b", "#7b3f98", "#8c564b")  # of several curves in one panel
MARGIN = 0.03  # of the longer side around a point set


def heading(axis: Any, letter: str, words: str) -> None:
    """Title a panel as the paper does: (a) and a few words."""
    axis.set_title(f"({letter}) {words}" if letter else words, pad=3)


def frame(axis: Any, points: Floats, margin: float = MARGIN) -> None:
    """Show exactly the box of these points, to scale and without axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = margin * float(np.max(high - low))
    axis.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axis.set_aspect("equal")
    axis.set_axis_off()


def draw_cloud(axis: Any, points: Floats, size: float = 1.5, colour: str = CLOUD) -> None:
    """Draw samples as dots; ``size`` in square points."""
    axis.scatter(*points.T, s=size, color=colour, linewidths=0)


def draw_triangles(
    axis: Any, points: Floats, triangles: Ints, fill: str = "none", line: str = TRUTH, width: float = 0.22
) -> None:
    """Draw triangles, given as indices of points."""
    axis.add_collection(
        PolyCollection(
            list(points[triangles]), facecolor=fill, edgecolor=line, linewidth=width, joinstyle="round"
        )
    )


def draw_tape(axis: Any, tape: Sequence[TapePolygon], fill: str = TAPE, width: float = 0.6) -> None:
    """Draw the tape's polygons, their holes left white."""
    for part in tape:
        rings = [Path(closed_line(ring, True), closed=True) for ring in (part.outer, *part.holes)]
        whole = Path.make_compound_path(*rings)
        axis.add_patch(PathPatch(whole, facecolor=fill, edgecolor=TRUTH, linewidth=width))


def draw_border(axis: Any, rings: Sequence[Floats], size: float = 2.0, width: float = 0.4) -> None:
    """Draw the resampled border with its vertices."""
    for ring in rings:
        axis.plot(*closed_line(ring, True).T, color=TRUTH, linewidth=width)
        axis.scatter(*ring.T, s=size, color=TRUTH, linewidths=0, zorder=3)


def draw_skeleton(axis: Any, voronoi: Floats, width: float = 0.8) -> None:
    """Draw the Voronoi edges in the tape, hair included; ``voronoi`` is (E, 2, 2)."""
    axis.add_collection(LineCollection(list(voronoi), color=RESULT, linewidth=width, capstyle="round"))


def draw_graph(axis: Any, graph: Graph, width: float = 1.2, size: float = 14.0) -> None:
    """Draw the skeleton without hair; forks filled, ends hollow."""
    for edge in graph.edges:
        axis.plot(*edge.vertices.T, color=RESULT, linewidth=width, solid_capstyle="round")
    for node in graph.nodes:
        inside = RESULT if node.degree > 1 else "white"
        axis.scatter(*node.location, s=size, facecolor=inside, edgecolor=RESULT, linewidth=0.9, zorder=4)


def draw_balls(axis: Any, balls: Sequence[Ball]) -> None:
    """Draw balls with their fitted directions."""
    angle = np.linspace(0, 2 * np.pi, 65)
    circle = np.column_stack((np.cos(angle), np.sin(angle)))
    rims = [ball.centre[:2] + ball.radius * circle for ball in balls]
    fits = [ball.centre[:2] + np.outer((-0.5, 0.5), ball.radius * ball.direction[:2]) for ball in balls]
    axis.add_collection(LineCollection(rims, color=TRUTH, linewidth=0.4))
    axis.add_collection(LineCollection(fits, color=RESULT, linewidth=0.9))


def draw_curves(
    axis: Any,
    curves: Sequence[Curve],
    width: float = 1.4,
    colours: Sequence[str] = COLOURS,
    view: Floats | None = None,
) -> None:
    """Draw curves, each in its own colour; ``view`` (d, 2) projects those in space."""
    for k, curve in enumerate(curves):
        line = closed_line(curve.vertices, curve.closed)
        line = line if view is None else line @ view
        colour = colours[k % len(colours)]
        axis.plot(*line.T, color=colour, linewidth=width, solid_joinstyle="round", solid_capstyle="round")
