"""The peer CGAL: curve reconstruction by optimal transportation, told its tolerance."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.told import Answer, Told, subset

__all__ = ["run", "settings"]

Floats = NDArray[np.float64]
Setting = tuple[float, int]

QUEUE = 500  # up to so many samples all collapses are queued, which takes seven times as long


def settings(told: Told, n: int) -> Iterator[tuple[str, Setting]]:
    """Yield tolerances in sigma, and the number of collapses to choose from."""
    del told
    choices = 0 if n <= QUEUE else 15
    for tolerance in (1.4, 2.0, 2.8, 4.0):
        words = "all queued" if choices == 0 else f"{choices} choices"
        yield f"tolerance {tolerance:g} σ, {words}", (tolerance, choices)


def run(points: Floats, told: Told, setting: Setting, program: Path) -> Answer:
    """Write the samples for the program, and read its graph."""
    with tempfile.NamedTemporaryFile(suffix=".xy") as file:
        file.write(np.ascontiguousarray(subset(points, told)).tobytes())
        file.flush()
        command = [str(program), file.name, repr(setting[0] * told.sigma), str(setting[1])]
        text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout  # noqa: S603 - our own program
    head, *lines = text.splitlines()
    count = int(head.split()[0])
    vertices = np.array([line.split() for line in lines[:count]], np.float64).reshape(-1, 2)
    edges = np.array([line.split() for line in lines[count:]], np.int64).reshape(-1, 2)
    return Answer(vertices=vertices, edges=edges)
