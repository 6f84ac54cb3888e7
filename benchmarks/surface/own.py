"""Tapeline's surface in its own process: ``python -m benchmarks.surface.own IN OUT LEVELS PROCESSES AXIS``.

What is measured is what users get: :data:`core.surface.methods.SURFACE`, in one piece or, with several
processes, in the parts that the service computes apart.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.surface.methods import CUT, SURFACE, surface
from core.surface.parameters import SurfaceParameters
from core.surface.results import Pose, RangeImage, Scans, Surface
from core.truth import Scanner, scan, solid

__all__ = ["STAGES", "load_images", "main", "save_images"]

Floats = NDArray[np.float64]

STAGES = ("triangulating and slicing", "contours", "surface", "report")
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
SPANNING, MEASURING = "spanning the surface", "measuring the surface"


def main(arguments: list[str]) -> None:
    """Read range images, write vertices, faces and seconds."""
    source, target, levels, processes, axis = arguments
    images = load_images(Path(source))
    warm_up()
    parameters = SurfaceParameters(levels=int(levels), axis=AXES[axis])
    if int(processes) == 1:
        made, seconds, stages = whole(images, parameters)
    else:
        made, seconds, stages = in_parts(images, parameters, int(processes))
    np.savez(
        target,
        vertices=made.mesh.vertices,
        faces=made.mesh.faces,
        seconds=np.array(seconds),
        stages=stages,
        method=made.report.method,
        completed=len(made.report.completed_levels),
    )


def warm_up(_: int = 0) -> None:
    """Compile the kernels, or load them: no part of any time."""
    for name in ("torus", "pair"):
        images = scan(solid(name), Scanner(views=8, pixels=80))
        surface(Scans(range_images=images), SurfaceParameters(levels=20))


def whole(images: tuple[RangeImage, ...], parameters: SurfaceParameters) -> tuple[Surface, Floats, Floats]:
    """Return the surface, CPU seconds and seconds by the clock, and CPU seconds of each stage."""
    marks: dict[str, float] = {}

    def told(fraction: float, words: str) -> None:
        if fraction >= CUT:
            marks.setdefault("sliced", time.process_time())
        if words in {SPANNING, MEASURING}:
            marks.setdefault(words, time.process_time())

    began, clock = time.process_time(), time.monotonic()
    made = surface(Scans(range_images=images), parameters, progress=told)
    ended, later = time.process_time(), time.monotonic()
    times = [began, *(marks.get(one, began) for one in ("sliced", SPANNING, MEASURING)), ended]
    return made, np.array([ended - began, later - clock]), np.diff(times)


def in_parts(
    images: tuple[RangeImage, ...], parameters: SurfaceParameters, processes: int
) -> tuple[Surface, Floats, Floats]:
    """Return the surface and seconds by the clock, with so many processes; the CPU seconds are not known."""
    scans = Scans(range_images=images)
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        list(pool.map(warm_up, range(2 * processes)))
        clock = time.monotonic()
        parts = SURFACE.split(scans, parameters)
        solved = list(pool.map(SURFACE.solve, parts, [None] * len(parts)))
        made = SURFACE.join(scans, parameters, solved) if parts else surface(scans, parameters)
        return made, np.array([np.nan, time.monotonic() - clock]), np.zeros(0)


def save_images(images: tuple[RangeImage, ...], file: Path) -> None:
    """Write range images to a file of arrays."""
    arrays: dict[str, Any] = {}
    for k, image in enumerate(images):
        pose = image.pose or Pose(np.eye(3), np.zeros(3))
        arrays[f"points_{k}"] = image.points
        arrays[f"rotation_{k}"], arrays[f"translation_{k}"] = pose.rotation, pose.translation
    np.savez(file, **arrays)


def load_images(file: Path) -> tuple[RangeImage, ...]:
    """Read what :func:`save_images` wrote."""
    with np.load(file) as known:
        return tuple(
            RangeImage(known[f"points_{k}"], Pose(known[f"rotation_{k}"], known[f"translation_{k}"]))
            for k in range(len(known.files) // 3)
        )


if __name__ == "__main__":
    main(sys.argv[1:])
