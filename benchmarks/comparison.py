"""The skeleton beside the PCA march, on curves that do not cross."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from benchmarks.accuracy import families
from benchmarks.cases import Case, Row, cases, measure_all
from benchmarks.goals import Goal
from core.cloud.frame import is_quasi_planar
from core.truth import family, point_set
from core.truth.intersections import separation

__all__ = ["planar_families", "report"]

APART = 6.0  # sigma between branches: nearer ones are beyond the goals
WITHIN = 0.1  # of the PCA method's figures

_ABOUT = (
    "The same point sets of curves without crossings by both methods, without a single parameter; curves "
    "that lie in no plane are left out, for the tape is flat. Right is the whole topology; errors are "
    "compared case by case where both methods have the right curves and flags. Only cases whose branches "
    "are at least 6 σ apart: {kept} of {total}."
)
_ABOUT_REST = (
    "In the other {count} cases the PCA method is right {pca:.1%} of the time, the skeleton {own:.1%}."
)
Pair = tuple[Row, Row]


def planar_families(held_out: bool = False) -> tuple[str, ...]:
    """Return the smooth families without crossings whose curves lie in a plane."""
    return tuple(name for name in families(held_out) if _is_planar(name))


def report(
    pca: Sequence[Row], sizes: Sequence[int], sigmas: Sequence[float], seeds: int, jobs: int
) -> tuple[list[str], list[Goal]]:
    """Measure the skeleton on the cases that the PCA method was measured on; lines, and figures to reach."""
    chosen = [name for held_out in (False, True) for name in planar_families(held_out)]
    known = {row.case: row for row in pca}
    pairs = [
        (known[Case(row.case.family, row.case.n, row.case.sigma, row.case.seed)], row)
        for row in measure_all(cases(chosen, sizes, sigmas, seeds, "skeleton"), jobs)
    ]
    clear = [pair for pair in pairs if branch_gap(pair[0].case) >= APART]
    close = [pair for pair in pairs if branch_gap(pair[0].case) < APART]
    lines = [
        "### Curves that do not cross: the skeleton beside the PCA method",
        "",
        _ABOUT.format(kept=len(clear), total=len(pairs)),
        "",
        *_table(clear),
        "",
    ]
    if close:
        lines += [_ABOUT_REST.format(count=len(close), pca=_right(close, 0), own=_right(close, 1)), ""]
    return lines, _goals(clear)


def branch_gap(case: Case) -> float:
    """Return the least distance between branches of the exact curves, in units of the noise."""
    gap = _branch_gap(case.family, case.seed if family(case.family).varies else 0)
    return gap / point_set(case.family, n=1, sigma=case.sigma, seed=case.seed).sigma


@lru_cache(maxsize=256)
def _branch_gap(name: str, seed: int) -> float:
    truth = point_set(name, n=1, seed=seed)
    return separation([(one.vertices, one.closed) for one in truth.curves])


def _is_planar(name: str) -> bool:
    return is_quasi_planar(np.concatenate([one.vertices for one in point_set(name, n=1).curves]))


def _table(pairs: Sequence[Pair]) -> list[str]:
    groups: dict[str, list[Pair]] = defaultdict(list)
    for pair in pairs:
        groups[pair[0].case.family].append(pair)
    lines = [
        "| family | cases | right, PCA | right, skeleton | RMS / oracle, median, PCA | skeleton "
        "| RMS skeleton / PCA, median | 90 % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, group in {**groups, "all": list(pairs)}.items():
        good = [pair for pair in group if pair[0].flags and pair[1].flags]
        medians = (f"{np.median([pair[k].ratio for pair in good] or [np.nan]):.2f}" for k in (0, 1))
        median, high = np.quantile(_ratios(group), [0.5, 0.9])
        lines.append(
            f"| {name} | {len(group)} | {_right(group, 0):.1%} | {_right(group, 1):.1%} "
            f"| {' | '.join(medians)} | {median:.2f} | {high:.2f} |"
        )
    return lines


def _right(pairs: Sequence[Pair], which: int) -> float:
    return float(np.mean([pair[which].topology for pair in pairs]))


def _ratios(pairs: Sequence[Pair]) -> list[float]:
    return [own.rms / pca.rms for pca, own in pairs if pca.flags and own.flags] or [float("nan")]


def _goals(pairs: Sequence[Pair]) -> list[Goal]:
    rate = _right(pairs, 1) / _right(pairs, 0)
    error = float(np.median(_ratios(pairs)))
    return [
        Goal("no crossings: cases right, skeleton / PCA", rate, 1.0 - WITHIN, shown=".3f"),
        Goal("no crossings: RMS skeleton / PCA, median", error, 1.0 + WITHIN, True, ".3f"),
    ]
