"""All built-in families with their reconstructions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures.layers import draw_cloud, draw_curves, frame
from benchmarks.plots import new, save
from core.methods import pca, skeleton
from core.truth import PointSet, names, point_set

__all__ = ["gallery"]

Floats = NDArray[np.float64]


def gallery(columns: int = 6) -> None:
    """Draw every built-in family: those that cross by the skeleton, the others by the march."""
    every = names()
    rows = math.ceil(len(every) / columns)
    figure, axes = new(rows, columns, (9, 1.55 * rows))
    for axis in axes.flat[len(every) :]:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, every, strict=False):
        sample = point_set(name, seed=1)
        method = pca if sample.non_crossing else skeleton
        result, view = method(sample.points), _view(sample)
        draw_cloud(axis, sample.points @ view, 1.2)
        draw_curves(axis, result.curves, 1.2, view=view)
        axis.set_title(name, fontsize=8, pad=2)
        frame(axis, sample.points @ view)
    save(figure, "gallery.png")


def _view(sample: PointSet) -> Floats:
    """Projection on the paper: the plane itself, or an oblique look at space."""
    if sample.points.shape[1] == 2:
        return np.eye(2)
    turn, tilt = np.radians(35), np.radians(50)
    right = [np.cos(turn), np.sin(turn), 0.0]
    up = [-np.sin(turn) * np.sin(tilt), np.cos(turn) * np.sin(tilt), np.cos(tilt)]
    return np.column_stack((right, up))
