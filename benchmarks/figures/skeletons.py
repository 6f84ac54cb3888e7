"""Figures 5, 10 and 11: the tape, its skeleton, and the readings of its crossings."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from benchmarks.figures.layers import (
    draw_border,
    draw_cloud,
    draw_curves,
    draw_graph,
    draw_skeleton,
    draw_tape,
    draw_triangles,
    frame,
    heading,
)
from benchmarks.figures.solved import skeleton_of
from benchmarks.plots import TAPE, new, save
from core.methods import pca, skeleton
from core.parameters import SkeletonParameters
from core.results import Delaunay, Reconstruction
from core.truth import PointSet, point_set

__all__ = ["figure_5", "figure_10", "figure_11"]

Floats = NDArray[np.float64]

ENCLOSED, AREA, LENGTH, BOTH = "#4f86bf", "#e8890c", "#2f9e63", "#8d7fc0"
EDGE = "white"  # between filled triangles
DARK = "0.4"  # of samples that are alone in their panel
NEAR = 0.5  # half the side of a close-up of the double-8


def figure_5() -> None:
    """Draw the skeleton method on an open S: from the cloud to the skeleton in six panels."""
    points = point_set("s_shape", n=700, seed=1).points
    solved = skeleton_of(points)
    figure, axes = new(1, 6, (9, 3.0))
    words = ("point set", "Delaunay", "small triangles", "tape polygon", "resampled border", "skeleton")
    for axis, letter, title in zip(axes[0], "abcdef", words, strict=True):
        heading(axis, letter, title)
        frame(axis, points)
    cloud, delaunay, small, tape, border, axis = axes[0]
    draw_cloud(cloud, points, 2.0, DARK)
    draw_triangles(delaunay, points, solved.delaunay.triangles)
    draw_triangles(small, points, solved.delaunay.triangles[solved.delaunay.accepted], TAPE)
    draw_tape(tape, solved.tape)
    draw_border(border, solved.border)
    draw_tape(axis, solved.tape, width=0.4)
    draw_skeleton(axis, solved.voronoi)
    save(figure, "fig_05_tape.png")


def figure_10() -> None:
    """Draw the skeleton method on a double-8, with the reasons for which triangles were kept."""
    points = point_set("double_8", n=1500, seed=1).points
    solved = skeleton_of(points)
    words = (
        "point set",
        "Delaunay triangulation",
        "triangles that local balls enclose",
        "triangles small by area or length",
        "tape polygon, border resampled",
        "skeleton of the tape",
        "graph: skeleton without hair",
        "curve",
    )
    figure, axes = new(4, 2, (9, 6.6))
    for axis, letter, title in zip(axes.flat, "abcdefgh", words, strict=True):
        heading(axis, letter, title)
        frame(axis, points)
    cloud, delaunay, balls, small, border, axis, graph, curve = axes.flat
    draw_cloud(cloud, points, 1.5, DARK)
    draw_triangles(delaunay, points, solved.delaunay.triangles)
    draw_triangles(balls, points, solved.delaunay.triangles[solved.delaunay.enclosed], ENCLOSED, EDGE)
    _small(small, points, solved.delaunay)
    draw_tape(border, solved.tape, width=0.0)
    draw_border(border, solved.border)
    draw_tape(axis, solved.tape, width=0.4)
    draw_skeleton(axis, solved.voronoi)
    draw_tape(graph, solved.tape, width=0.4)
    draw_graph(graph, solved.graph)
    draw_cloud(curve, points)
    draw_curves(curve, solved.curves, 1.8)
    save(figure, "fig_10_double_8.png")


def _small(axis: Any, points: Floats, kinds: Delaunay) -> None:
    """Draw the triangles that are small by their area, by their edges, and by both."""
    area, length = kinds.small_area, kinds.short_edges
    groups = (
        (area & length, BOTH, "both"),
        (area & ~length, AREA, "area"),
        (length & ~area, LENGTH, "length"),
    )
    for chosen, colour, _ in groups:
        draw_triangles(axis, points, kinds.triangles[chosen], colour, EDGE)
    handles = [Patch(color=colour, label=label) for _, colour, label in groups]
    axis.legend(
        handles=handles, loc="lower center", bbox_to_anchor=(0.5, -0.2), ncols=3, frameon=False, fontsize=8
    )


def figure_11() -> None:
    """Draw the readings of one double-8, each with its left crossing from near."""
    sample = point_set("double_8", seed=1)
    readings = {
        "PCA march alone": pca(sample.points),
        '"split": tangent closed curves': _read(sample, "split"),
        '"waist": one curve with wasp waists': _read(sample, "waist"),
        '"through": straight on': _read(sample, "through"),
    }
    left = sample.crossings[np.argmin(sample.crossings[:, 0])]
    figure, axes = new(2, 4, (9, 2.9), width_ratios=[3.1, 1] * 2)
    for pair, letter, (words, result) in zip(axes.reshape(4, 2), "abcd", readings.items(), strict=True):
        for axis, size, width in zip(pair, (0.8, 3.0), (1.3, 1.8), strict=True):
            draw_cloud(axis, sample.points, size)
            draw_curves(axis, sorted(result.curves, key=lambda one: one.vertices[:, 0].min()), width)
        heading(pair[0], letter, words)
        frame(pair[0], sample.points)
        frame(pair[1], left + np.array([(-NEAR, -NEAR), (NEAR, NEAR)]), 0.0)
        _mark(pair[0], pair[1])
    save(figure, "fig_11_crossings.png")


def _read(sample: PointSet, crossings: Literal["split", "waist", "through"]) -> Reconstruction:
    return skeleton(sample.points, SkeletonParameters(crossings=crossings))


def _mark(whole: Any, close: Any) -> None:
    """Frame the close-up, and the part of the whole that it shows."""
    (left, right), (bottom, top) = close.get_xlim(), close.get_ylim()
    for axis in (whole, close):
        box = Rectangle((left, bottom), right - left, top - bottom, facecolor="none", edgecolor="0.5")
        box.set(linewidth=0.7, clip_on=False)
        axis.add_patch(box)
