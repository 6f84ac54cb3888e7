"""Both programs on the same scans: of built-in solids, and of a folder of real ones."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.surface.judging import distances_between, residual, topology_of
from benchmarks.surface.programs import OPEN3D, TAPELINE, Made, by_poisson, by_tapeline, oriented_points
from benchmarks.surface.rows import MeshRow
from core.surface.results import Mesh, RangeImage
from core.truth import Scanner, Solid, scan
from service.intake.range_ply import decode_conf, decode_range_ply

__all__ = ["UPRIGHT", "both", "real_scans", "virtual_scans"]

Floats = NDArray[np.float64]
Judge = Callable[[MeshRow, Mesh], MeshRow]

PROCESSES = 2
UPRIGHT = "y"  # the axis across the levels of real scans: so the Stanford ones stand


def virtual_scans(one: Solid, scanner: Scanner, levels: int, python: Path | None) -> Iterator[MeshRow]:
    """Measure on scans of a solid with known truth; Open3D only where its interpreter is given."""

    def judged(row: MeshRow, mesh: Mesh) -> MeshRow:
        return replace(row, **asdict(distances_between(mesh, one)))

    start = MeshRow(one.name, "", levels=levels, true_components=one.components, true_genus=one.genus)
    for row, _ in both(scan(one, scanner), start, python, judged):
        yield row


def real_scans(folder: Path, levels: int, python: Path | None) -> Iterator[MeshRow]:
    """Measure on Stanford PLY range grids, with the poses of the ``.conf`` file beside them."""
    (conf,) = folder.glob("*.conf")
    poses = decode_conf(conf.read_bytes())
    files = [one for one in sorted(folder.glob("*.ply")) if one.name in poses]
    images = tuple(decode_range_ply(one.read_bytes(), poses[one.name]) for one in files)
    points, _ = oriented_points(images)

    def judged(row: MeshRow, mesh: Mesh) -> MeshRow:
        return replace(row, rms=residual(mesh, points))

    for row, made in both(images, MeshRow(conf.stem, "", levels=levels), python, judged, UPRIGHT):
        if row.program == TAPELINE and made is not None:
            yield replace(row, together=by_tapeline(images, levels, UPRIGHT, PROCESSES).clock)
        else:
            yield row


def both(
    images: tuple[RangeImage, ...], start: MeshRow, python: Path | None, judge: Judge, axis: str = "z"
) -> Iterator[tuple[MeshRow, Made | None]]:
    """Let both programs make a mesh, and judge it."""
    points, normals = oriented_points(images)
    start = replace(start, points=len(points))
    yield _row(replace(start, program=TAPELINE), lambda: by_tapeline(images, start.levels, axis), judge)
    if python is not None:
        yield _row(replace(start, program=OPEN3D), lambda: by_poisson(python, points, normals), judge)


def _row(start: MeshRow, run: Callable[[], Made], judge: Judge) -> tuple[MeshRow, Made | None]:
    try:
        made = run()
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        return replace(start, problem=type(error).__name__), None
    row = replace(
        start,
        **asdict(topology_of(made.mesh)),
        cpu=made.cpu,
        clock=made.clock,
        stages=made.stages,
        method=made.method,
        completed=made.completed,
    )
    return judge(row, made.mesh), made
