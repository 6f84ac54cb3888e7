"""The two programs that make a surface of range images, each run in a process of its own on one core."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.peers.environment import ROOT
from benchmarks.peers.process import ONE_THREAD
from benchmarks.surface.own import save_images
from core.surface.range_image import triangulate
from core.surface.results import Mesh, RangeImage

__all__ = ["NEAREST", "OPEN3D", "TAPELINE", "Made", "by_poisson", "by_tapeline", "oriented_points"]

Floats = NDArray[np.float64]

TAPELINE, OPEN3D = "Tapeline", "Open3D Poisson"
NEAREST = 50  # points of all scans that a normal is estimated from
CHUNK = 20_000
LIMIT = 1800.0  # seconds by the clock


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A mesh, what it cost, and of Tapeline CPU seconds of each stage and what its report tells."""

    mesh: Mesh
    cpu: float
    clock: float
    stages: tuple[float, ...] = ()
    method: str = ""
    completed: int = 0


def by_tapeline(images: tuple[RangeImage, ...], levels: int, axis: str = "z", processes: int = 1) -> Made:
    """Let Tapeline make a surface."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        save_images(images, source)
        _run(Path(sys.executable), "own", str(source), str(target), str(levels), str(processes), axis)
        with np.load(target) as known:
            cpu, clock = (float(one) for one in known["seconds"])
            return Made(
                Mesh(known["vertices"], known["faces"]),
                cpu,
                clock,
                tuple(known["stages"].tolist()),
                str(known["method"]),
                int(known["completed"]),
            )


def by_poisson(python: Path, points: Floats, normals: Floats) -> Made:
    """Let Open3D make a surface."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, points=points, normals=normals)
        _run(python, "poisson", str(source), str(target))
        with np.load(target) as known:
            cpu, clock = (float(one) for one in known["seconds"])
            return Made(Mesh(known["vertices"], known["faces"]), cpu, clock)


def _run(python: Path, module: str, *arguments: str) -> None:
    command = [str(python), "-m", f"benchmarks.surface.{module}", *arguments]
    subprocess.run(command, check=True, cwd=ROOT, env=os.environ | ONE_THREAD, timeout=LIMIT)  # noqa: S603 - our own


def oriented_points(images: Sequence[RangeImage]) -> tuple[Floats, Floats]:
    """Return all points that Tapeline's triangles use, in place, and unit normals at them.

    A normal is that of the plane through the nearest points of all scans, on the side of the scanner
    that saw the point. Of the estimates that were tried this made the least error: single images
    average over fewer points.
    """
    meshes = [triangulate(image) for image in images]
    points = np.concatenate([one.vertices for one in meshes])
    outward = np.concatenate([_vertex_normals(one) for one in meshes])
    tree = cKDTree(points)
    normals = np.empty_like(points)
    for some in np.array_split(np.arange(len(points)), -(-len(points) // CHUNK)):
        around = points[tree.query(points[some], min(NEAREST, len(points)))[1]]
        around = around - around.mean(axis=1, keepdims=True)
        normals[some] = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]
    side = np.einsum("ij,ij->i", normals, outward)
    return points, normals * np.where(side < 0.0, -1.0, 1.0)[:, None]


def _vertex_normals(mesh: Mesh) -> Floats:
    """Return the sums of the normals of the faces about each vertex, by area."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    result = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(result, mesh.faces[:, k], normals)
    return result
