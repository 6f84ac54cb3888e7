"""How much of the truth lies within two standard errors: ``python -m benchmarks.coverage --help``."""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import crossing_families, families
from core.errors import TapelineError
from core.methods import pca, skeleton
from core.results import Reconstruction
from core.truth import point_set, score
from core.truth.coverage import coverage

__all__ = ["Covered", "main", "measure", "table"]

METHODS: dict[str, Callable[[NDArray[np.float64]], Reconstruction]] = {"pca": pca, "skeleton": skeleton}
SIZES = (300, 1000, 5000, 20000)
SIGMAS = (0.0025, 0.005, 0.01, 0.02)
WIDE = 3.0  # standard errors


@dataclass(frozen=True, slots=True)
class Covered:
    """Coverage of one point set.

    Attributes
    ----------
    family : str
    n : int
    sigma : float
        Fraction of the diagonal.
    two, three : float
        Share of the true length within two and three standard errors; NaN without a right answer.
    ratio : float
        RMS distance of the truth over RMS standard error.
    """

    family: str
    n: int
    sigma: float
    two: float
    three: float
    ratio: float


def measure(
    family: str, n: int, sigma: float, seed: int, method: str = "pca", outliers: float = 0.0
) -> Covered:
    """Reconstruct one point set; all NaN where the result is no curve of the truth's shape."""
    truth = point_set(family, n=n, sigma=sigma, outliers=outliers, seed=seed)
    missing = Covered(family, n, sigma, np.nan, np.nan, np.nan)
    try:
        curves = METHODS[method](truth.points).curves
    except TapelineError:
        return missing
    if not score([(one.vertices, one.closed) for one in curves], truth).topology_right:
        return missing
    unknown = [np.full(len(one.vertices), np.nan) for one in curves]
    errors = [one.standard_errors for one in curves]
    seen = coverage(
        [
            (one.vertices, one.closed, none if error is None else error)
            for one, error, none in zip(curves, errors, unknown, strict=True)
        ],
        truth,
    )
    if not len(seen.distance):
        return missing
    ratio = np.sqrt(np.mean(seen.distance**2) / np.mean(seen.error**2))
    return Covered(family, n, sigma, seen.share(), seen.share(WIDE), float(ratio))


def table(rows: Sequence[Covered], key: Callable[[Covered], object], title: str) -> list[str]:
    """Return the lines of a markdown table, one row per value of ``key``."""
    groups: dict[object, list[Covered]] = defaultdict(list)
    for row in rows:
        groups[key(row)].append(row)
    lines = [
        f"| {title} | sets | of the right shape | within 2 s.e. | in the worst tenth | 3 s.e. | RMS / s.e. |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, group in groups.items():
        known = np.array([(row.two, row.three, row.ratio) for row in group if not np.isnan(row.two)])
        line = f"| {name} | {len(group)} | {len(known) / len(group):.0%} | "
        if len(known):
            two, three = known[:, :2].mean(axis=0)
            low, ratio = np.quantile(known[:, 0], 0.1), np.sqrt(np.mean(known[:, 2] ** 2))
            line += f"{two:.1%} | {low:.1%} | {three:.1%} | {ratio:.2f} |"
        lines.append(line)
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    options = _options(arguments)
    grid = list(_grid(options))
    rows = [measure(*case, options.method, options.outliers) for case in grid]
    for title, key in KEYS.items():
        print("\n".join(table(rows, key, title)), end="\n\n")


KEYS: dict[str, Callable[[Covered], object]] = {
    "family": lambda row: row.family,
    "N": lambda row: row.n,
    "σ": lambda row: f"{row.sigma:.2%}",
    "all": lambda _row: "all",
}


def _grid(options: argparse.Namespace) -> Iterator[tuple[str, int, float, int]]:
    for name in _families(options.families):
        for n in options.n:
            for sigma in options.sigma:
                yield from ((name, n, sigma, seed) for seed in range(options.seeds))


def _families(text: str) -> list[str]:
    groups = {
        "all": families(),
        "held_out": families(held_out=True),
        "crossing": crossing_families(),
        "held_out_crossing": crossing_families(held_out=True),
    }
    return [name for part in text.split(",") for name in groups.get(part, (part,))]


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--families",
        default="all",
        help="names with commas between; 'all' are the smooth built-in ones without crossings, 'crossing' "
        "those with, 'held_out' and 'held_out_crossing' those that no method was tuned with",
    )
    parser.add_argument("--method", choices=list(METHODS), default="pca")
    parser.add_argument("--n", type=_numbers(int), default=SIZES)
    parser.add_argument("--sigma", type=_numbers(float), default=SIGMAS, help="fractions of the diagonal")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--outliers", type=float, default=0.0, help="fraction of N, on top")
    return parser.parse_args(arguments)


def _numbers(kind: type) -> Callable[[str], list[float]]:
    return lambda text: [kind(float(part)) for part in text.split(",")]


if __name__ == "__main__":
    main()
