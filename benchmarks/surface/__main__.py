"""Measure surfaces and slices, and write docs/surface.md: ``python -m benchmarks.surface``."""

from __future__ import annotations

import argparse
import importlib.metadata
import platform
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.peers.environment import versions
from benchmarks.peers.page import Origin
from benchmarks.surface.completion import completed_levels
from benchmarks.surface.environment import FOLDER, is_usable, make_environment
from benchmarks.surface.meshes import real_scans, virtual_scans
from benchmarks.surface.page import tables, write
from benchmarks.surface.rows import load, save
from benchmarks.surface.slicing import cut_both
from benchmarks.surface.stacks import span_stacks
from core.truth import Scanner, solid, solid_names

__all__ = ["FULL", "QUICK", "Plan", "main", "measure"]

DOCS = Path(__file__).parent.parent.parent / "docs"


@dataclass(frozen=True, slots=True)
class Plan:
    """How much is measured."""

    solids: tuple[str, ...] = solid_names()
    scanner: Scanner = field(default_factory=Scanner)
    levels: int = 128
    triangles: int = 1_000_000
    planes: int = 100
    stacks: int = 10_000
    completed: tuple[str, ...] = ("ball", "bust", "torus", "fork", "pair")
    rounds: int = 1


FULL = Plan()
QUICK = Plan(("ball", "torus"), levels=32, triangles=100_000, stacks=200, completed=("torus",))


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the environment, measure, and write the page."""
    options = _options(arguments)
    plan = QUICK if options.quick else FULL
    folder = FOLDER / "quick" if options.quick else FOLDER
    file = folder / "rows.json"
    if not (options.only or options.page):
        file.unlink(missing_ok=True)
    if not options.page:
        python = None if options.without_open3d else _open3d()
        measure(plan, python, options.scans, options.only.split(",") if options.only else None, file)
    rows = load(file)
    if options.quick and not options.output:
        print("\n".join(tables(rows)))
    else:
        origin = Origin.here({}, None, 1, sum(rows.seconds.values()))
        print(write(rows, origin, options.output or DOCS))


def measure(
    plan: Plan, python: Path | None, scans: Path | None, only: Sequence[str] | None, file: Path
) -> None:
    """Measure part by part; keep each part in the file as soon as it is known, beside what is there."""
    parts: dict[str, Callable[[], Iterable[Any]]] = {
        "slicing": lambda: cut_both(plan.triangles, plan.planes),
        "solids": lambda: (
            row
            for name in plan.solids
            for row in virtual_scans(solid(name), plan.scanner, plan.levels, python)
        ),
        "scans": lambda: real_scans(scans, plan.levels, python) if scans else (),
        "completion": lambda: (
            row
            for name in plan.completed
            for row in completed_levels(solid(name), plan.scanner, plan.levels, plan.rounds)
        ),
        "stacks": lambda: [span_stacks(plan.stacks)],
    }
    for name, run in parts.items():
        if only is None or name in only:
            began = time.monotonic()
            found = [_said(one) for one in run()]
            rows = load(file)
            setattr(rows, name, found)
            rows.seconds[name] = time.monotonic() - began
            rows.versions |= _versions(python)
            save(rows, file)


def _open3d() -> Path | None:
    python = make_environment()
    return python if is_usable(python) else None


def _said(row: Any) -> Any:
    print(row, file=sys.stderr)
    return row


def _versions(python: Path | None) -> dict[str, str]:
    known = {"own Python": platform.python_version(), "trimesh": importlib.metadata.version("trimesh")}
    return known if python is None else known | {"Open3D": versions(python, ("open3d",))["open3d"]}


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.surface", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a little of everything; prints the tables only")
    parser.add_argument("--scans", type=Path, help="a folder with PLY range grids and their .conf file")
    parser.add_argument("--without-open3d", action="store_true", help="measure Tapeline alone")
    parser.add_argument("--only", help="measure these parts anew, with commas between; keep the others")
    parser.add_argument("--page", action="store_true", help="measure nothing: write the page again")
    parser.add_argument("--output", type=Path, help="the folder for the page; docs by default")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    main()
