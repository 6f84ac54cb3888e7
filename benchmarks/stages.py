"""Time of the skeleton by stages, against one Delaunay triangulation of all samples by scipy."""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from scipy.spatial import Delaunay

import core.componentwise
import core.prepared
import core.tape.solve
import core.tape.tape
from benchmarks.goals import Goal
from benchmarks.plots import CLOUD, RESULT, TRUTH, new
from benchmarks.timing import LARGE, exponent, peak
from core.cloud.sampling import MANY
from core.methods import skeleton
from core.truth import point_set

__all__ = ["Stages", "draw", "main", "peak_memory", "report", "stages"]

SIZES = (10_000, 100_000, 300_000, 1_000_000)
FAMILIES = ("s_shape", "double_8")
LARGEST_RATIO, LARGEST_EXPONENT, LARGEST_MEMORY = 0.6, 1.15, 2000.0  # the goals, memory in MB

_ABOUT = (
    "The whole of `skeleton` on an open S and on a double-8, which crosses itself, σ = 1 %, beside one "
    "`scipy.spatial.Delaunay` of the same points in the same run: seconds of one core, the best of "
    "{repeats}; in brackets the ratio to scipy's Delaunay. Partition: with the estimate of noise and scale. "
    "Tape: small triangles and polygon. Curves: reading the graph, choosing between hypotheses, and the "
    "refinement against all samples. Where a first tape is in doubt others are built, and their time counts."
)
_ABOUT_CAP = (
    "Both methods let at most {many:,} samples of a component determine the topology, spread evenly over all "
    "of them; the partition and the final refinement see every sample. So beyond that number Delaunay, tape "
    "and skeleton no longer grow, and the exponent is that of the rest."
)

# Where each stage is called from: there the stopwatch takes its place.
_CALLS: tuple[tuple[ModuleType, str, str], ...] = (
    (core.componentwise, "partition", "partition"),
    (core.prepared, "estimate_scale", "partition"),
    (core.tape.tape, "triangulate", "delaunay"),
    (core.tape.solve, "approximate_tape", "tape"),
    (core.tape.solve, "skeleton_of", "skeleton"),
)


@dataclass(frozen=True, slots=True)
class Stages:
    """Seconds of one core for one point set; ``curves`` is what the other stages leave of the whole."""

    family: str
    n: int
    scipy: float
    partition: float
    delaunay: float
    tape: float
    skeleton: float
    whole: float

    @property
    def curves(self) -> float:
        """Curves from the graph, and their refinement."""
        return self.whole - self.partition - self.delaunay - self.tape - self.skeleton

    @property
    def ratio(self) -> float:
        """The whole in units of one scipy Delaunay of the same points."""
        return self.whole / self.scipy


def report(sizes: Sequence[int], repeats: int) -> tuple[list[str], list[Goal], list[Stages]]:
    """Measure; return the lines, the figures to reach, and what was measured."""
    rows = [one for name in FAMILIES for one in stages(name, sizes, repeats)]
    memory = peak_memory(max(sizes))
    lines = [_ABOUT.format(repeats=repeats), "", *_table(rows), ""]
    lines += [_ABOUT_CAP.format(many=MANY), ""]
    lines += [f"| exponent, N ≥ {LARGE:,} | scipy Delaunay | whole |", "|---|---|---|"]
    goals = []
    for name in FAMILIES:
        own = [row for row in rows if row.family == name]
        floor, whole = _exponents(own)
        lines.append(f"| {name} | {floor:.2f} | {whole:.2f} |")
        goals.append(
            Goal(
                f"whole / one scipy Delaunay, {name}, {own[-1].n:,} samples",
                own[-1].ratio,
                LARGEST_RATIO,
                True,
                ".2f",
            )
        )
        goals.append(
            Goal(f"exponent of the whole, {name}, N ≥ {LARGE:,}", whole, LARGEST_EXPONENT, True, ".2f")
        )
    goals.append(Goal(f"peak memory in MB, {max(sizes):,} samples", memory, LARGEST_MEMORY, True, ".0f"))
    about = (
        f"A process that reconstructs {max(sizes):,} samples of the double-8 holds at most {memory:.0f} MB, "
    )
    return [*lines, "", about + "interpreter, libraries and samples included.", ""], goals, rows


def stages(name: str, sizes: Sequence[int], repeats: int) -> list[Stages]:
    """Time every size; scipy and the skeleton take turns."""
    skeleton(point_set(name, n=2000).points)  # compile, or load what was compiled
    return [_stages(name, n, repeats) for n in sizes]


