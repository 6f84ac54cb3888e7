"""What there is to see of each type of result."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from core.results import Partition, Reconstruction, SkeletonStages
from service.render.pen import Pen
from service.render.scenes import COLOURS, GREY, Dots, Scene, Sheet
from service.render.stages import skeleton_stages

__all__ = ["scene"]

Floats = NDArray[np.float64]


@singledispatch
def scene(result: object, points: Floats | None = None) -> Scene | Sheet:  # noqa: ARG001 # registered functions use it
    """Return what there is to see of a result; register a function for each new type of result."""
    raise TypeError(f"no picture is defined for {type(result).__name__}")


@scene.register
def _(result: Partition, points: Floats | None = None) -> Scene:
    """Show the points in the colours of their components, outliers in grey."""
    if points is None:
        raise TypeError("the picture of a partition needs the points")
    pen = Pen.of([points])
    paper = pen(points)
    groups = [Dots(paper[result.labels < 0], GREY, "outliers")]
    for turn, colour in enumerate(COLOURS):
        mine = (result.labels >= 0) & (result.labels % len(COLOURS) == turn)
        name = f"component {turn}" if result.count <= len(COLOURS) else ""
        groups.append(Dots(paper[mine], colour, name))
    shown = tuple(group for group in groups if len(group.points))
    return Scene(_count(result.count, "component") + _seen(points), dots=shown, unit=pen.unit)


@scene.register
def _(result: Reconstruction, points: Floats | None = None) -> Scene | Sheet:
    """Show the cloud in grey, the tape, the curves in colours, and the stages if asked for (Figs. 3, 5)."""
    sets = [curve.vertices for curve in result.curves] + [polygon.outer for polygon in result.tape or ()]
    sets += [] if points is None else [points]
    pen = Pen.of(sets)
    stages = result.stages
    title = f"{_count(len(result.curves), 'curve')} ({result.method}){_seen(*sets)}"
    picture = Scene(
        title,
        areas=pen.tape(result.tape or ()),
        dots=() if points is None else (Dots(pen(points), GREY, "samples"),),
        circles=() if stages is None else tuple(pen.circle(ball) for ball in stages.balls),
        paths=tuple(pen.curve(number, curve) for number, curve in enumerate(result.curves)),
        marks=pen.crossings(result.crossings),
        unit=pen.unit,
    )
    if isinstance(stages, SkeletonStages) and points is not None:
        return Sheet(title, skeleton_stages(result, stages, points, pen, picture))
    return picture


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _seen(*sets: Floats) -> str:
    return ", projected on the best plane" if sets and sets[0].shape[1] == 3 else ""
