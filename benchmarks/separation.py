"""Right topology over the distance between branches: ``python -m benchmarks.separation --help``.

Only families kept apart, which no method is tuned with.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cases import METHODS, Case, Row, measure_all
from core.cloud.frame import is_quasi_planar
from core.truth import clearance, family, held_apart_names, point_set

__all__ = ["DISTANCES", "SIZES", "grid", "main", "table"]

DISTANCES = (4.5, 5.0, 5.5, 6.0, 7.0, 9.0, 12.0)  # between branches, in units of the noise
SIZES = (1000, 5000, 20000)
LEAST_RADIUS = 2.0  # of curvature, in units of the noise: half the width of the narrowest bend asked for

Group = dict[float, list[Row]]


def grid(sizes: Sequence[int], seeds: int, method: str) -> dict[float, list[Case]]:
    """Return the cases of each distance: the noise follows from it, family by family and seed by seed."""
    chosen = [one for one in map(family, held_apart_names()) if one.non_crossing]
    return {
        distance: [
            Case(one.name, n, sigma, seed, method)
            for one in chosen
            for seed in range(seeds)
            for sigma in _sigma(one.name, seed, distance, method)
            for n in sizes
        ]
        for distance in DISTANCES
    }


def _sigma(name: str, seed: int, distance: float, method: str) -> Iterator[float]:
    """Yield the noise that puts the branches at that distance; nothing where that cannot be asked."""
    own = family(name)
    sample = point_set(name, n=1, seed=seed)
    room = clearance(sample)
    if not np.isfinite(room.separation):
        return
    if method == "skeleton" and not is_quasi_planar(np.concatenate([c.vertices for c in sample.curves])):
        return
    share = room.separation / distance
    if room.radius / share >= LEAST_RADIUS:
        yield own.sigma * share


def has_wide_gap(case: Case) -> bool:
    """Tell whether some gap between samples is wider than what independent ones should leave."""
    return clearance(case.point_set()).gap > np.log(case.n) + 5.0


def table(measured: Group) -> list[str]:
    """Return the lines of a markdown table."""
    lines = [
        "| distance, σ | cases | topology right | of those without wide gaps | RMS / oracle, median | 90 % |",
        "|---|---|---|---|---|---|",
    ]
    pooled = {
        "4.5–5.5": [row for d, rows in measured.items() if d < 6.0 for row in rows],
        "≥ 6": [row for d, rows in measured.items() if d >= 6.0 for row in rows],
    }
    for title, rows in [*((f"{d:g}", rows) for d, rows in measured.items()), *pooled.items()]:
        clear = [row for row in rows if not has_wide_gap(row.case)]
        median, high = np.quantile([row.ratio for row in rows if row.flags] or [np.nan], [0.5, 0.9])
        lines.append(
            f"| {title} | {len(rows)} | {_right(rows):.1%} | {_right(clear):.1%} of {len(clear)} "
            f"| {median:.2f} | {high:.2f} |"
        )
    return lines


def _right(rows: Sequence[Row]) -> float:
    return float(np.mean([row.topology for row in rows])) if rows else float("nan")


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    options = _options(arguments)
    sizes = [int(part) for part in options.n.split(",")]
    measured = {
        distance: list(measure_all(cases[:: 3 if options.quick else 1], options.jobs))
        for distance, cases in grid(sizes, options.seeds, options.method).items()
    }
    print(f"### Distance between branches: {options.method}\n")
    print("\n".join(table(measured)))
    if options.families:
        rows = [row for group in measured.values() for row in group]
        print("\n" + "\n".join(_by_family(rows)))


def _by_family(rows: Sequence[Row]) -> list[str]:
    lines = ["| family | cases | topology right |", "|---|---|---|"]
    for name in dict.fromkeys(row.case.family for row in rows):
        own = [row for row in rows if row.case.family == name]
        lines.append(f"| {name} | {len(own)} | {_right(own):.1%} |")
    return lines


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", choices=METHODS, default="auto")
    parser.add_argument("--n", default=",".join(map(str, SIZES)), help="numbers of samples, with commas")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="every third case only")
    parser.add_argument("--families", action="store_true", help="also a table by family")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    main()
