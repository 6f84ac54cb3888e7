"""docs/peers.md, written from the rows."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.peers import pictures
from benchmarks.peers.choice import LIMITS, TOLERANCES
from benchmarks.peers.contestants import Contestant
from benchmarks.peers.measuring import LIMIT
from benchmarks.peers.rows import Row
from benchmarks.peers.sets import GROUPS, Plan
from benchmarks.peers.summary import Figures, better, by_n, by_sigma, common, present, where
from benchmarks.peers.told import FEW
from core.truth import held_out_names

__all__ = ["HEADS", "Origin", "tables", "write"]

HEADS = {
    "summary": "| | sets | no answer | curves and flags right | topology right | RMS / oracle, median | 90 % "
    "| of all sets | largest error | CPU s |",
    "time": "| CPU s over N |",
    "families": "| family |",
}

Keep = Callable[[Row], bool]

_INTRO = """# Beside other programs

Written by `make bench-peers` in {minutes:.0f} minutes. Tapeline, without a single parameter, beside \
programs of the package index and of Debian that make curves of noisy points. All are measured with \
the project's own truth: [core/truth](../core/truth) draws the samples and knows the curves.

Every peer has help that Tapeline has not:

- It is told the noise σ, the number of samples and the length of the curves, and sets itself by \
them: below is how.
- It runs once for each setting of a small grid, and the best answer counts: the right topology \
first, then the least error, judged by the truth. An oracle of parameters, which no user has.
- Programs that answer with a graph get it read: spurs, bridges between forks and gaps between loose \
ends shorter than {limits} σ are none, and curves go straight on at forks. All answers are also \
tried as smoothing splines whose vertices move by {tolerances} σ. Again the best by the truth \
counts.
- † Programs that know one curve only are told which samples belong to which curve, and which \
curves are closed, pcurvepy2 even a coarse polygon of each: their rates say only whether curves so \
begun cover the truth and cross as it does.
- Of sets with more samples than {few:,}, slow programs get the first {few:,}; the error is still \
measured against the oracle that has them all.
- Its time is that of the best setting alone; reading graphs and smoothing are free.

Each runs in a process of its own, on one core; a setting that takes longer than {limit:.0f} s by the \
clock, or more than 12 GB of memory, is no answer."""

_MEANING = """## What the figures mean

- *Curves and flags right*: as many curves as in truth, each open or closed as in truth. *Topology \
right*: that, each true curve covered by its own curve within 3 σ over 95 % of both, and as many \
crossings as in truth.
- *RMS / oracle*: the RMS distance from the true curves to the result, over that of the oracle, a \
local quadratic regression that is told each sample's place along its curve and the best bandwidth. \
Median and 90 % quantile over the sets whose topology is right; then the median over all sets, where \
no answer counts as infinite.
- *Largest error*: the largest distance between truth and result, in σ, both ways; the median over \
answered sets.
- *CPU s*: seconds of one core, the median over answered sets; imports and compiling are not \
counted.
- A peer's RMS / oracle is of those sets that it got right, often the easier ones: read it beside \
the rate."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where and with what the rows were measured."""

    machine: str
    versions: Mapping[str, str]
    own: Mapping[str, str]
    seeds: int
    seconds: float

    @classmethod
    def here(cls, versions: Mapping[str, str], program: Path | None, seeds: int, seconds: float) -> Origin:
        """Describe this machine and these environments."""
        known = dict(versions)
        if program is not None:
            known["CGAL"] = subprocess.check_output([str(program)], text=True).strip()  # noqa: S603 - our own
        cpu = next(
            (line.split(":")[1].strip() for line in _cpuinfo() if line.startswith("model name")),
            platform.machine(),
        )
        own = {name: importlib.metadata.version(name) for name in ("numpy", "scipy", "numba", "shapely")}
        return cls(f"{cpu}, {platform.system()}", known, own, seeds, seconds)


def _cpuinfo() -> list[str]:
    file = Path("/proc/cpuinfo")
    return file.read_text().splitlines() if file.exists() else []


