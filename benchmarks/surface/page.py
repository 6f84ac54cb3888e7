"""docs/surface.md, written from the rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks import goals
from benchmarks.goals import Goal
from benchmarks.peers.page import Origin
from benchmarks.surface.completion import KINDS, SHARES
from benchmarks.surface.judging import SAMPLES
from benchmarks.surface.meshes import UPRIGHT
from benchmarks.surface.poisson import DEPTH
from benchmarks.surface.programs import NEAREST, OPEN3D, TAPELINE
from benchmarks.surface.rows import CompletionRow, MeshRow, Rows, StackRow, by_name
from core.truth import Scanner

__all__ = ["HEADS", "reached", "tables", "write"]

HEADS = {
    "solids": "| object | program | parts | genus | closed manifold | cuts itself | RMS | 95 % | largest "
    "| CPU s |",
    "stages": "| object | points | triangles, slices | contours | surface | report | completed levels |",
    "scans": "| scans | program | parts | genus | closed manifold | cuts itself | RMS, points to mesh "
    "| CPU s | clock s, two processes |",
    "slicing": "| way | triangles | planes | CPU s | of section_multiplane |",
    "stacks": "| stacks | closed manifolds | by distances | nothing enclosed | errors | CPU s, median "
    "| longest |",
    "completion": "| damage | levels | told as completed | as many loops as in truth | RMS | neighbours' "
    "| ratio, median | 90 % | within 1.5 | of all |",
}
BOUND = 1.5  # of the neighbours' error
SLICING = 0.2  # of trimesh's time
BUSY = 1.2  # seconds by the clock for a CPU second
WAIT = 60.0  # seconds by the clock for a real object

_INTRO = """# From scans to surfaces: figures

Written by `make bench-surface` in {minutes:.0f} minutes. `/reconstruct/surface` from its scans to its \
closed mesh, beside Open3D's Poisson reconstruction (Kazhdan and others, 2006) of the same points; \
`/slice` beside trimesh; and what has no peer: random stacks of contours, and levels completed from their \
neighbours.

Machine: {machine}; Python {python}. Tapeline's environment: {own}; peers: {peers}. Each program runs in a \
process of its own, on one core, without waiting for compilers; times are CPU seconds unless said \
otherwise."""

_ABOUT_SOLIDS = """[core/truth](../core/truth) has solids as implicit functions, about 100 units across, \
and a virtual scanner: {views} views of {pixels} × {pixels} pixels with noise of σ = {noise} along the \
rays. {levels} levels; no other parameter is given.

Open3D is at its best here: it gets the points that the triangles of the range images use, and at each the \
normal of the plane through the {nearest} nearest points of all scans, on the side that the scanner saw; \
estimating them costs it nothing. Depth {depth}, one thread.

*RMS*, *95 %*, *largest*: distances both ways, from {samples} random places of the mesh to the implicit \
surface and from as many places of the surface to the mesh, in units of the solid. *Cuts itself*: pairs of \
faces that have a point in common, but no vertex."""

_ABOUT_STAGES = "Where Tapeline's CPU seconds go:"

_ABOUT_SCANS = """Stanford range grids with the poses of their `.conf` file, {levels} levels across {axis}; \
not part of the project: `make bench-surface ARGS="--scans FOLDER"` reads any folder of them. The distance \
is that from the scan points to the mesh, in 10⁻³ of the files' unit (metres for the bunny, hence \
millimetres). Registered scans lie beside each other by more than their noise, so that no surface comes \
nearer than that to all of them."""

_ABOUT_SLICING = """A tilted torus. Tapeline links segments to polylines, as `section_multiplane` does; \
`mesh_multiplane` leaves them loose. The least of three times."""

_ABOUT_STACKS = """[core/truth](../core/truth)'s random stacks: overlaps, holes, islands, shared edges, \
contours that cross themselves, empty levels, uneven heights. *Closed manifold*: every edge has two faces, \
every vertex one fan, no face cuts another, the volume is positive. *By distances*: slabs failed, signed \
distances were used instead."""

_ABOUT_COMPLETION = """Of scans as above ({levels} levels; {names}), levels are damaged: {low:.0%} to \
{high:.0%} of a contour's length lose their samples, or the whole level does, for one, two or three levels \
in a row. Errors are RMS distances in the plane, both ways, to the true contour; the ratio is to the RMS \
of the two levels around the damage. *Of all*: the RMS over all such levels, over that of all neighbours; \
a few bad levels count most there."""

_NOTE = """Open3D is no dependency of Tapeline: it is installed from a lock file of its own, with hashes, \
into `build/surface`, which git ignores, and needs Debian's `libusb-1.0-0` and `libgl1`. `make \
bench-surface ARGS=--quick` prints small tables; `ARGS=--without-open3d` leaves it out."""