def _stages(name: str, n: int, repeats: int) -> Stages:
    points = point_set(name, n=n, sigma=0.01).points
    floor, whole, parts = np.inf, np.inf, dict[str, float]()
    for _ in range(repeats):
        floor = min(floor, _seconds(lambda: Delaunay(points)))
        with _stopwatch() as times:
            seconds = _seconds(lambda: skeleton(points))
        if seconds < whole:
            whole, parts = seconds, dict(times)
    tape = parts["tape"] - parts["delaunay"]  # the triangulation is part of building a tape
    return Stages(name, n, floor, parts["partition"], parts["delaunay"], tape, parts["skeleton"], whole)


@contextmanager
def _stopwatch() -> Iterator[dict[str, float]]:
    """Let the stages add up their own time while they are called by the method."""
    times: dict[str, float] = defaultdict(float)
    kept = [(module, name, getattr(module, name)) for module, name, _ in _CALLS]
    for module, name, stage in _CALLS:
        setattr(module, name, _timed(getattr(module, name), stage, times))
    try:
        yield times
    finally:
        for module, name, work in kept:
            setattr(module, name, work)


def _timed(work: Callable[..., Any], stage: str, times: dict[str, float]) -> Callable[..., Any]:
    def timed(*given: Any, **named: Any) -> Any:
        start = time.process_time()
        try:
            return work(*given, **named)
        finally:
            times[stage] += time.process_time() - start

    return timed


def _seconds(work: Callable[[], object]) -> float:
    start = time.process_time()  # of one core: nothing here uses more, and other programs may run
    work()
    return time.process_time() - start


def _table(rows: Sequence[Stages]) -> list[str]:
    columns = ("partition", "delaunay", "tape", "skeleton", "curves", "whole")
    lines = [
        "| set | N | scipy Delaunay | partition | Delaunay | tape | skeleton | curves | whole |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        cells = (f"{_time(getattr(row, one))} ({getattr(row, one) / row.scipy:.2f})" for one in columns)
        lines.append(f"| {row.family} | {row.n:,} | {_time(row.scipy)} | {' | '.join(cells)} |")
    return lines


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.0f} ms" if seconds < 1.0 else f"{seconds:.2f} s"


def _exponents(rows: Sequence[Stages]) -> tuple[float, float]:
    """Exponents of scipy's Delaunay and of the whole; none for a single size."""
    large = [row for row in rows if row.n >= LARGE]
    if len(large) < 2:
        return float("nan"), float("nan")
    sizes = [row.n for row in large]
    return exponent(sizes, [row.scipy for row in large]), exponent(sizes, [row.whole for row in large])


def draw(rows: Sequence[Stages]) -> Any:
    """Draw the share of every stage over N, beside scipy's Delaunay."""
    own = [row for row in rows if row.family == FAMILIES[-1]]
    sizes = [row.n for row in own]
    figure, axes = new(1, 1, (5.5, 4))
    axis = axes[0, 0]
    for name, label, colour, style in (
        ("whole", "skeleton, whole", RESULT, "-"),
        ("scipy", "scipy Delaunay of all samples", TRUTH, "--"),
        ("partition", "partition, scale", CLOUD, "-"),
        ("delaunay", "Delaunay", "C0", "-"),
        ("tape", "tape", "C1", "-"),
        ("skeleton", "axis and graph", "C2", "-"),
        ("curves", "curves, refinement", "C4", "-"),
    ):
        axis.loglog(sizes, [getattr(row, name) for row in own], style, color=colour, label=label, marker=".")
    axis.set_xlabel("N")
    axis.set_ylabel("seconds of one core")
    axis.legend()
    return figure


def peak_memory(n: int) -> float:
    """Return the MB that a fresh process holds at most while it reconstructs ``n`` samples."""
    command = [sys.executable, "-m", "benchmarks.stages", "--memory", str(n)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)  # noqa: S603 - ourselves


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--memory", type=int, help="print the peak MB of reconstructing so many samples")
    options = parser.parse_args(arguments)
    if options.memory:
        skeleton(point_set(FAMILIES[-1], n=options.memory, sigma=0.01).points)
        print(peak() / 1e6)
        return
    print("\n".join(report(SIZES, options.repeats)[0]))


if __name__ == "__main__":
    main()
