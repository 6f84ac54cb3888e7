"""Cutting a large mesh by many planes, beside trimesh."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
import trimesh

from benchmarks.surface.programs import TAPELINE
from benchmarks.surface.rows import SlicingRow
from core.surface.parameters import SliceParameters
from core.surface.results import Mesh
from core.surface.slicing import slices_of

__all__ = ["cut_both", "torus_mesh"]

REPEATS = 3  # the least time counts


def torus_mesh(triangles: int) -> Mesh:
    """Return a tilted torus of about so many triangles."""
    around = max(3, round(np.sqrt(triangles)))
    across = max(3, round(triangles / 2 / around))
    turn, roll = np.meshgrid(
        2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij"
    )
    wide = 34.0 + 15.0 * np.cos(roll)
    places = np.stack((wide * np.cos(turn), wide * np.sin(turn), 15.0 * np.sin(roll)), axis=2).reshape(-1, 3)
    index = np.arange(around * across).reshape(around, across)
    next_turn, next_roll = np.roll(index, -1, axis=0), np.roll(index, -1, axis=1)
    opposite = np.roll(next_turn, -1, axis=1)
    halves = (index, next_turn, opposite), (index, opposite, next_roll)
    faces = np.concatenate([np.stack(one, axis=2).reshape(-1, 3) for one in halves])
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.8, 0.6]])
    return Mesh(places @ tilt.T, faces)


def cut_both(triangles: int, planes: int) -> Iterator[SlicingRow]:
    """Measure CPU seconds of each way."""
    mesh = torus_mesh(triangles)
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    heights = low + (np.arange(planes) + 0.5) / planes * (high - low)
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    parameters = SliceParameters(heights=tuple(heights.tolist()))
    planes_of_trimesh = (np.zeros(3), np.array([0.0, 0.0, 1.0]), heights)
    ways: dict[str, Callable[[], object]] = {
        TAPELINE: lambda: slices_of([mesh], parameters),
        "trimesh section_multiplane": lambda: other.section_multiplane(*planes_of_trimesh),
        "trimesh mesh_multiplane": lambda: trimesh.intersections.mesh_multiplane(other, *planes_of_trimesh),
    }
    for name, run in ways.items():
        yield SlicingRow(name, len(mesh.faces), planes, min(_seconds(run) for _ in range(REPEATS)))


def _seconds(run: Callable[[], object]) -> float:
    began = time.process_time()
    run()
    return time.process_time() - began
