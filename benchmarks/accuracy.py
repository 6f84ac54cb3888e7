"""Accuracy over families, sizes and noise: ``python -m benchmarks.accuracy --help``."""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.cases import METHODS, Case, Row, cases, measure_all
from core.truth import Reading, family, held_out_names, names

__all__ = [
    "KEYS",
    "METHODS",
    "READINGS",
    "SIGMAS",
    "SIZES",
    "crossing_families",
    "families",
    "main",
    "summary",
    "table",
]

READINGS: tuple[Reading, ...] = ("through", "split", "waist")

SIZES = (1000, 5000, 20000, 50000)
SIGMAS = (0.0025, 0.005, 0.01, 0.02)


def families(held_out: bool = False) -> tuple[str, ...]:
    """Return the smooth families without crossings whose noise is independent from sample to sample."""
    every = held_out_names() if held_out else names()
    chosen = [family(name) for name in every]
    return tuple(one.name for one in chosen if one.smooth and one.non_crossing and one.scans is None)


def crossing_families(held_out: bool = False, reading: Reading = "through") -> tuple[str, ...]:
    """Return the smooth families with crossings or junctions; only closed curves for the other readings."""
    every = held_out_names() if held_out else names()
    chosen = [one for one in map(family, every) if one.smooth and not one.non_crossing]
    return tuple(one.name for one in chosen if reading == "through" or all(c.closed for c in one.build(0)))


def summary(rows: Sequence[Row]) -> tuple[float, ...]:
    """Return rates of right flags and topology, ratio median and 90 %, error of sigma median and 95 %."""
    good = [row for row in rows if row.flags]
    ratio = [row.ratio for row in good] or [np.nan]
    sigma = [abs(row.sigma_error) for row in good] or [np.nan]
    return (
        float(np.mean([row.flags for row in rows])),
        float(np.mean([row.topology for row in rows])),
        *(float(q) for q in np.quantile(ratio, [0.5, 0.9])),
        *(float(q) for q in np.quantile(sigma, [0.5, 0.95])),
    )


def table(rows: Sequence[Row], key: Callable[[Case], object], title: str) -> list[str]:
    """Return the lines of a markdown table with one row per value of ``key``."""
    groups: dict[object, list[Row]] = defaultdict(list)
    for row in rows:
        groups[key(row.case)].append(row)
    lines = [
        f"| {title} | cases | curves and flags right | topology right | RMS / oracle, median | 90 % "
        "| error of σ̂, median | 95 % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, group in groups.items():
        flags, topology, median, high, sigma, sigma_high = summary(group)
        lines.append(
            f"| {name} | {len(group)} | {flags:.1%} | {topology:.1%} | {median:.2f} | {high:.2f} "
            f"| {sigma:.1%} | {sigma_high:.1%} |"
        )
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    options = _options(arguments)
    chosen = _families(options.families, options.crossings)
    grid = cases(chosen, options.n, options.sigma, options.seeds, options.method, options.crossings)
    rows = list(measure_all(grid, options.jobs))
    _print_groups(rows)
    for title, key in KEYS.items():
        print("\n" + "\n".join(table(rows, key, title)))
    if options.failures:
        _print_failures(rows)
    if options.worst:
        _print_worst(rows, options.worst)


KEYS: dict[str, Callable[[Case], object]] = {
    "family": lambda case: case.family,
    "N": lambda case: case.n,
    "σ": lambda case: f"{case.sigma:.2%}",
    "all": lambda _case: "all",
}


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--families",
        default="all",
        help="names with commas between; 'all' are the smooth built-in ones without crossings, 'crossing' "
        "those with, 'held_out' and 'held_out_crossing' those that no method was tuned with",
    )
    parser.add_argument("--method", choices=METHODS, default="pca")
    parser.add_argument(
        "--crossings", choices=READINGS, default="through", help="how the skeleton reads crossings"
    )
    parser.add_argument("--n", type=_numbers(int), default=list(SIZES))
    parser.add_argument(
        "--sigma", type=_numbers(float), default=list(SIGMAS), help="fractions of the diagonal"
    )
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--failures", action="store_true", help="list every case with a wrong topology")
    parser.add_argument(
        "--worst", type=int, default=0, help="list this many cases with the largest RMS / oracle"
    )
    options = parser.parse_args(arguments)
    if options.method != "skeleton" and options.crossings != "through":
        parser.error("Only the skeleton reads crossings otherwise than straight through.")
    return options


def _families(text: str, reading: Reading) -> list[str]:
    """Return the names in a list with commas between, groups of families put in full."""
    groups = {
        "all": families(),
        "held_out": families(held_out=True),
        "crossing": crossing_families(False, reading),
        "held_out_crossing": crossing_families(True, reading),
    }
    return [name for part in text.split(",") for name in groups.get(part, (part,))]


def _numbers(kind: type) -> Callable[[str], list[float]]:
    return lambda text: [kind(float(part)) for part in text.split(",")]


def _print_groups(rows: Sequence[Row]) -> None:
    """Print one line per family, size and noise."""
    groups: dict[tuple[str, int, float], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.case.family, row.case.n, row.case.sigma].append(row)
    print(f"{'family':20} {'n':>6} {'sigma':>7} flags  topol  ratio50 ratio90  sigma50 sigma95  seconds")
    for (name, n, sigma), group in groups.items():
        flags, topology, median, high, s50, s95 = summary(group)
        seconds = np.median([row.seconds for row in group])
        print(
            f"{name:20} {n:6d} {sigma:7.4f} {flags:5.0%}  {topology:5.0%}  {median:7.2f} {high:7.2f}"
            f"  {s50:7.2%} {s95:7.2%}  {seconds:7.3f}"
        )


def _print_failures(rows: Sequence[Row]) -> None:
    wrong = [row for row in rows if row.problem]
    print(f"\n{len(wrong)} of {len(rows)} wrong:")
    for row in wrong:
        case = row.case
        print(f"  {case.family} n={case.n} sigma={case.sigma:g} seed={case.seed}: {row.problem}")


def _print_worst(rows: Sequence[Row], count: int) -> None:
    print("\nlargest RMS / oracle:")
    for row in sorted((r for r in rows if r.flags), key=lambda r: -r.ratio)[:count]:
        case = row.case
        print(
            f"  {case.family} n={case.n} sigma={case.sigma:g} seed={case.seed}: {row.ratio:.2f} "
            f"(rms {row.rms:.3f}, oracle {row.oracle:.3f}, max {row.maximum:.2f} sigma; "
            f"sigma error {row.sigma_error:+.1%})"
        )


if __name__ == "__main__":
    main()
