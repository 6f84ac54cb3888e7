"""Levels with gaps, or missing, completed from their neighbours, beside their true contours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.surface.rows import CompletionRow
from core.surface.methods import contours, slices
from core.surface.parameters import SliceParameters
from core.surface.results import ContourLevel, Scans, Slice
from core.surface.slicing import slices_of
from core.truth import Scanner, Solid, reference_mesh, scan

__all__ = ["KINDS", "Damage", "completed_levels", "damaged", "error_of"]

Floats = NDArray[np.float64]

MARGIN = 0.1  # of the levels at both ends stay as they are: neighbours of caps tell little
STRIDE = 8  # levels from one damage to the next
SHARES = (0.1, 0.3)  # of a contour's length, for gaps
FINE = 0.01  # distance between samples of a contour, in units of the truth
RESOLUTION = 200  # of the mesh whose slices are the true contours


@dataclass(frozen=True, slots=True)
class Damage:
    """What is done to ``levels`` adjacent levels: a gap at one place, or nothing is left of them."""

    kind: str
    levels: int
    missing: bool


KINDS = tuple(
    Damage(f"{what}, {number}", levels, missing)
    for missing, what in ((False, "gap of 10 to 30 %"), (True, "missing"))
    for levels, number in ((1, "one level"), (2, "two adjacent"), (3, "three adjacent"))
)


def completed_levels(
    one: Solid, scanner: Scanner, levels: int, rounds: int, resolution: int = RESOLUTION
) -> Iterator[CompletionRow]:
    """Damage levels of a scanned solid and measure those, each round others."""
    stack = slices(Scans(range_images=scan(one, scanner)), SliceParameters(levels=levels)).slices
    heights = tuple(level.height for level in stack)
    truth = [
        level.polylines
        for level in slices_of([reference_mesh(one, resolution)], SliceParameters(heights=heights))
    ]
    for number in range(rounds):
        rng = np.random.default_rng(number)
        plan = _plan(levels, number)
        worse = damaged(stack, plan, truth, rng)
        found = contours(Scans(slices=worse)).slices
        errors = [error_of(level, true) for level, true in zip(found, truth, strict=True)]
        for first, damage in plan.items():
            around = [errors[first - 1], errors[first + damage.levels]]
            for k in range(first, first + damage.levels):
                yield CompletionRow(
                    one.name,
                    levels,
                    damage.kind,
                    heights[k],
                    errors[k],
                    float(np.sqrt(np.mean(np.square(around)))),
                    found[k].completed,
                    len(found[k].curves) == len(truth[k]),
                )


def _plan(levels: int, number: int) -> dict[int, Damage]:
    """Return what is done at which levels: kinds in turn, each round at other levels."""
    start = max(3, round(MARGIN * levels)) + number * STRIDE // 2
    return {
        first: KINDS[(k + 3 * number) % len(KINDS)]
        for k, first in enumerate(range(start, levels - max(6, round(MARGIN * levels)), STRIDE))
    }


def damaged(
    stack: Sequence[Slice],
    plan: dict[int, Damage],
    truth: Sequence[Sequence[Floats]],
    rng: np.random.Generator,
) -> tuple[Slice, ...]:
    """Return the slices with gaps cut into them, or emptied."""
    out = list(stack)
    for first, damage in plan.items():
        place, radius = _gap(stack[first], truth[first], rng)
        for k in range(first, first + damage.levels):
            points = stack[k].points
            kept = np.linalg.norm(points[:, :2] - place, axis=1) > radius
            left = points[:0] if damage.missing else points[kept]
            out[k] = replace(stack[k], points=left, polylines=(), closed=())
    return tuple(out)


def _gap(level: Slice, truth: Sequence[Floats], rng: np.random.Generator) -> tuple[Floats, float]:
    """Return middle and radius of a disc without samples: about one of them, by its contour's length."""
    place = level.points[rng.integers(len(level.points)), :2]
    nearest = min(truth, key=lambda one: float(np.linalg.norm(one[:, :2] - place, axis=1).min()))
    return place, float(rng.uniform(*SHARES) * _length(nearest) / 2.0)


def _length(loop: Floats) -> float:
    return float(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum())


def error_of(level: ContourLevel, truth: Sequence[Floats]) -> float:
    """Return the RMS distance in the plane, both ways, of contours and true ones; infinite without any."""
    own = _dense([curve.vertices for curve in level.curves if curve.closed])
    true = _dense(truth)
    if not len(own) or not len(true):
        return float("inf")
    there, back = cKDTree(true).query(own)[0], cKDTree(own).query(true)[0]
    return float(np.sqrt((np.mean(there**2) + np.mean(back**2)) / 2.0))


def _dense(loops: Sequence[Floats]) -> Floats:
    """Return points close to each other along closed polygons, (N, 2)."""
    out = [np.zeros((0, 2))]
    for loop in loops:
        line = np.vstack((loop, loop[:1]))[:, :2]
        arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
        at = np.linspace(0.0, arc[-1], max(2, int(arc[-1] / FINE)), endpoint=False)
        out.append(np.column_stack([np.interp(at, arc, line[:, k]) for k in range(2)]))
    return np.concatenate(out)
