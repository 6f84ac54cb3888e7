"""Results to be rendered: made by hand, so that every number in them is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from core.results import (
    Ball,
    Component,
    ComponentSampling,
    Containment,
    Crossing,
    Curve,
    CurveGap,
    Delaunay,
    Diagnosis,
    Evidence,
    Frame,
    Graph,
    GraphEdge,
    GraphNode,
    Nyquist,
    Partition,
    Reconstruction,
    Sampling,
    SigmaAlong,
    SkeletonStages,
    Stages,
    TapePolygon,
    Violation,
    Warn,
)

Floats = NDArray[np.float64]
SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
LINE = np.array([[0.0, 0.1], [3.0, 0.1]])
OUTER = np.array([[-0.5, -0.5], [2.5, -0.5], [2.5, 1.5], [-0.5, 1.5]])
HOLE = np.array([[0.5, 0.4], [0.5, 0.6], [1.5, 0.6], [1.5, 0.4]])
VORONOI = np.array([[[0.0, 0.0], [2.0, 0.0]], [[2.0, 0.0], [2.0, 1.0]], [[2.0, 1.0], [2.4, 1.4]]])
TRIANGLES = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 5], [4, 5, 6]])
TILT = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.25]])


def lifted(points: Floats, dimension: int) -> Floats:
    """Lay plane points on a tilted plane of space."""
    return points if dimension == 2 else points @ TILT


def cloud(n: int = 50, dimension: int = 2) -> Floats:
    return lifted(np.random.default_rng(1).uniform(0, 3, (n, 2)), dimension)


def frame(component: int) -> Frame:
    return Frame(component, np.zeros(3), np.eye(3), 1.0)


def partition(points: Floats, count: int = 2) -> Partition:
    labels = np.arange(len(points)) % (count + 1) - 1
    components = tuple(
        Component(label, int((labels == label).sum()), points[:2], frame(label)) for label in range(count)
    )
    return Partition(0.5, "given", labels, components, (Warn("thin", "too few points"),))


def sampling(place: Floats) -> Sampling:
    """All that samples can say of themselves, with a violation."""
    violation = Violation(place, 1.5, "narrow", "branches-too-near", "scan denser here")
    return Sampling(
        sigma=0.01,
        density=20.0,
        epsilon=0.3,
        nyquist=Nyquist(False, 1.5, (violation,), place),
        sigma_error=0.001,
        sigma_along=(SigmaAlong(0, np.array([place, 0.5 * place]), np.array([0.01, 0.02])),),
        largest_gap=CurveGap(place, 0, 0.4, 8.0, 9.5),
        components=(ComponentSampling(0, 30, 0.01, 0.001, 20.0), ComponentSampling(1, 20, 0.02, None, 10.0)),
    )


def evidence(component: int = 0) -> tuple[Evidence, Evidence]:
    """For the march, and against the skeleton."""
    return (
        Evidence(component, "pca", "fits better", 2, 1, 1, 0.01, 0.99, 6.5, 0.0),
        Evidence(component, "skeleton", "fits worse", 1, 1, 0, 0.02, 0.9, 12.0, 31.5),
    )


def chosen(result: Reconstruction) -> Reconstruction:
    """The same, had there been a choice of methods."""
    better, worse = evidence()
    return replace(result, decisions=(better,), alternatives=(worse,))


def without_curves(result: Reconstruction) -> Reconstruction:
    """Nothing to be seen but what else there is."""
    nyquist = Nyquist(True, None)
    return replace(result, curves=(), crossings=(), sampling=replace(result.sampling, nyquist=nyquist))


def diagnosis(dimension: int = 2, scale: float = 1.0) -> Diagnosis:
    better, worse = evidence()
    return Diagnosis(
        method="pca",
        reason="fits better",
        verdict="The samples are not good enough.",
        curves=2,
        closed=1,
        crossings=1,
        outliers=np.array([3, 7]),
        sampling=sampling(lifted(SQUARE, dimension)[1] * scale),
        frames=(frame(0), frame(1)),
        decisions=(better,),
        alternatives=(worse,),
        warnings=(Warn("few", "few points"),),
    )


def reconstruction(
    dimension: int = 2, stages: bool = False, curves: int = 2, scale: float = 1.0, offset: float = 0.0
) -> Reconstruction:
    place = lifted(SQUARE, dimension)[1] * scale + offset
    shapes = [(SQUARE, True) if number % 2 == 0 else (LINE, False) for number in range(curves)]
    balls = (Ball(place, 0.25 * scale, place, 12, 0), Ball(place * 0.5, 0.5 * scale, place, 9, 0))
    return Reconstruction(
        method="pca",
        reason="asked for",
        curves=tuple(
            Curve(
                lifted(vertices, dimension) * scale + offset,
                closed,
                number,
                6.0,
                25,
                0.01,
                np.linspace(0.01, 0.05, len(vertices)) * scale if closed else None,
            )
            for number, (vertices, closed) in enumerate(shapes)
        ),
        crossings=(Crossing(place, (0, 1), 90.0),),
        outliers=np.array([3, 7]),
        sampling=sampling(place),
        frames=(frame(0),),
        warnings=(Warn("near", "two branches are near", tuple(place.tolist())), Warn("few", "few points")),
        stages=Stages(balls, (lifted(LINE, dimension),)) if stages else None,
    )


def skeleton(
    dimension: int = 2, stages: bool = False, scale: float = 1.0, offset: float = 0.0
) -> Reconstruction:
    """A tape with a hole about the square, and an island; four triangles kept for four reasons."""

    def placed(points: Floats) -> Floats:
        return lifted(points, dimension) * scale + offset

    island = OUTER / 4 + 3.0
    nodes = placed(SQUARE[[0, 2]])
    edges = [SQUARE[[0, 1, 2]], SQUARE[[2, 3, 0]]]
    return replace(
        reconstruction(dimension, False, 1, scale, offset),
        method="skeleton",
        tape=(TapePolygon(placed(OUTER), (placed(HOLE),), 0), TapePolygon(placed(island), (), 1)),
        containment=Containment(True, 2, 0.975),
        graph=Graph(
            tuple(GraphNode(node, 0.5 * scale, 2, 0) for node in nodes),
            tuple(
                GraphEdge((k, 1 - k), placed(line), np.full(3, 1.0 * scale), 3.0 * scale)
                for k, line in enumerate(edges)
            ),
        ),
        stages=_stages(placed, scale) if stages else None,
    )


def _stages(placed: Callable[[Floats], Floats], scale: float) -> SkeletonStages:
    rows = np.eye(5, dtype=bool)
    delaunay = Delaunay(
        TRIANGLES, rows[0], rows[1], rows[2], rows[:4].any(axis=0), np.array([[7, 8], [8, 9]])
    )
    ball = Ball(placed(SQUARE[:1])[0], 0.25 * scale, placed(SQUARE[1:2])[0], 12, 0)
    voronoi = placed(VORONOI.reshape(-1, 2)).reshape(3, 2, -1)
    return SkeletonStages((ball,), delaunay, (placed(OUTER), placed(HOLE)), voronoi)
