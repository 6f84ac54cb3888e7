"""The fast way from contours to one closed surface: signed distances, interpolated between levels.

In each level's plane, the signed distance from its contours is sampled on a square raster; between
two levels it is interpolated linearly (Herman, Zheng and Bucholtz 1992), and marching cubes
(Lewiner et al. 2003) follow its zero.
"""

from __future__ import annotations

from importlib import import_module

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt
from scipy.spatial import cKDTree

from core.errors import DegenerateInput
from core.surface.mesh_report import volume_of
from core.surface.regions import Regions
from core.surface.results import Mesh

__all__ = ["mesh_of_distances"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

MOST_PIXELS = 256  # along the longer side
LEAST_PIXELS = 48
MOST_VOXELS = 8_000_000
MARGIN = 2  # empty pixels around everything
STEP = 0.5  # pixels between samples of the contours
BAND = 2  # pixels near contours, where the distance is exact
FINER = 0.07  # by which another attempt has more pixels
CLEAR = 0.05  # pixels: least distance of a raster point, which keeps vertices of the mesh apart


def mesh_of_distances(regions: Regions, attempt: int = 0) -> Mesh:
    """The closed mesh of the interpolated distances, in the frame of the levels: x, y, height.

    Marching cubes may make faces that cut each other where cubes are ambiguous; another ``attempt``
    has another raster.

    Raises
    ------
    DegenerateInput
        When the contours enclose nothing that the raster shows.
    """
    pixel = _pixel(regions) / (1.0 + FINER * attempt)
    raster, ends = _raster(regions, pixel)
    values = np.empty((len(regions.heights), *raster), np.float32)
    empty = []
    for level in range(len(regions.heights)):
        mine = ends[regions.lines.level == level]
        inside = _inside(mine, raster)
        if inside.any():
            distance = np.maximum(_distances(mine, raster), CLEAR)
            values[level] = np.where(inside, -distance, distance)
        else:
            empty.append(level)
    if len(empty) == len(values):
        raise DegenerateInput("The contours enclose nothing.", ("contours",))
    pitch = pixel * regions.grid.pitch
    _close(values, empty, regions.heights / pitch)
    return _zero(values, regions, pitch)


def _pixel(regions: Regions) -> float:
    """Side of a pixel in grid units."""
    ends = regions.lines.ends.reshape(-1, 2)
    count = np.clip(np.sqrt(MOST_VOXELS / len(regions.heights)), LEAST_PIXELS, MOST_PIXELS)
    return float(np.ptp(ends, axis=0).max() / count)


def _raster(regions: Regions, pixel: float) -> tuple[tuple[int, int], Floats]:
    """Rows and columns, and the edges (E, 2, 2) in pixels."""
    ends = regions.lines.ends.astype(np.float64)
    low = ends.reshape(-1, 2).min(axis=0)
    ends = (ends - low) / pixel + MARGIN
    columns, rows = np.ceil(ends.reshape(-1, 2).max(axis=0)).astype(int) + MARGIN + 1
    return (int(rows), int(columns)), ends


def _inside(ends: Floats, raster: tuple[int, int]) -> Bools:
    """Raster points with an odd number of edges to their left."""
    rows, columns = raster
    low = np.ceil(ends[:, :, 1].min(axis=1)).astype(np.int64)
    high = np.ceil(ends[:, :, 1].max(axis=1)).astype(np.int64)
    edge, along = _repeated(high - low)
    row = low[edge] + along
    a, b = ends[edge, 0], ends[edge, 1]
    x = a[:, 0] + (row - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    cell = row * columns + np.ceil(x).astype(np.int64)
    crossings = np.bincount(cell, minlength=rows * columns).reshape(raster)
    odd: Bools = crossings.cumsum(axis=1) % 2 == 1
    return odd


def _distances(ends: Floats, raster: tuple[int, int]) -> Floats:
    """Distances of the raster points from edges: near them exact, further away from their samples."""
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    count = np.ceil(length / STEP).astype(np.int64)
    edge, along = _repeated(count)
    share = (along + 0.5) / count[edge]
    samples = ends[edge, 0] + share[:, None] * (ends[edge, 1] - ends[edge, 0])
    nearest = np.rint(samples).astype(np.int64)[:, ::-1]
    seeds = np.full(raster, -1)
    seeds[nearest[:, 0], nearest[:, 1]] = np.arange(len(samples))
    near = binary_dilation(seeds >= 0, iterations=BAND)
    by_seed = distance_transform_edt(seeds < 0, return_distances=False, return_indices=True)
    sample = seeds[by_seed[0], by_seed[1]]
    row, column = np.nonzero(near)
    _, sample[near] = cKDTree(samples).query(np.column_stack((column, row)))
    rows, columns = np.indices(raster)
    places = np.stack((columns, rows), axis=-1).reshape(-1, 2).astype(np.float64)
    owner = edge[sample.ravel()]
    return _from_edge(places, ends[owner, 0], ends[owner, 1]).reshape(raster)


def _from_edge(places: Floats, a: Floats, b: Floats) -> Floats:
    """Distances of places from edges a b."""
    step = b - a
    share = np.clip(((places - a) * step).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    rest: Floats = places - a - share[:, None] * step
    return np.asarray(np.hypot(rest[:, 0], rest[:, 1]))


def _repeated(counts: Ints) -> tuple[Ints, Ints]:
    """Index i as often as counts[i] says, and 0, 1, 2 ... of each."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _close(values: NDArray[np.float32], empty: list[int], heights: Floats) -> None:
    """Distances in empty levels: such that caps rise at 45 degrees, up to half the way there."""
    full = np.setdiff1d(np.arange(len(heights)), empty)
    for level in empty:
        values[level] = np.inf
        for other in (level - 1, level + 1):
            if other in full:
                size = np.abs(values[other])
                cap = np.maximum(size, abs(heights[level] - heights[other]) - size)
                values[level] = np.minimum(values[level], cap)
        if not np.isfinite(values[level]).all():
            values[level] = 1.0


def _zero(values: NDArray[np.float32], regions: Regions, pitch: float) -> Mesh:
    """The surface between negative and positive values."""
    measure = import_module("skimage.measure")
    places, faces, _, _ = measure.marching_cubes(values, 0.0)
    places = places.astype(np.float64)
    height = np.interp(places[:, 0], np.arange(len(values)), regions.heights)
    low = regions.lines.ends.reshape(-1, 2).min(axis=0)
    xy = regions.grid.placed(low.astype(np.float64)) + pitch * (places[:, :0:-1] - MARGIN)
    mesh = Mesh(np.column_stack((xy, height)), faces.astype(np.int64))
    return mesh if volume_of(mesh) > 0.0 else Mesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]))
