"""All benchmarks, written to docs/benchmarks.md with their plots: ``python -m benchmarks [--quick]``."""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np

from benchmarks import accuracy, comparison, crossings, goals, hair, overhead, stages, timing
from benchmarks.cases import Row, cases, measure_all
from benchmarks.goals import Goal
from benchmarks.plots import RESULT, TRUTH, new, save

__all__ = ["main"]

DOCS = Path(__file__).parent.parent / "docs"
SEEDS = 4
BEYOND = ("figure_8", "double_8", "lissajous", "square", "star", "airfoil", "multi_scan")
_ABOUT = (
    "Written by `{command}` in {minutes:.0f} minutes. Accuracy depends on the seeds alone; times depend on "
    "the machine, and their ratios to floors measured in the same run much less. Times are seconds of one "
    "core, but for HTTP and imports, which a clock times."
)
_ABOUT_ACCURACY = (
    "Point sets of known curves, reconstructed without a single parameter; σ is a fraction of the "
    "diagonal of the bounding box. The oracle is local quadratic regression told each sample's true arc "
    "length, with the bandwidth that minimises the true error. Errors are of the cases with right curves "
    "and flags; topology right also asks that each curve covers its own true curve, and for the true "
    "number of crossings. Seeds per family, N and σ: {seeds}."
)
_ABOUT_TIME = (
    "An open S with σ = 1 %; the contestants take turns, and the best of three counts. With ε given, a "
    "point has about 50 neighbours. March + refinement is the whole reconstruction less the partition."
)
_ABOUT_GOALS = (
    "Over the N and σ of the tables below. Rates and errors of curves that cross are of those whose "
    "crossings are all at 40° or more, or that have junctions only; `split` and `waist` are of closed curves."
)
PAPER_EXPONENT = 1.55  # §6, Fig. 12
Lines = list[str]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all; write the report and the plots, of a quick run only when a folder is given."""
    options = _options(arguments)
    start = time.perf_counter()
    body, reached = _measured(options)
    minutes = (time.perf_counter() - start) / 60
    lines = [*_heading(_command(options), minutes), *_goals(reached), *body]
    print("\n".join(lines))
    if options.folder:
        (options.folder / "benchmarks.md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a small sample of everything")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="per family, N and sigma")
    parser.add_argument("--jobs", type=int, default=min(os.cpu_count() or 1, 8))
    parser.add_argument(
        "--folder", type=Path, help="where to write; by default docs, but nowhere for a quick run"
    )
    options = parser.parse_args(arguments)
    if options.quick:
        options.seeds = 1
    elif options.folder is None:
        options.folder = DOCS
    return options


def _command(options: argparse.Namespace) -> str:
    if options.quick:
        return "python -m benchmarks --quick"
    return "make bench" if options.seeds == SEEDS else f"python -m benchmarks --seeds {options.seeds}"


def _measured(options: argparse.Namespace) -> tuple[Lines, list[Goal]]:
    """Measure everything, times first: before other processes are started."""
    lines = _timing(options)
    skeleton_times, fast = _skeleton_timing(options)
    lines += [*skeleton_times, *_overhead(options.quick)]
    accurate, march = _accuracy(options)
    skeleton_lines, right = _skeleton_accuracy(options, march)
    return [*lines, *accurate, *skeleton_lines], [*right, *fast]


def _heading(command: str, minutes: float) -> Lines:
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba"))
    return [
        "# Benchmarks",
        "",
        _ABOUT.format(command=command, minutes=minutes),
        "",
        f"Machine: {_processor()}, {os.cpu_count()} cores, {platform.system()}; Python "
        f"{platform.python_version()}, {packages}.",
        "",
    ]


def _processor() -> str:
    """Name the processor as Linux does, or else as Python does."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _goals(reached: Sequence[Goal]) -> Lines:
    return ["## The skeleton's goals", "", _ABOUT_GOALS, "", *goals.table(reached), ""]


def _accuracy(options: argparse.Namespace) -> tuple[Lines, list[Row]]:
    """Return the lines on the PCA method, and what was measured on families without crossings."""
    quick, jobs, seeds = options.quick, options.jobs, options.seeds
    sizes, sigmas = ((1000, 20000), (0.01,)) if quick else (accuracy.SIZES, accuracy.SIGMAS)
    own = list(measure_all(cases(accuracy.families(), sizes, sigmas, seeds), jobs))
    other = list(measure_all(cases(accuracy.families(held_out=True), sizes, sigmas, seeds), jobs))
    beyond = list(measure_all(cases(BEYOND, (5000,), (0.005, 0.01), seeds), jobs))
    if options.folder and not quick:
        _plot_errors(own + other, options.folder)
    lines = [
        "## Accuracy",
        "",
        _ABOUT_ACCURACY.format(seeds=seeds),
        "",
        "### The PCA method: smooth families without crossings",
        "",
        *_tables(own),
        "![Error over N](figures/error.svg)",
        "",
        "### The PCA method: families held out; no constant was tuned with them",
        "",
        *_tables(other),
        "### The PCA method beyond: crossings, corners, registered scans",
        "",
        "N = 5000, σ = 0.5 and 1 %.",
        "",
        *accuracy.table(beyond, lambda case: case.family, "family"),
        "",
    ]
    return lines, own + other