def write(rows: Rows, origin: Origin, folder: Path) -> Path:
    """Write the page; return it."""
    folder.mkdir(parents=True, exist_ok=True)
    intro = _INTRO.format(
        minutes=max(1.0, origin.seconds / 60),
        machine=origin.machine,
        python=rows.versions.get("own Python", "?"),
        own=_versions(origin.own),
        peers=_versions({name: one for name, one in rows.versions.items() if name != "own Python"}),
    )
    page = folder / "surface.md"
    page.write_text("\n".join([intro + _busy(rows.solids), "", *tables(rows), _NOTE, ""]))
    return page


def _busy(rows: Sequence[MeshRow]) -> str:
    """Say so where others were at work on the machine, which costs both programs CPU time as well."""
    waited = [row.clock / row.cpu for row in rows if not row.problem]
    if not waited or (typical := float(np.median(waited))) < BUSY:
        return ""
    return f" The machine was busy with other work: a CPU second took {typical:.1f} seconds by the clock."


def tables(rows: Rows) -> list[str]:
    """Return what was measured; parts that were not are left out."""
    return [
        *_section("Figures to reach", "", goals.table(reached(rows)) if reached(rows) else []),
        *_solids(rows.solids),
        *_scans(rows.scans),
        *_slicing(rows),
        *_stacks(rows),
        *_completion(rows.completion),
    ]


def reached(rows: Rows) -> list[Goal]:
    """Return the figures to reach of the parts that were measured."""
    return [
        *_goals_of_solids(rows.solids),
        *_goals_of_scans(rows.scans),
        *_goals_of_the_rest(rows),
    ]


def _goals_of_solids(rows: Sequence[MeshRow]) -> list[Goal]:
    own, other = by_name(rows, TAPELINE), by_name(rows, OPEN3D)
    if not own:
        return []
    found = [
        Goal("virtual scans: right genus and parts", _share([one.right for one in own.values()]), 1.0),
        Goal("virtual scans: closed manifolds", _share([one.sound for one in own.values()]), 1.0),
    ]
    pairs = [(one, other[name]) for name, one in own.items() if name in other and not other[name].problem]
    if pairs:
        worst = max(one.rms / beside.rms for one, beside in pairs)
        slowest = max(one.cpu / beside.cpu for one, beside in pairs)
        found += [
            Goal("virtual scans: RMS over Open3D's, the worst", worst, 1.0, at_most=True, shown=".2f"),
            Goal("virtual scans: CPU time over Open3D's, the worst", slowest, 1.0, at_most=True, shown=".2f"),
        ]
    return found


def _goals_of_scans(rows: Sequence[MeshRow]) -> list[Goal]:
    other = by_name(rows, OPEN3D)
    found = []
    for name, one in by_name(rows, TAPELINE).items():
        found += [
            Goal(f"{name}: one part of genus 0", float(one.right and one.sound), 1.0, shown=".0f"),
            Goal(
                f"{name}: seconds by the clock, two processes", one.together, WAIT, at_most=True, shown=".1f"
            ),
        ]
        if name in other and not other[name].problem:
            ratio = one.rms / other[name].rms
            found.append(Goal(f"{name}: RMS over Open3D's", ratio, 1.0, at_most=True, shown=".2f"))
    return found


def _goals_of_the_rest(rows: Rows) -> list[Goal]:
    found = [
        Goal(f"{one.stacks:,} random stacks: closed manifolds", _sound(one), 1.0, shown=".2%")
        for one in rows.stacks
    ]
    if rows.slicing:
        ratio = rows.slicing[0].seconds / rows.slicing[1].seconds
        found.append(Goal("slicing: time over trimesh's", ratio, SLICING, at_most=True, shown=".2f"))
    if rows.completion:
        whole = "completed levels: RMS over their neighbours', of all"
        found.append(Goal(whole, _ratio(rows.completion), BOUND, at_most=True, shown=".2f"))
        typical = "completed levels: the same, median"
        found.append(
            Goal(typical, float(np.median(_ratios(rows.completion))), BOUND, at_most=True, shown=".2f")
        )
    return found


def _solids(rows: Sequence[MeshRow]) -> list[str]:
    if not rows:
        return []
    scanner = Scanner()
    about = _ABOUT_SOLIDS.format(
        views=scanner.views,
        pixels=scanner.pixels,
        noise=scanner.noise,
        levels=rows[0].levels,
        nearest=NEAREST,
        depth=DEPTH,
        samples=f"{SAMPLES:,}",
    )
    lines = [HEADS["solids"], _rule(10)]
    for row in rows:
        what = f"{row.name} ({row.true_components}, {row.true_genus})"
        lines.append(
            _cells(what, *_topology(row), *_lengths(row.rms, row.high, row.largest), f"{row.cpu:.1f}")
        )
    lines += ["", "In brackets: parts and genus in truth.", "", _ABOUT_STAGES, "", HEADS["stages"], _rule(7)]
    lines += [_stages(row) for row in by_name(rows, TAPELINE).values() if row.stages]
    return _section("Scans with known truth", about, lines)


