"""Figures 3 and 6: the PCA march on one outline, and on a non-uniform and a self-intersecting set."""

from __future__ import annotations

from benchmarks.figures.layers import draw_balls, draw_cloud, draw_curves, frame, heading
from benchmarks.figures.solved import march
from benchmarks.plots import new, save
from core.truth import point_set

__all__ = ["figure_3", "figure_6"]


def figure_3() -> None:
    """Draw the cloud of several registered scans, the balls of the march, and the curve."""
    points = point_set("multi_scan", seed=1).points
    marched = march(points)
    figure, axes = new(1, 3, (9, 2.9))
    for axis, letter, words in zip(axes[0], "abc", ("point set", "balls of the march", "curve"), strict=True):
        draw_cloud(axis, points)
        heading(axis, letter, words)
        frame(axis, marched.extent, 0.01)
    draw_balls(axes[0, 1], marched.balls)
    draw_curves(axes[0, 2], marched.curves, 1.5)
    save(figure, "fig_03_march.png")


def figure_6() -> None:
    """Draw what the march makes of uneven density, and of a crossing: balls and curve."""
    sets = (("non_uniform", "non-uniform"), ("figure_8", "self-intersecting"))
    figure, axes = new(1, 4, (9, 2.0), width_ratios=[0.98, 0.98, 1.7, 1.7])  # so that heights agree
    for (name, words), letter, (left, right) in zip(sets, "ab", axes.reshape(2, 2), strict=True):
        points = point_set(name, seed=1).points
        marched = march(points)
        for axis in (left, right):
            draw_cloud(axis, points)
            frame(axis, marched.extent, 0.01)
        draw_balls(left, marched.balls)
        draw_curves(right, marched.curves, 1.5)
        heading(left, letter, f"{words}: balls")
        heading(right, "", "curve")
    save(figure, "fig_06_pca.png")
