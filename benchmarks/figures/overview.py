"""One picture for the README: a double-8 that turns from samples into a curve, from left to right."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from matplotlib.patches import Rectangle

from benchmarks.figures.layers import draw_cloud, draw_curves, draw_graph, draw_tape, draw_triangles, frame
from benchmarks.figures.solved import skeleton_of
from benchmarks.plots import TAPE, new, save
from core.truth import point_set

__all__ = ["overview"]

CUTS = (-1.45, -0.3, 1.15)  # where one stage ends and the next begins
ZONES = ("samples", "triangles", "tape and skeleton", "curve")


def overview() -> None:
    """Draw four stages of one point set, each in its part of the picture."""
    points = point_set("double_8", n=2000, seed=2).points
    solved = skeleton_of(points)
    figure, axes = new(1, 1, (9, 2.75))
    axis = axes[0, 0]
    frame(axis, points, 0.01)
    zones = _zones(axis)
    with _clipped(axis, zones[0]):
        draw_cloud(axis, points, 3.0, "0.35")
    with _clipped(axis, zones[1]):
        draw_triangles(axis, points, solved.delaunay.triangles[solved.delaunay.accepted], TAPE, width=0.4)
    with _clipped(axis, zones[2]):
        draw_tape(axis, solved.tape)
        draw_graph(axis, solved.graph, 1.5, 18.0)
    with _clipped(axis, zones[3]):
        draw_cloud(axis, points, 2.0)
        draw_curves(axis, solved.curves, 2.2)
    save(figure, "overview.png")


def _zones(axis: Any) -> list[Rectangle]:
    """Make a box for each stage, and write its name above it."""
    (left, right), (bottom, top) = axis.get_xlim(), axis.get_ylim()
    limits = (left, *CUTS, right)
    boxes = []
    for low, high, words in zip(limits[:-1], limits[1:], ZONES, strict=True):
        boxes.append(Rectangle((low, bottom), high - low, top - bottom, transform=axis.transData))
        axis.annotate(words, ((low + high) / 2, top), (0, 2), textcoords="offset points", ha="center")
    axis.vlines(CUTS, bottom, top, color="0.75", linewidth=0.6, linestyle=(0, (4, 4)))
    return boxes


@contextmanager
def _clipped(axis: Any, box: Rectangle) -> Iterator[None]:
    """Clip to a box whatever is drawn meanwhile."""
    before = set(axis.get_children())
    yield
    for artist in set(axis.get_children()) - before:
        artist.set_clip_path(box)
