"""Measure Tapeline and its peers, and write docs/peers.md: ``python -m benchmarks.peers``."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.peers.contestants import CONTESTANTS
from benchmarks.peers.environment import FOLDER, build_transport, has_auto, make_environment, versions
from benchmarks.peers.measuring import Job, measure_all, measure_times
from benchmarks.peers.page import Origin, tables, write
from benchmarks.peers.rows import append, load
from benchmarks.peers.sets import QUICK, Plan, Set, over_n, over_sigma, over_time

__all__ = ["main"]

DOCS = Path(__file__).parent.parent.parent / "docs"


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the environment, measure, and write the page."""
    options = _options(arguments)
    plan = QUICK if options.quick else Plan()
    folder = FOLDER / "quick" if options.quick else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    file, began = folder / "rows.jsonl", time.monotonic()
    python = make_environment()
    program = build_transport()
    afresh = not (options.only or options.resume or options.page)
    if afresh:
        file.unlink(missing_ok=True)
    if not options.page:
        _measure(plan, _chosen(options.only, program), range(options.seeds), options, file)
    seconds = _taken(folder / "seconds", time.monotonic() - began, afresh=afresh)
    known = versions(python, tuple(name for one in CONTESTANTS for name in one.packages))
    rows = load(file)
    if not options.quick or options.output:
        origin = Origin.here(known, program, options.seeds, seconds)
        print(write(rows, plan, origin, options.output or DOCS))
    else:
        print("\n".join(tables(rows, plan)))


def _chosen(only: str | None, program: Path | None) -> list[str]:
    """Return who is measured: all that can be had here, or those named."""
    names = [one.name for one in CONTESTANTS if only is None or one.name in only.split(",")]
    lacking = {"auto": not has_auto(), "cgal": program is None}
    return [name for name in names if not lacking.get(name, False)]


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a few small sets; prints the tables only")
    parser.add_argument("--seeds", type=int, default=1, help="point sets of each kind")
    parser.add_argument("--jobs", type=int, default=1, help="point sets at the same time")
    parser.add_argument("--only", help="measure these contestants anew, with commas between; keep the others")
    parser.add_argument("--resume", action="store_true", help="measure only what is not measured yet")
    parser.add_argument("--page", action="store_true", help="measure nothing: write the page again")
    parser.add_argument(
        "--output", type=Path, help="the folder for the page and its figures; docs by default"
    )
    return parser.parse_args(arguments)


def _measure(
    plan: Plan, chosen: Sequence[str], seeds: Sequence[int], options: argparse.Namespace, file: Path
) -> None:
    """Measure what is asked for, and keep every row as soon as it is known."""
    known = {row.key for row in load(file)} if options.resume else set()
    sets = list(dict.fromkeys([*over_n(plan, seeds), *over_sigma(plan, seeds)]))
    sets.sort(key=lambda one: one.seed)
    jobs = [Job(one, _missing(one, chosen, known)) for one in sets]
    jobs = [job for job in jobs if job.contestants]
    began = time.monotonic()
    for k, rows in enumerate(measure_all(jobs, options.jobs)):
        append(file, rows)
        one = jobs[k].one
        print(
            f"{time.monotonic() - began:6.0f} s  {k + 1}/{len(jobs)}  {one.family} n={one.n} σ={one.sigma:g}",
            file=sys.stderr,
        )
    timed = over_time(plan)
    left = [name for name in chosen if not any(key[0] == name and key[-1] for key in known)]
    for row in measure_times(timed, left):
        append(file, [row])
        print(f"{row.contestant} n={row.n}: {row.problem or f'{row.seconds:.2f} s'}", file=sys.stderr)


def _taken(file: Path, seconds: float, *, afresh: bool) -> float:
    """Add to the time that the rows took so far, or begin anew; return the sum."""
    before = float(file.read_text()) if file.exists() and not afresh else 0.0
    file.write_text(f"{before + seconds:.1f}")
    return before + seconds


def _missing(one: Set, chosen: Sequence[str], known: set[tuple[object, ...]]) -> tuple[str, ...]:
    place = (one.family, one.n, one.sigma, one.seed, False)
    return tuple(name for name in chosen if (name, *place) not in known)


if __name__ == "__main__":
    main()
