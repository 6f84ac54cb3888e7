"""The figures that the page shows of the rows: rates, medians, and where a peer is better."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.peers.contestants import CONTESTANTS, Contestant
from benchmarks.peers.rows import Row
from benchmarks.peers.sets import Plan, group_of

__all__ = ["Figures", "better", "by_n", "by_sigma", "common", "present", "where"]

ENOUGH = 0.02  # a share or a relative difference below that is no difference


@dataclass(frozen=True, slots=True)
class Figures:
    """A contestant's figures over some sets; NaN where there is nothing to tell.

    ``ratio`` and ``high`` are the median and the 90 % quantile of RMS / oracle over sets with the right
    topology, ``ratio_all`` the median over all sets, those without an answer counting as infinite;
    ``maximum`` is the median largest error in sigma, and ``seconds`` the median time, over answers.
    """

    sets: int
    silent: int
    late: int
    flags: float
    topology: float
    ratio: float
    high: float
    ratio_all: float
    maximum: float
    seconds: float

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Figures:
        """Sum up rows of one contestant."""
        answered = [row for row in rows if not row.problem]
        right = [row.ratio for row in answered if row.topology]
        every = [np.inf if row.problem else row.ratio for row in rows]
        return cls(
            len(rows),
            len(rows) - len(answered),
            sum(row.problem == "time limit" for row in rows),
            float(np.mean([row.flags for row in rows])) if rows else np.nan,
            float(np.mean([row.topology for row in rows])) if rows else np.nan,
            _quantile(right, 0.5),
            _quantile(right, 0.9),
            _quantile(every, 0.5),
            _quantile([row.maximum for row in answered], 0.5),
            _quantile([row.seconds for row in answered], 0.5),
        )

    @staticmethod
    def median(values: Sequence[float]) -> float:
        """Return the median, one of the values, so that infinite ones do no harm; NaN is infinite."""
        return _quantile([np.inf if np.isnan(value) else value for value in values], 0.5)


def _quantile(values: Sequence[float], share: float) -> float:
    """A quantile that is one of the values, so that infinite ones do no harm."""
    return float(np.quantile(values, share, method="inverted_cdf")) if len(values) else float("nan")


def present(rows: Sequence[Row]) -> list[Contestant]:
    """Return who has been measured."""
    names = {row.contestant for row in rows}
    return [one for one in CONTESTANTS if one.name in names]


def common(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of sets on which every contestant has been measured, and all of the sweep over time."""
    measured: dict[object, set[str]] = {}
    for row in rows:
        if not row.timed:
            measured.setdefault(row.set, set()).add(row.contestant)
    every = set().union(*measured.values())
    return [row for row in rows if row.timed or measured[row.set] == every]


def where(rows: Sequence[Row], contestant: Contestant, keep: Callable[[Row], bool]) -> list[Row]:
    """Return a contestant's rows that are not of the sweep over time and that are to be kept."""
    return [row for row in rows if row.contestant == contestant.name and not row.timed and keep(row)]


def by_n(plan: Plan) -> dict[int, Callable[[Row], bool]]:
    """Return which rows belong to each size of the sweep over N."""
    return {n: (lambda row, n=n: row.n == n and row.sigma == plan.sigma) for n in plan.sizes}  # type: ignore[misc]


def by_sigma(plan: Plan) -> dict[float, Callable[[Row], bool]]:
    """Return which rows belong to each noise of the sweep over sigma."""
    return {s: (lambda row, s=s: row.sigma == s and row.n == plan.n) for s in plan.sigmas}  # type: ignore[misc]


def better(rows: Sequence[Row], plan: Plan, own: str) -> list[str]:
    """Return a line for each group, size and noise where a peer has a better figure than method ``own``."""
    cells: dict[str, Callable[[Row], bool]] = {
        f"{group} curves" if group in ("open", "closed", "several") else group: (
            lambda row, group=group: group_of(row.family) == group  # type: ignore[misc]
        )
        for group in dict.fromkeys(group_of(name) for name in plan.families)
    }
    cells |= {f"N = {n:,}": keep for n, keep in by_n(plan).items()}
    cells |= {f"σ = {sigma:.2%}": keep for sigma, keep in by_sigma(plan).items()}
    us = next(one for one in CONTESTANTS if one.name == own)
    lines = []
    for title, keep in cells.items():
        mine = Figures.of(where(rows, us, keep))
        words = [
            word
            for peer in present(rows)
            if not peer.own
            for word in _better(peer.title, Figures.of(where(rows, peer, keep)), mine)
        ]
        if words:
            lines.append(f"- {title}: {'; '.join(words)}.")
    return lines


def _better(title: str, theirs: Figures, mine: Figures) -> list[str]:
    words = []
    if theirs.topology > mine.topology + ENOUGH:
        words.append(
            f"{title} has the right topology in {theirs.topology:.0%} of the sets, not {mine.topology:.0%}"
        )
    pairs = {"where right": (theirs.ratio, mine.ratio), "over all sets": (theirs.ratio_all, mine.ratio_all)}
    errors = [f"{a:.2f} against {b:.2f} {name}" for name, (a, b) in pairs.items() if a < b * (1 - ENOUGH)]
    if errors:
        words.append(f"{title} has the smaller median RMS / oracle, {' and '.join(errors)}")
    return words