def write(rows: Sequence[Row], plan: Plan, origin: Origin, folder: Path) -> Path:
    """Write the page and its figures; return the page."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures.draw(common(rows), plan, folder / "figures")
    lines = [
        _INTRO.format(
            minutes=max(1, origin.seconds / 60),
            limits=_list(LIMITS),
            tolerances=_list(TOLERANCES),
            few=FEW,
            limit=LIMIT,
        ),
        "",
        _machine(origin),
        "",
        *tables(rows, plan),
        *_settings(rows, origin),
        "",
    ]
    page = folder / "peers.md"
    page.write_text("\n".join(lines))
    return page


def tables(rows: Sequence[Row], plan: Plan) -> list[str]:
    """Return all tables and pictures, with what they mean, over the sets that all were measured on."""
    rows = common(rows)
    return [
        *_summary(rows, plan),
        _MEANING,
        "",
        *_rules(rows),
        *_better(rows, plan),
        *_grids(rows, plan),
        *_times(rows, plan),
        *_families(rows, plan),
    ]


def _machine(origin: Origin) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in origin.own.items())
    return (
        f"Machine: {origin.machine}; Python {platform.python_version()}. Tapeline's environment: {versions}. "
        f"{origin.seeds} {'seed' if origin.seeds == 1 else 'seeds'} of each kind of set."
    )


def _summary(rows: Sequence[Row], plan: Plan) -> list[str]:
    held_out = [name for name in plan.families if name in held_out_names()]
    return [
        "## All sets",
        "",
        f"{len(plan.families)} families in the plane, N = {_list(plan.sizes)} at σ = {plan.sigma:.0%} "
        f"of the diagonal, and σ = {', '.join(f'{s:.2%}' for s in plan.sigmas)} at N = {plan.n:,}: "
        f"{len({row.set for row in rows if not row.timed})} sets, on which all were measured.",
        "",
        *_summary_table(rows, lambda _: True),
        "",
        f"Only the families held out, with which no constant of Tapeline was chosen ({', '.join(held_out)}):",
        "",
        *_summary_table(rows, lambda row: row.family in held_out),
        "",
    ]


def _summary_table(rows: Sequence[Row], keep: Keep) -> list[str]:
    lines = [HEADS["summary"], _rule(10)]
    for one in present(rows):
        got = Figures.of(where(rows, one, keep))
        lines.append(
            f"| {one.title} | {got.sets} | {got.silent} | {_share(got.flags)} | {_share(got.topology)} "
            f"| {_number(got.ratio)} | {_number(got.high)} | {_number(got.ratio_all)} "
            f"| {_number(got.maximum, 1)} σ | {_seconds(got.seconds)} |"
        )
    return lines


def _rules(rows: Sequence[Row]) -> list[str]:
    lines = [
        "## One rule instead of the best setting",
        "",
        "The same answers, but one setting and one reading for all sets, fixed beforehand; still told σ, N "
        "and the length, and what belongs to which curve.",
        "",
        "| | rule | topology right | RMS / oracle, median of all sets |",
        _rule(4),
    ]
    for one in present(rows):
        mine = where(rows, one, lambda _: True)
        right = float(np.mean([row.rule_topology for row in mine]))
        ratio = Figures.median([row.rule_ratio for row in mine])
        lines.append(f"| {one.title} | {one.rule_about} | {_share(right)} | {_number(ratio)} |")
    return [*lines, ""]


def _better(rows: Sequence[Row], plan: Plan) -> list[str]:
    owns = [one for one in present(rows) if one.own]
    if not owns:
        return []
    lines = ["## Where a peer is better", ""]
    found = better(rows, plan, owns[0].name)
    if not found:
        lines += [f"Nowhere in the groups, sizes and noises below, beside {owns[0].title}."]
    else:
        lines += [f"Beside {owns[0].title}, in these groups, sizes and noises:", "", *found]
    faster = [
        one.title
        for one in present(rows)
        if not one.own and _median_time(rows, one) < _median_time(rows, owns[0])
    ]
    if faster:
        lines += ["", f"Faster in the median, for the one setting that is best: {', '.join(faster)}."]
    return [*lines, ""]


def _median_time(rows: Sequence[Row], one: Contestant) -> float:
    return Figures.of(where(rows, one, lambda _: True)).seconds


def _grids(rows: Sequence[Row], plan: Plan) -> list[str]:
    groups = {g: [name for name in names if name in plan.families] for g, names in GROUPS.items()}
    kinds: dict[str, Keep] = {
        f"{group} ({', '.join(names)})": (lambda row, names=names: row.family in names)  # type: ignore[misc]
        for group, names in groups.items()
        if names
    }
    sizes = {f"{n:,}": keep for n, keep in by_n(plan).items()}
    noises = {f"{sigma:.2%}": keep for sigma, keep in by_sigma(plan).items()}
    return [
        "## By kind of curve, size and noise",
        "",
        "In each cell the share of sets with the right topology, and the median RMS / oracle of those.",
        "",
        *_grid(rows, "kind of curve", kinds),
        "",
        f"At σ = {plan.sigma:.0%}:",
        "",
        *_grid(rows, "N", sizes),
        "",
        f"![RMS error over N](figures/{pictures.ERROR})",
        "",
        f"At N = {plan.n:,}:",
        "",
        *_grid(rows, "σ", noises),
        "",
        f"![Right topology over σ](figures/{pictures.SUCCESS})",
        "",
    ]


def _grid(rows: Sequence[Row], title: str, cells: Mapping[str, Keep]) -> list[str]:
    columns = present(rows)
    lines = [f"| {title} | {' | '.join(one.title for one in columns)} |", _rule(len(columns) + 1)]
    for name, keep in cells.items():
        lines.append(f"| {name} | {' | '.join(_cell(where(rows, one, keep)) for one in columns)} |")
    return lines


def _cell(rows: Sequence[Row]) -> str:
    got = Figures.of(rows)
    if not got.sets:
        return ""
    if got.silent == got.sets:
        return "no answer" if got.late < got.sets else f"> {LIMIT:.0f} s"
    return _share(got.topology) + (f" · {_number(got.ratio)}" if got.topology else "")


def _times(rows: Sequence[Row], plan: Plan) -> list[str]:
    timed = [row for row in rows if row.timed]
    lines = [
        "## Time",
        "",
        f"An open S with σ = {plan.sigma:.0%}, every sample used, one setting: the one that is best at"
        f" N = {plan.timed[0]:,}. CPU seconds of one core; who does not answer in time is not asked "
        "for more.",
        "",
        f"{HEADS['time']} {' | '.join(f'{n:,}' for n in plan.timed)} |",
        _rule(len(plan.timed) + 1),
    ]
    for one in present(timed):
        known = {row.n: row for row in timed if row.contestant == one.name}
        cells = [_time_cell(known.get(n)) for n in plan.timed]
        lines.append(f"| {one.title} | {' | '.join(cells)} |")
    return [*lines, "", f"![Time over N](figures/{pictures.TIME})", ""]


def _time_cell(row: Row | None) -> str:
    if row is None:
        return "–"
    if row.problem:
        return f"> {LIMIT:.0f}" if row.problem == "time limit" else "failed"
    return _seconds(row.seconds)


def _families(rows: Sequence[Row], plan: Plan) -> list[str]:
    columns = present(rows)
    lines = [
        "## By family",
        "",
        "As above, over all sizes and noises; * is a family held out.",
        "",
        f"{HEADS['families']} {' | '.join(one.title for one in columns)} |",
        _rule(len(columns) + 1),
    ]
    for name in plan.families:
        star = "*" if name in held_out_names() else ""
        cells = [_cell(where(rows, one, lambda row, name=name: row.family == name)) for one in columns]  # type: ignore[misc]
        lines.append(f"| {name}{star} | {' | '.join(cells)} |")
    return [*lines, ""]


def _settings(rows: Sequence[Row], origin: Origin) -> list[str]:
    lines = ["## How each was set", "", "| program | version | licence | settings |", "|---|---|---|---|"]
    for one in present(rows):
        if not one.own:
            names = one.packages or ("CGAL",)
            version = ", ".join(origin.versions.get(name, "not known") for name in names)
            lines.append(f"| {one.title} | {version} | {one.licence} | {one.about} |")
    lines += [
        "",
        "None of them is a dependency of Tapeline. They are installed from a lock file of their own, "
        "with hashes, into `build/peers`, which git ignores; CGAL is Debian's libcgal-dev, compiled "
        "there. Programs under the GPL are run by this benchmark, as processes of their own, and are "
        f"no part of what is distributed. Peers' Python: {origin.versions.get('Python', 'not known')}.",
        "",
        "Not in the comparison: princurve itself, for it is a package of R (pcurvepy2 follows it); "
        "alpha shapes, which answer with an outline and not with a curve. Families in space are left "
        "out, since two of the peers know the plane only.",
    ]
    return lines


def _rule(columns: int) -> str:
    return "|" + "---|" * columns


def _list(values: Sequence[float]) -> str:
    words = [f"{value:,g}" if isinstance(value, float) else f"{value:,}" for value in values]
    return f"{', '.join(words[:-1])} or {words[-1]}" if len(words) > 1 else words[0]


def _share(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.0%}"


def _number(value: float, digits: int = 2) -> str:
    return "–" if np.isnan(value) else "∞" if np.isinf(value) else f"{value:.{digits}f}"


def _seconds(value: float) -> str:
    return (
        "–"
        if np.isnan(value)
        else f"{value:.3f}"
        if value < 0.1
        else f"{value:.2f}"
        if value < 10
        else f"{value:.0f}"
    )