def _skeleton_accuracy(options: argparse.Namespace, march: Sequence[Row]) -> tuple[Lines, list[Goal]]:
    sizes = (1000, 20000) if options.quick else crossings.SIZES
    sigmas = (0.01,) if options.quick else accuracy.SIGMAS
    grid = sizes, sigmas, options.seeds, options.jobs
    across, right = crossings.report(*grid)
    beside, as_good = comparison.report(march, *grid)
    thin, bald = hair.report(options.seeds)
    return ["## Accuracy of the skeleton", "", *across, *beside, *thin], [*right, *as_good, *bald]


def _tables(rows: Sequence[Row]) -> Lines:
    lines = []
    for title, key in accuracy.KEYS.items():
        lines += [*accuracy.table(rows, key, title), ""]
    return lines


def _timing(options: argparse.Namespace) -> Lines:
    quick = options.quick
    rows = timing.timings(timing.SIZES[::2] if quick else timing.SIZES, 1 if quick else 3)
    imports = timing.import_times(repeats=1 if quick else 3)
    if options.folder:
        _plot_times(rows, options.folder)
    return [
        "## Time of the PCA method",
        "",
        _ABOUT_TIME,
        "",
        *timing.tables(rows),
        "",
        "![Time over N](figures/time.svg)",
        "",
        f"The partition of 10⁶ points adds {timing.partition_memory(10**6):.0f} MB to the peak memory.",
        "",
        "| import | time |",
        "|---|---|",
        *(f"| `{one.module}` | {one.seconds:.2f} s |" for one in imports),
        "",
    ]


def _skeleton_timing(options: argparse.Namespace) -> tuple[Lines, list[Goal]]:
    sizes, repeats = (stages.SIZES[:2], 1) if options.quick else (stages.SIZES, 3)
    lines, fast, rows = stages.report(sizes, repeats)
    if options.folder:
        save(stages.draw(rows), "stages.svg", options.folder / "figures")
    picture = ["![Time of the stages over N](figures/stages.svg)", ""]
    return ["## Time of the skeleton by stages", "", *lines, *picture], fast


def _overhead(quick: bool) -> Lines:
    row = overhead.measure(repeats=3 if quick else 9)
    return [
        "## HTTP",
        "",
        "`POST /reconstruct/pca` on loopback, warm, medians.",
        "",
        *overhead.tables(row),
        "",
    ]


def _plot_errors(rows: Sequence[Row], folder: Path) -> None:
    """Draw the median error over N, one line per noise, with the oracle's dashed beside it."""
    figure, axes = new(1, 1, (5.5, 4))
    axis = axes[0, 0]
    for k, sigma in enumerate(accuracy.SIGMAS):
        shade = f"C{k}"
        for name, style in (("rms", "-"), ("oracle", "--")):
            groups = [
                [r for r in rows if r.flags and r.case.sigma == sigma and r.case.n == n]
                for n in accuracy.SIZES
            ]
            median = [np.median([getattr(r, name) for r in group]) for group in groups]
            label = f"σ = {sigma:.2%}" if name == "rms" else None
            axis.loglog(accuracy.SIZES, median, style, color=shade, label=label, marker=".")
    axis.plot([], [], "--", color="0.4", label="oracle")
    axis.set_xlabel("N")
    axis.set_ylabel("RMS error / σ, median over families")
    axis.legend()
    save(figure, "error.svg", folder / "figures")


def _plot_times(rows: Sequence[timing.Timing], folder: Path) -> None:
    """Draw time over N as in Fig. 12, with the paper's exponent for comparison."""
    figure, axes = new(1, 1, (5.5, 4))
    axis = axes[0, 0]
    sizes = np.array([row.n for row in rows], float)
    for name, label, colour in (
        ("pca", "whole reconstruction", RESULT),
        ("march", "march + refinement", "C1"),
        ("partition", "partition, ε given", TRUTH),
        ("tree", "cKDTree build", "0.5"),
    ):
        axis.loglog(sizes, [getattr(row, name) for row in rows], color=colour, label=label, marker=".")
    paper = rows[0].pca * (sizes / sizes[0]) ** PAPER_EXPONENT
    axis.loglog(sizes, paper, ":", color="0.3", label=f"$O(N^{{{PAPER_EXPONENT}}})$, the paper")
    axis.set_xlabel("N")
    axis.set_ylabel("seconds of one core")
    axis.legend()
    save(figure, "time.svg", folder / "figures")


if __name__ == "__main__":
    main()
