"""Pictures of slices and contours: the stack as it stands, and some of its levels from above."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from core.surface.axis import axis_frame
from core.surface.results import ContourLevel, Contours, Slice, Slices
from service.render.levels import Outline, outlines
from service.render.pen import Pen
from service.render.pictures import scene
from service.render.plane import three_quarter
from service.render.scenes import ALARM, COLOURS, Area, Dots, Path, Scene, Segments, Sheet
from service.render.stages import visible

__all__ = ["MOST_LEVELS", "stack_of"]

Floats = NDArray[np.float64]

MOST_LEVELS = 160
"""Of more levels than this some are left out of a picture: lines would lie on lines."""

_SEGMENTS = 60_000  # of all slices together
_SINGLE, _COMPLETED = 7, 3  # levels that are seen from above, and how many of them may be completed ones
_FINE = 5e-4  # of the picture: what is smaller is not seen
_FOUND, _FILLED = ("#E4EFF7", COLOURS[0]), ("#FADFCB", COLOURS[1])  # plates and their edges


@scene.register(Contours)
@scene.register(Slices)
def _(result: Slices | Contours, points: Floats | None = None) -> Scene | Sheet:  # noqa: ARG001 # levels have their own
    """Show the stack from its front right and above, and some of its levels from above, all to one scale."""
    stack = stack_of(result)
    shown = _chosen(result.slices)
    if not shown:
        return stack
    pen = _plan(result)
    levels = {f"level-{number}": _level(number, result.slices[number], pen) for number in shown}
    low, high = _around(stack, levels.values())
    stack = _moved(stack, (low + high) / 2.0)
    return Sheet(stack.title, {"stack": stack} | levels, (low, high))


def stack_of(result: Slices | Contours) -> Scene:
    """Show the stack from its front right and above; closed contours hide what lies below them."""
    step = -(-len(result.slices) // MOST_LEVELS) or 1
    unit, drawn = _projected(result.axis, [one for one in outlines(result) if one.level % step == 0])
    title = f"{len(result.slices)} level{'' if len(result.slices) == 1 else 's'}"
    title += "" if step == 1 else f", one in {step} drawn"
    if isinstance(result, Slices):
        return Scene(title, segments=_strokes(drawn), unit=unit, bare=True)
    paths = tuple(Path(one.vertices, False, ALARM, 0, "open") for one in drawn if not one.closed)
    return Scene(title, areas=tuple(_plates(drawn)), paths=paths, unit=unit, bare=True)


def _projected(axis: Floats, drawn: Sequence[Outline]) -> tuple[float, list[Outline]]:
    """Return outlines as they are seen, about the middle of the picture, and its unit."""
    if not drawn:
        return 1.0, []
    points = np.concatenate([one.vertices for one in drawn])
    unit = Pen.of([points]).unit
    points = points / unit
    low, high = points.min(axis=0), points.max(axis=0)
    places = (points - (low + high) / 2.0) @ three_quarter(axis_frame(axis.tolist()).axes)[:2].T
    ends = np.cumsum([len(one.vertices) for one in drawn])[:-1]
    parts = _thinned(np.split(places, ends), [one.closed for one in drawn])
    return unit, [replace(one, vertices=part) for one, part in zip(drawn, parts, strict=True)]


def _thinned(parts: Sequence[Floats], closed: Sequence[bool]) -> list[Floats]:
    """Leave out vertices of polylines whose loss nobody sees."""
    import shapely  # noqa: PLC0415 # the web process shall not wait for it

    rings = [
        np.concatenate([part, part[:1]]) if ring or len(part) == 1 else part
        for part, ring in zip(parts, closed, strict=True)
    ]
    points = np.concatenate(rings)
    numbers = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    fine = _FINE * float(np.ptp(points, axis=0).max())
    made = shapely.simplify(shapely.linestrings(points, indices=numbers), fine, preserve_topology=False)
    points, numbers = shapely.get_coordinates(made, return_index=True)
    kept = np.split(points, np.searchsorted(numbers, np.arange(1, len(rings))))
    return [part[:-1] if ring else part for part, ring in zip(kept, closed, strict=True)]


def _strokes(drawn: Iterable[Outline]) -> tuple[Segments, ...]:
    """Draw slices as thin lines, whatever lies behind: many are open, and hide nothing."""
    ends = [_steps(one.vertices, one.closed) for one in drawn]
    return (Segments(visible(np.concatenate(ends), _SEGMENTS), COLOURS[0]),) if ends else ()


def _steps(vertices: Floats, closed: bool) -> Floats:
    """Return the edges (E, 2, d) of a polyline."""
    after = np.roll(vertices, -1, axis=0) if closed else vertices[1:]
    return np.stack([vertices[: len(after)], after], axis=1)


def _plates(drawn: Iterable[Outline]) -> Iterator[Area]:
    """Fill each level between its contours, the lowest level first: seen from above, it hides those below."""
    for _, group in groupby(drawn, key=lambda one: one.level):
        level = [one for one in group if one.closed]
        if level:
            fill, edge = _FILLED if level[0].completed else _FOUND
            name = "completed" if level[0].completed else "contours"
            yield Area(tuple(one.vertices for one in level), fill, edge, name)


# --- single levels ------------------------------------------------------------------------------------


def _chosen(levels: Sequence[Slice | ContourLevel]) -> list[int]:
    """Choose levels with something in them: some that were completed, and others evenly."""
    full = [k for k, one in enumerate(levels) if (one.polylines if isinstance(one, Slice) else one.curves)]
    completed = [k for k in full if _is_completed(levels[k])]
    chosen = [completed[k] for k in _evenly(len(completed), _COMPLETED)]
    return sorted({*chosen, *(full[k] for k in _evenly(len(full), _SINGLE - len(chosen)))})


def _evenly(count: int, most: int) -> list[int]:
    """Choose at most so many of a row, not its very ends where there are enough."""
    chosen = min(count, most)
    return [int((k + 0.5) * count / chosen) for k in range(chosen)]


def _is_completed(level: Slice | ContourLevel) -> bool:
    return isinstance(level, ContourLevel) and level.completed


def _plan(result: Slices | Contours) -> Pen:
    """Look along the axis: the paper has the coordinates of the planes."""
    across = axis_frame(result.axis.tolist()).axes[:2].T
    unit = Pen.of([one.vertices for one in outlines(result)]).unit
    return Pen(unit, lambda points: points @ across)


def _level(number: int, level: Slice | ContourLevel, pen: Pen) -> Scene:
    title = f"Level {number}, height {level.height:.6g}"
    if isinstance(level, Slice):
        return Scene(title, dots=(Dots(pen(level.points), COLOURS[0]),), unit=pen.unit)
    return Scene(
        title + (", completed" if level.completed else ""),
        bands=pen.bands(level.curves),
        paths=tuple(pen.curve(k, curve) for k, curve in enumerate(level.curves)),
        unit=pen.unit,
    )


def _around(stack: Scene, levels: Iterable[Scene]) -> tuple[Floats, Floats]:
    """Return a box for the levels as they lie, with as much room as the stack needs."""
    boxes = [one.bounds() for one in levels]
    low, high = np.min([one[0] for one in boxes], axis=0), np.max([one[1] for one in boxes], axis=0)
    room = np.maximum(high - low, np.subtract(*reversed(stack.bounds()))) / 2.0
    middle = low + (high - low) / 2.0
    return middle - room, middle + room


def _moved(stack: Scene, to: Floats) -> Scene:
    """Move the middle of the stack there."""
    low, high = stack.bounds()
    by = to - (low + high) / 2.0
    return replace(
        stack,
        areas=tuple(replace(one, rings=tuple(ring + by for ring in one.rings)) for one in stack.areas),
        segments=tuple(replace(one, ends=one.ends + by) for one in stack.segments),
        paths=tuple(replace(one, vertices=one.vertices + by) for one in stack.paths),
    )
