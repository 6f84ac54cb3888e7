"""Accuracy on harder samples, one row a condition: ``python -m benchmarks.hard --help``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.cases import METHODS, Case, Row, measure_all
from core.truth import PLAIN, Conditions, family

__all__ = ["SETTINGS", "Setting", "grid", "main", "table"]

SMOOTH = ("ellipse", "s_shape", "wasp_waist", "nested", "disjoint", "bean", "random_closed", "random_open")


@dataclass(frozen=True, slots=True)
class Setting:
    """One row of the table.

    Attributes
    ----------
    name : str
    families : tuple of str
    conditions : Conditions
    outliers : float
        As a fraction of n.
    sizes : tuple of int
        Empty for the families' own sizes, and their own noise with it.
    sigma : float
        As a fraction of the diagonal.
    """

    name: str
    families: tuple[str, ...] = SMOOTH
    conditions: Conditions = PLAIN
    outliers: float = 0.0
    sizes: tuple[int, ...] = (1000, 4000)
    sigma: float = 0.0075


HEAD = (
    "| condition | cases | topology right | RMS / oracle, median | 90 % | error of σ̂, median | seconds |",
    "|---|---|---|---|---|---|---|",
)
SETTINGS = (
    Setting("plain"),
    Setting("noise 1:4", conditions=Conditions(noise_ratio=4.0), sigma=0.006),
    Setting("density 10:1", conditions=Conditions(density_ratio=10.0)),
    Setting("density 10:1 in blocks", conditions=Conditions(density_ratio=10.0, blocks=6)),
    Setting("5 % outliers", outliers=0.05),
    Setting("10 % outliers", outliers=0.1),
    Setting("5 % outliers, clustered", outliers=0.05, conditions=Conditions(outliers="clustered")),
    Setting("10 % outliers, clustered", outliers=0.1, conditions=Conditions(outliers="clustered")),
    Setting("tails of t, 3 d.f.", conditions=Conditions(degrees_of_freedom=3.0)),
    Setting("corners", ("square", "star", "airfoil", "naca"), sizes=()),
    Setting("fine detail", ("half_gear", "key", "gear"), sizes=()),
    Setting("unequal curves", ("planets", "planets_equal"), sizes=()),
    Setting("duplicates 30 %", conditions=Conditions(duplicates=0.3)),
    Setting("grid of 1 σ", conditions=Conditions(quantum=1.0)),
    Setting("grid of 2 σ", conditions=Conditions(quantum=2.0)),
    Setting("even spacing", conditions=Conditions(spacing="even")),
    Setting("N = 100", sizes=(100,)),
    Setting("N = 200", sizes=(200,)),
    Setting("N = 300", sizes=(300,)),
)


def grid(setting: Setting, seeds: int, method: str) -> list[Case]:
    """Return the cases of a row."""
    return [
        Case(name, n, sigma, seed, method, outliers=setting.outliers, conditions=setting.conditions)
        for name in setting.families
        for n, sigma in _sizes(setting, name)
        for seed in range(seeds)
    ]


def _sizes(setting: Setting, name: str) -> list[tuple[int, float]]:
    own = family(name)
    return [(n, setting.sigma) for n in setting.sizes] or [(own.size, own.sigma)]


def table(measured: dict[str, list[Row]]) -> list[str]:
    """Return the lines of a markdown table; errors are of the cases with right curves and flags."""
    return [*HEAD, *(line(name, rows) for name, rows in measured.items())]


def line(name: str, rows: Sequence[Row]) -> str:
    """Return one line of the table."""
    good = [row for row in rows if row.flags]
    median, high = np.quantile([row.ratio for row in good] or [np.nan], [0.5, 0.9])
    sigma = np.median([row.sigma_error for row in good] or [np.nan])
    return (
        f"| {name} | {len(rows)} | {np.mean([row.topology for row in rows]):.1%} | {median:.2f} "
        f"| {high:.2f} | {sigma:+.1%} | {np.median([row.seconds for row in rows]):.2f} |"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print each line as soon as it is known."""
    options = _options(arguments)
    chosen = [one for one in SETTINGS if any(part in one.name for part in options.only.split(","))]
    measured: dict[str, list[Row]] = {}
    print("\n".join((f"### Harder samples: {options.method}", "", *HEAD)), flush=True)
    for setting in chosen:
        cases = grid(setting, options.seeds, options.method)
        rows = list(measure_all(cases[:: 3 if options.quick else 1], options.jobs))
        print(line(setting.name, rows), flush=True)
        measured[setting.name] = rows
        if options.failures:
            _print_failures(setting.name, rows)
    if options.failures:
        _print_worst(measured)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", choices=METHODS, default="auto")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="every third case only")
    parser.add_argument("--only", default="", help="rows whose name holds one of these texts, commas between")
    parser.add_argument(
        "--failures",
        action="store_true",
        help="list wrong topologies (to the standard error) and the largest errors",
    )
    return parser.parse_args(arguments)


def _print_failures(name: str, rows: Sequence[Row]) -> None:
    """Print wrong cases as family:n:sigma:seed:condition, beside the table: to the standard error."""
    for row in rows:
        if row.problem:
            print(f"{row.case}:{name}  {row.problem}", file=sys.stderr, flush=True)


def _print_worst(measured: dict[str, list[Row]]) -> None:
    good = [(row, name) for name, rows in measured.items() for row in rows if row.flags]
    print("\nlargest RMS / oracle:")
    for row, name in sorted(good, key=lambda one: -one[0].ratio)[:15]:
        print(f"  {row.case}:{name}  {row.ratio:.2f} (max {row.maximum:.1f} σ, σ̂ {row.sigma_error:+.1%})")


if __name__ == "__main__":
    main()
