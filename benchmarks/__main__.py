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

from benchmarks import accuracy, overhead, timing
from benchmarks.cases import Row, cases, measure_all
from benchmarks.plots import RESULT, TRUTH, new, save

__all__ = ["main"]

REPORT = Path(__file__).parent.parent / "docs" / "benchmarks.md"
BEYOND = ("figure_8", "double_8", "lissajous", "square", "star", "airfoil", "multi_scan")
_ABOUT = (
    "Written by `make bench`. Accuracy depends on the seeds alone; times depend on the machine, and their "
    "ratios to floors measured in the same run much less."
)
_ABOUT_ACCURACY = (
    "Point sets of known curves, reconstructed without a single parameter; σ is a fraction of the "
    "diagonal of the bounding box. The oracle is local quadratic regression told each sample's true arc "
    "length, with the bandwidth that minimises the true error. Errors are of the cases with right curves "
    "and flags; topology right also asks that each curve covers its own true curve, and for the true "
    "number of crossings."
)
_ABOUT_TIME = (
    "An open S with σ = 1 %; the contestants take turns, and the best of three counts. With ε given, a "
    "point has about 50 neighbours. March + refinement is the whole reconstruction less the partition."
)
PAPER_EXPONENT = 1.55  # §6, Fig. 12


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all; write the report and the plots unless the run is a quick one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a small sample of everything; writes nothing")
    parser.add_argument("--seeds", type=int, default=10, help="per family, N and sigma")
    parser.add_argument("--jobs", type=int, default=min(os.cpu_count() or 1, 8))
    options = parser.parse_args(arguments)
    start = time.perf_counter()
    lines = [
        *_heading(),
        *_timing(options.quick),
        *_overhead(options.quick),
        *_accuracy(options),
    ]
    print("\n".join(lines))
    print(f"\n{time.perf_counter() - start:.0f} s")
    if not options.quick:
        REPORT.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _heading() -> list[str]:
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba"))
    return [
        "# Benchmarks",
        "",
        _ABOUT,
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


def _accuracy(options: argparse.Namespace) -> list[str]:
    quick, jobs, seeds = options.quick, options.jobs, 1 if options.quick else options.seeds
    sizes, sigmas = ((1000, 20000), (0.01,)) if quick else (accuracy.SIZES, accuracy.SIGMAS)
    own = list(measure_all(cases(accuracy.families(), sizes, sigmas, seeds), jobs))
    other = list(measure_all(cases(accuracy.families(held_out=True), sizes, sigmas, seeds), jobs))
    beyond = list(measure_all(cases(BEYOND, (5000,), (0.005, 0.01), seeds), jobs))
    if not quick:
        _plot_errors(own + other)
    return [
        "## Accuracy",
        "",
        f"{_ABOUT_ACCURACY} Seeds per family, N and σ: {seeds}.",
        "",
        "### Smooth families without crossings",
        "",
        *_tables(own),
        "![Error over N](figures/error.svg)",
        "",
        "### Families held out: no constant was tuned with them",
        "",
        *_tables(other),
        "### Beyond: crossings, corners, registered scans",
        "",
        "N = 5000, σ = 0.5 and 1 %.",
        "",
        *accuracy.table(beyond, lambda case: case.family, "family"),
    ]


def _tables(rows: Sequence[Row]) -> list[str]:
    lines = []
    for title, key in accuracy.KEYS.items():
        lines += [*accuracy.table(rows, key, title), ""]
    return lines


def _timing(quick: bool) -> list[str]:
    rows = timing.timings(timing.SIZES[::2] if quick else timing.SIZES, 1 if quick else 3)
    imports = timing.import_times(repeats=1 if quick else 3)
    if not quick:
        _plot_times(rows)
    return [
        "## Time",
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


def _overhead(quick: bool) -> list[str]:
    row = overhead.measure(repeats=3 if quick else 9)
    return [
        "## HTTP",
        "",
        "`POST /reconstruct/pca` on loopback, warm, medians.",
        "",
        *overhead.tables(row),
        "",
    ]


def _plot_errors(rows: Sequence[Row]) -> None:
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
    save(figure, "error.svg")


def _plot_times(rows: Sequence[timing.Timing]) -> None:
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
    axis.set_ylabel("seconds")
    axis.legend()
    save(figure, "time.svg")


if __name__ == "__main__":
    main()
