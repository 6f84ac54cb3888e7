"""What there is to see of each type of result."""

from __future__ import annotations

from collections.abc import Iterator
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from core.results import CurveGap, Diagnosis, Partition, Reconstruction, SkeletonStages
from service.render.pen import Pen
from service.render.scenes import COLOURS, GREY, Circle, Dots, Scene, Sheet
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
        areas=pen.tape(result.tape or (), "tape"),
        dots=() if points is None else (Dots(pen(points), GREY, "samples"),),
        circles=() if stages is None else tuple(pen.circle(ball) for ball in stages.balls),
        bands=pen.bands(result.curves),
        paths=tuple(pen.curve(number, curve) for number, curve in enumerate(result.curves)),
        marks=(*pen.crossings(result.crossings), *pen.violations(result.sampling.nyquist.violations)),
        unit=pen.unit,
    )
    if isinstance(stages, SkeletonStages) and points is not None:
        return Sheet(title, skeleton_stages(result, stages, points, pen, picture))
    return picture


@scene.register
def _(result: Diagnosis, points: Floats | None = None) -> Scene:
    """Show the cloud, its outliers, how far the noise reaches, the longest gap, and what is wrong where."""
    if points is None:
        raise TypeError("the picture of a diagnosis needs the points")
    pen = Pen.of([points])
    paper, kept = pen(points), np.ones(len(points), bool)
    kept[result.outliers] = False
    groups = (Dots(paper[kept], GREY, "samples"), Dots(paper[~kept], COLOURS[1], "outliers"))
    return Scene(
        f"{'Good' if result.sampling.nyquist.compliant else 'Not good'} enough{_seen(points)}",
        dots=tuple(group for group in groups if len(group.points)),
        circles=(*_noise(result, points, pen), *_longest_gap(result.sampling.largest_gap, pen)),
        marks=pen.violations(result.sampling.nyquist.violations),
        unit=pen.unit,
    )


def _noise(result: Diagnosis, points: Floats, pen: Pen) -> Iterator[Circle]:
    """Draw two sigma: along a curve where it varies, otherwise once a component, at a sample in the midst."""
    name = "2 sigma"
    for along in result.sampling.sigma_along:
        for (x, y), sigma in zip(pen(along.locations).tolist(), along.sigma.tolist(), strict=True):
            yield Circle(x, y, 2.0 * sigma / pen.unit, COLOURS[0], name)
    if result.sampling.sigma_along:
        return
    sigmas = {one.label: one.sigma for one in result.sampling.components}
    for frame in result.frames:
        middle = pen(frame.origin[None, : points.shape[1]])
        near = pen(points)
        x, y = near[np.argmin(np.linalg.norm(near - middle, axis=1))].tolist()
        radius = 2.0 * sigmas.get(frame.component, result.sampling.sigma) / pen.unit
        yield Circle(x, y, radius, COLOURS[0], name)


def _longest_gap(gap: CurveGap | None, pen: Pen) -> Iterator[Circle]:
    """Draw a circle about the longest stretch of a curve without a sample."""
    if gap is not None:
        ((x, y),) = pen(gap.location[None]).tolist()
        yield Circle(x, y, 0.5 * gap.length / pen.unit, COLOURS[4], "longest gap")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _seen(*sets: Floats) -> str:
    return ", projected on the best plane" if sets and sets[0].shape[1] == 3 else ""
