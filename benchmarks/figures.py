"""Pictures of built-in point sets and their reconstructions for the docs: ``make figures``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.plots import CLOUD, RESULT, TRUTH, closed_line, new, save
from core.methods import pca
from core.parameters import PcaParameters
from core.results import Reconstruction
from core.truth import PointSet, names, point_set

__all__ = ["draw_gallery", "draw_march", "main"]


def draw_march(name: str = "multi_scan", seed: int = 1) -> None:
    """Draw cloud, balls of the march, and curve of one point set side by side (Fig. 3)."""
    sample = point_set(name, seed=seed)
    result = pca(sample.points, PcaParameters(), stages=True)
    figure, axes = new(1, 3, (11, 4))
    for axis, title in zip(axes[0], ("point set", "balls of the march", "curve"), strict=True):
        axis.scatter(*sample.points.T, s=1.0, color=CLOUD, linewidths=0)
        axis.set_title(title)
        _plain(axis)
    _balls(axes[0, 1], result)
    _curves(axes[0, 2], result, 2)
    for axis in axes[0, ::2]:
        axis.set(xlim=axes[0, 1].get_xlim(), ylim=axes[0, 1].get_ylim())
    save(figure, f"{name}.png")


def draw_gallery(columns: int = 6) -> None:
    """Draw every built-in family: cloud grey, truth thin, reconstruction red."""
    every = names()
    figure, axes = new(math.ceil(len(every) / columns), columns, (12, 8.4))
    for axis in axes.flat[len(every) :]:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, every, strict=False):
        sample = point_set(name, seed=1)
        result = pca(sample.points)
        view = _view(sample)
        axis.scatter(*(sample.points[:1200] @ view).T, s=1.4, color=CLOUD, linewidths=0)
        _curves(axis, result, 1.2, view)
        for one in sample.curves:
            axis.plot(*(closed_line(one.vertices[::4], one.closed) @ view).T, color=TRUTH, linewidth=0.4)
        axis.set_title(name, fontsize=8)
        _plain(axis)
    save(figure, "gallery.png")


def _view(sample: PointSet) -> Any:
    """Projection on the paper: the plane itself, or an oblique look at space."""
    if sample.points.shape[1] == 2:
        return np.eye(2)
    turn, tilt = np.radians(35), np.radians(50)
    right = [np.cos(turn), np.sin(turn), 0.0]
    up = [-np.sin(turn) * np.sin(tilt), np.cos(turn) * np.sin(tilt), np.cos(tilt)]
    return np.column_stack((right, up))


def _balls(axis: Any, result: Reconstruction) -> None:
    if result.stages is None:
        return
    angle = np.linspace(0, 2 * np.pi, 33)
    for ball in result.stages.balls:
        rim = ball.centre[:2] + ball.radius * np.column_stack((np.cos(angle), np.sin(angle)))
        axis.plot(*rim.T, color=TRUTH, linewidth=0.4)
        ends = ball.centre[:2] + np.outer((-0.5, 0.5), ball.radius * ball.direction[:2])
        axis.plot(*ends.T, color=RESULT, linewidth=0.8)


def _curves(axis: Any, result: Reconstruction, width: float, view: Any = None) -> None:
    for curve in result.curves:
        line = closed_line(curve.vertices, curve.closed)
        axis.plot(*(line if view is None else line @ view).T, color=RESULT, linewidth=width)


def _plain(axis: Any) -> None:
    axis.set_aspect("equal")
    axis.set_axis_off()


def main() -> None:
    """Draw all."""
    draw_march()
    draw_gallery()


if __name__ == "__main__":
    main()
