"""The skeleton on curves that cross, and the readings that its crossings allow."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from benchmarks.accuracy import KEYS, READINGS, crossing_families
from benchmarks.cases import Case, Row, cases, measure_all
from benchmarks.goals import Goal
from core.truth import Reading, family, point_set
from core.truth.intersections import crossings
from core.truth.junctions import TOUCH, apart, diagonal

__all__ = ["SIZES", "least_angle", "report"]

SIZES = (1000, 5000, 20000)
STEEP = 40.0  # degrees: flatter crossings are beyond the goals
THROUGH, OTHERWISE, RATIO = 0.97, 0.95, 1.3  # the goals

_ABOUT = (
    "Curves that cross themselves or each other, end on one another, or meet in three, reconstructed by the "
    "skeleton without a single parameter. Crossings too: right curves and flags, and the true number of "
    "crossings; cover too: each curve also covers its own true curve. Errors are of the cases with right "
    "curves and flags. The least angle is that of the flattest crossing; families without one have junctions."
)
_ABOUT_READINGS = (
    "A crossing of closed curves can be read in three ways: straight through, as closed curves that touch "
    "(`split`), or as one closed curve with wasp waists (`waist`). The share of cases with the right number "
    "of curves, all closed, and the right number of crossings, which is none but for `through`; in brackets "
    "those whose curves also cover the truth."
)
Rows = dict[Reading, list[Row]]


def report(
    sizes: Sequence[int], sigmas: Sequence[float], seeds: int, jobs: int
) -> tuple[list[str], list[Goal]]:
    """Measure built-in families and those held out; return the lines and the figures to reach."""
    own, other = (_measured(held_out, sizes, sigmas, seeds, jobs) for held_out in (False, True))
    lines = ["### Curves that cross, read straight through", "", _ABOUT, ""]
    for title, rows in (
        ("Built-in families", own),
        ("Families held out: no constant was tuned with them", other),
    ):
        lines += [f"#### {title}", "", *_tables(rows["through"])]
    lines += ["### The three readings of closed curves", "", _ABOUT_READINGS, ""]
    lines += [*_readings(own, other), ""]
    return lines, [*_goals(own, "built in"), *_goals(other, "held out")]


def _measured(held_out: bool, sizes: Sequence[int], sigmas: Sequence[float], seeds: int, jobs: int) -> Rows:
    return {
        reading: list(
            measure_all(
                cases(crossing_families(held_out, reading), sizes, sigmas, seeds, "skeleton", reading), jobs
            )
        )
        for reading in READINGS
    }


def least_angle(case: Case) -> float:
    """Return the angle in degrees of the flattest crossing of the exact curves, infinite without any."""
    return _least_angle(case.family, case.seed if family(case.family).varies else 0)


@lru_cache(maxsize=256)
def _least_angle(name: str, seed: int) -> float:
    truth = point_set(name, n=1, seed=seed)
    lines = [(one.vertices, one.closed) for one in truth.curves]
    found = crossings(lines)
    found = found.only(apart(found.locations, truth.junctions, TOUCH * diagonal(lines)))
    least = np.inf
    for pair, positions in zip(found.curves, found.positions, strict=True):
        one, other = (
            truth.curves[k].exact.tangent(
                truth.curves[k].exact.parameter([at / (len(lines[k][0]) - (not lines[k][1]))])
            )[0]
            for k, at in zip(pair, positions, strict=True)
        )
        least = min(least, float(np.degrees(np.arccos(min(abs(one @ other), 1.0)))))
    return least


def _grouped(rows: Sequence[Row], key: Callable[[Case], object]) -> dict[object, list[Row]]:
    groups: dict[object, list[Row]] = defaultdict(list)
    for row in rows:
        groups[key(row.case)].append(row)
    return groups


def _tables(rows: Sequence[Row]) -> list[str]:
    lines = []
    for title, key in KEYS.items():
        angles = title == "family"
        lines += [
            f"| {title} |{' least angle |' if angles else ''} cases | curves and flags right | crossings too "
            "| cover too | RMS / oracle, median | 90 % |",
            "|---|---|---|---|---|---|---|" + ("---|" if angles else ""),
        ]
        for name, group in _grouped(rows, key).items():
            angle = f" {_angle(group)} |" if angles else ""
            lines.append(f"| {name} |{angle} {len(group)} | {_cells(group)} |")
        lines.append("")
    return lines


def _angle(rows: Sequence[Row]) -> str:
    least = min(least_angle(row.case) for row in rows)
    return f"{least:.0f}°" if np.isfinite(least) else ""


def _cells(rows: Sequence[Row]) -> str:
    ratios = [row.ratio for row in rows if row.flags] or [np.nan]
    median, high = np.quantile(ratios, [0.5, 0.9])
    rates = (np.mean([getattr(row, name) for row in rows]) for name in ("flags", "right", "topology"))
    return " | ".join([*(f"{rate:.1%}" for rate in rates), f"{median:.2f}", f"{high:.2f}"])


def _readings(own: Rows, other: Rows) -> list[str]:
    lines = ["| family | cases each | through | split | waist |", "|---|---|---|---|---|"]
    for title, rows in (("built in", own), ("held out", other)):
        closed = {row.case.family for row in rows["split"]}
        groups = [_grouped([r for r in rows[one] if r.case.family in closed], _family) for one in READINGS]
        lines += [_line(str(name), [group[name] for group in groups]) for name in groups[0]]
        every = [[row for part in group.values() for row in part] for group in groups]
        lines.append(_line(f"all {title}", every))
    return lines


def _family(case: Case) -> str:
    return case.family


def _line(title: str, groups: Sequence[Sequence[Row]]) -> str:
    cells = (
        f"{np.mean([row.right for row in rows]):.1%} ({np.mean([row.topology for row in rows]):.1%})"
        for rows in groups
    )
    return f"| {title} | {len(groups[0])} | {' | '.join(cells)} |"


def _goals(rows: Rows, title: str) -> list[Goal]:
    """The goals are for crossings of 40 degrees and more."""
    steep = {reading: [r for r in rows[reading] if least_angle(r.case) >= STEEP] for reading in READINGS}
    goals = [
        Goal(
            f"curves, flags and crossings right, `{reading}`, {title}",
            float(np.mean([row.right for row in steep[reading]])),
            THROUGH if reading == "through" else OTHERWISE,
        )
        for reading in READINGS
    ]
    ratio = float(np.median([row.ratio for row in steep["through"] if row.flags] or [np.nan]))
    return [*goals, Goal(f"RMS / oracle, median, `through`, {title}", ratio, RATIO, True, ".2f")]