def _stages(row: MeshRow) -> str:
    return _cells(row.name, f"{row.points:,}", *(f"{one:.2f}" for one in row.stages), str(row.completed))


def _topology(row: MeshRow) -> list[str]:
    if row.problem:
        return [row.program, row.problem, "–", "–", "–"]
    sound = "yes" if row.sound else "no"
    by = " (distances)" if row.method == "distance" else ""
    return [row.program + by, str(row.components), str(row.genus), sound, str(row.self_intersections)]


def _scans(rows: Sequence[MeshRow]) -> list[str]:
    if not rows:
        return []
    lines = [HEADS["scans"], _rule(9)]
    for row in rows:
        together = f"{row.together:.1f}" if row.together else "–"
        lines.append(_cells(row.name, *_topology(row), *_lengths(1e3 * row.rms), f"{row.cpu:.1f}", together))
    return _section("Real scans", _ABOUT_SCANS.format(levels=rows[0].levels, axis=UPRIGHT), lines)


def _slicing(rows: Rows) -> list[str]:
    lines = [HEADS["slicing"], _rule(5)]
    lines += [
        _cells(
            one.way,
            f"{one.triangles:,}",
            str(one.planes),
            f"{one.seconds:.2f}",
            f"{one.seconds / rows.slicing[1].seconds:.2f}",
        )
        for one in rows.slicing
    ]
    return _section("Slicing", _ABOUT_SLICING, lines) if rows.slicing else []


def _stacks(rows: Rows) -> list[str]:
    lines = [HEADS["stacks"], _rule(7)]
    for one in rows.stacks:
        counts = (one.stacks, one.sound, one.fallbacks, one.empty, one.failures)
        lines.append(_cells(*(f"{count:,}" for count in counts), f"{one.median:.3f}", f"{one.longest:.2f}"))
        if one.wrong:
            lines += ["", f"Not closed manifolds: the seeds {', '.join(map(str, one.wrong[:20]))}."]
    return _section("Random stacks", _ABOUT_STACKS, lines) if rows.stacks else []


def _completion(rows: Sequence[CompletionRow]) -> list[str]:
    if not rows:
        return []
    names = ", ".join(dict.fromkeys(row.name for row in rows))
    lines = [HEADS["completion"], _rule(10)]
    for kind in [*(one.kind for one in KINDS), "all"]:
        some = [row for row in rows if kind in {row.kind, "all"}]
        if some:
            lines.append(_completed(kind, some))
    about = _ABOUT_COMPLETION.format(levels=rows[0].levels, names=names, low=SHARES[0], high=SHARES[1])
    return _section("Completed levels", about, lines)


def _completed(kind: str, rows: Sequence[CompletionRow]) -> str:
    ratios = _ratios(rows)
    return _cells(
        kind,
        str(len(rows)),
        f"{_share([row.told for row in rows]):.0%}",
        f"{_share([row.right for row in rows]):.0%}",
        *_lengths(_mean([row.rms for row in rows]), _mean([row.neighbours for row in rows])),
        *(f"{one:.2f}" for one in np.quantile(ratios, (0.5, 0.9))),
        f"{_share([one <= BOUND for one in ratios]):.0%}",
        f"{_ratio(rows):.2f}",
    )


def _ratios(rows: Sequence[CompletionRow]) -> list[float]:
    return [row.rms / row.neighbours for row in rows]


def _ratio(rows: Sequence[CompletionRow]) -> float:
    return _mean([row.rms for row in rows]) / _mean([row.neighbours for row in rows])


def _mean(values: Sequence[float]) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def _sound(row: StackRow) -> float:
    """Return the share of closed manifolds, of stacks that enclose anything."""
    return row.sound / max(row.stacks - row.empty, 1)


def _share(flags: Sequence[bool]) -> float:
    return float(np.mean(flags))


def _lengths(*values: float) -> list[str]:
    return [f"{one:.3f}" if one < 10.0 else f"{one:.1f}" for one in values]


def _section(title: str, about: str, lines: Sequence[str]) -> list[str]:
    if not lines:
        return []
    return [f"## {title}", "", *([about, ""] if about else []), *lines, ""]


def _cells(*texts: str) -> str:
    return "| " + " | ".join(texts) + " |"


def _rule(columns: int) -> str:
    return "|" + "---|" * columns


def _versions(known: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {one}" for name, one in known.items())
