"""Reconstructions of which the intermediate results are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.methods import pca, skeleton
from core.results import Ball, Curve, Delaunay, Graph, SkeletonStages, Stages, TapePolygon

__all__ = ["March", "Skeleton", "march", "skeleton_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class March:
    """Balls and curves of the PCA march."""

    balls: tuple[Ball, ...]
    curves: tuple[Curve, ...]

    @property
    def extent(self) -> Floats:
        """(2, 2): lower and upper corner of all balls."""
        centres = np.array([ball.centre[:2] for ball in self.balls])
        radii = np.array([[ball.radius] for ball in self.balls])
        return np.array([(centres - radii).min(axis=0), (centres + radii).max(axis=0)])


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """Everything that the skeleton method makes on its way."""

    delaunay: Delaunay
    tape: tuple[TapePolygon, ...]
    border: tuple[Floats, ...]
    voronoi: Floats
    graph: Graph
    curves: tuple[Curve, ...]


def march(points: Floats) -> March:
    """March, and keep the balls."""
    result = pca(points, stages=True)
    if not isinstance(result.stages, Stages):
        raise TypeError("the march has returned no stages")
    return March(result.stages.balls, result.curves)


def skeleton_of(points: Floats) -> Skeleton:
    """Reconstruct by the skeleton, and keep all stages."""
    result = skeleton(points, stages=True)
    stages, tape, graph = result.stages, result.tape, result.graph
    if not isinstance(stages, SkeletonStages) or tape is None or graph is None:
        raise TypeError("the skeleton has returned no stages")
    return Skeleton(stages.delaunay, tape, stages.border, stages.voronoi, graph, result.curves)
