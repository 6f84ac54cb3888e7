"""Hair that the skeleton keeps, and ends that it loses, on rough tapes whose axis is known."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.comparison import planar_families
from benchmarks.goals import Goal
from benchmarks.tapes import end_gap, hair, noisy_tape, shortened
from core.tape.skeleton import skeleton_of
from core.tape.solve import PRUNE
from core.truth import family, point_set

__all__ = ["Tape", "measure", "report"]

VERTICES = 10_000  # of the border
HALF_WIDTH = 0.03  # of the diagonal: no built-in curve bends tighter or comes as near to itself
NOISES = (0.02, 0.05)  # of the half-width
FAR = 0.1  # half-widths from the axis: farther places are hair
HAIR, END = 0.005, 1.0  # the goals: share of the length, half-widths

_ABOUT = (
    "The places within 3 % of the diagonal of a known curve, whose border has 10⁴ vertices, each moved "
    "along the normal by noise. The axis of such a tape is the curve itself. Hair is the share of the "
    "skeleton's length that is farther than 0.1 half-widths from the axis; an end is shortened by the "
    "distance from the true end to the skeleton. Missed is the length of the axis farther than 0.1 "
    "half-widths from the skeleton. The skeleton resamples the border before anything else."
)


@dataclass(frozen=True, slots=True)
class Tape:
    """What the skeleton of one tape is like; lengths in half-widths, seconds of one core."""

    noise: float
    edges: int
    hair: float
    end_gap: float
    missed: float
    seconds: float


def report(seeds: int) -> tuple[list[str], list[Goal]]:
    """Measure tapes along all planar curves; return the lines and the figures to reach."""
    skeleton_of(noisy_tape(point_set("arc", n=1).curves[0].exact, 0.1, 0.0, 0.1, 0), PRUNE)  # compile
    tapes = [measure(name, noise, seed) for noise in NOISES for name in _families() for seed in range(seeds)]
    goals = [
        Goal("hair, largest share of any tape", max(tape.hair for tape in tapes), HAIR, True, ".2%"),
        Goal(
            "ends shortened, in half-widths, the most", max(tape.end_gap for tape in tapes), END, True, ".2f"
        ),
    ]
    return ["### Hair and ends", "", _ABOUT, "", *_table(tapes), ""], goals


def _families() -> Iterable[str]:
    """Return the families of a single curve in the plane; tapes along several would be several tapes."""
    for name in (*planar_families(), *planar_families(held_out=True)):
        curves = family(name).build(0)
        if len(curves) == 1 and curves[0].evaluate([0.0]).shape[1] == 2:
            yield name


def measure(name: str, noise: float, seed: int) -> Tape:
    """Make a tape along a curve, with a border as rough as ``noise`` half-widths, and its skeleton."""
    truth = point_set(name, n=1, seed=seed).curves[0]
    half_width = HALF_WIDTH * float(np.linalg.norm(np.ptp(truth.vertices, axis=0)))
    border = 2.0 * truth.length + (0.0 if truth.closed else 2.0 * np.pi * half_width)
    tape = noisy_tape(truth.exact, half_width, noise * half_width, border / VERTICES, seed)
    start = time.process_time()
    skeleton = skeleton_of(tape, PRUNE)
    seconds = time.process_time() - start
    lines = [edge.places for edge in skeleton.graph.edges]
    return Tape(
        noise,
        len(lines),
        hair(lines, truth.exact, FAR * half_width),
        end_gap(lines, truth.exact) / half_width,
        shortened(lines, truth.exact, FAR * half_width) / half_width,
        seconds,
    )


def _table(tapes: Sequence[Tape]) -> list[str]:
    lines = [
        "| noise / half-width | tapes | without a fork | hair, mean | most "
        "| ends shortened, in half-widths, most | axis missed, in half-widths, most | time, median |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for noise in NOISES:
        group = [tape for tape in tapes if tape.noise == noise]
        shares = [tape.hair for tape in group]
        lines.append(
            f"| {noise:.0%} | {len(group)} | {np.mean([tape.edges == 1 for tape in group]):.1%} "
            f"| {np.mean(shares):.3%} | {max(shares):.2%} | {max(tape.end_gap for tape in group):.2f} "
            f"| {max(tape.missed for tape in group):.2f} "
            f"| {1e3 * np.median([tape.seconds for tape in group]):.0f} ms |"
        )
    return lines
