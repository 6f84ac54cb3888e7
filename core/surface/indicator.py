"""What all oriented samples tell together: an indicator function, and its contours at any height.

The gradient of the function that is one inside an object and zero outside is the field of its inward
normals; so the function solves a Poisson equation whose right side oriented samples tell (Kazhdan 2005,
"Reconstruction of solid models from oriented point sets", Symposium on Geometry Processing). On a
regular grid the solution is a product in the frequency domain. Where samples lie denser, as where scans
overlap, they weigh less (Kazhdan, Bolitho and Hoppe 2006, "Poisson surface reconstruction").
The contours are coarse, about as exact as a twentieth of a cell where the object is thicker than a few of
them, but they are closed whatever gaps there are, and cost milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from contourpy import contour_generator
from numpy.typing import NDArray
from scipy import fft
from scipy.ndimage import gaussian_filter, map_coordinates

from core.cloud.points import inverse_power_of_two
from core.surface.axis import AxisFrame
from core.surface.density import add_divergence, read, samples_of, spread, subtract
from core.surface.results import Mesh

__all__ = ["CELLS", "Indicator", "indicator_of"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]

CELLS = 120
"""Cells along the longest edge of the box around all meshes."""

_MARGIN = 0.08  # of the longest edge, on every side: the transform repeats the grid without end
_LEAST_MARGIN = 6  # cells
_SMOOTHING = 0.7  # cells: standard deviation of the Gaussian that the samples become
_LONGEST = 2.0  # cells: edges of triangles that count as one sample
_COARSE = 3  # cells from node to node of the grid of densities
_BLUR = 0.5  # standard deviation in steps of that grid
_FEW = 0.1  # of the density of one sheet: with fewer samples around deviations fade out
_LEAST_STEP = 0.05  # between outside and inside, where one is expected: less is where orientations cancel
_STEPS, _MOST_STEPS = 6, 120  # at which the function is looked at: in a cell, and in all
_LEAST_VERTICES = 9  # of a loop: those of less than about two cells across have fewer


@dataclass(frozen=True, slots=True, eq=False)
class Indicator:
    """An indicator function, up to a factor and an offset, on a regular grid.

    Attributes
    ----------
    values : (K, J, I) array of float32
        At the nodes: height, y, x. Larger inside; none on the border is.
    origin : (3,) array
        The first node: x and y in the plane, height.
    pitch : float
        Distance between nodes.
    level : float
        The value on the surface.
    """

    values: Singles
    origin: Floats
    pitch: float
    level: float

    def loops(self, height: float) -> list[Floats]:
        """Return the contours at a height.

        Returns
        -------
        list of (M, 2) arrays
            Closed, in the plane, without repeating the first vertex; the inside is on the left. Those of
            less than about two cells across are left out.
        """
        place = (height - float(self.origin[2])) / self.pitch
        if not 0.0 <= place < len(self.values) - 1:
            return []
        below, share = int(place), place % 1.0
        layer = (1.0 - share) * self.values[below].astype(np.float64) + share * self.values[below + 1]
        lines = contour_generator(z=layer).lines(self.level)
        return [
            self.origin[:2] + self.pitch * np.asarray(line[:-1], np.float64)
            for line in lines
            if len(line) > _LEAST_VERTICES
        ]

    def crossings(self, places: Floats, start: Floats, end: Floats) -> Floats:
        """Return the heights at which the surface passes over places.

        Parameters
        ----------
        places : (N, 2) array
            In the plane.
        start, end : (N,) arrays
            Heights between which it is sought: upward, or downward.

        Returns
        -------
        (N,) array
            NaN where the start is not inside and the end outside, or the surface passes more than once.
        """
        gap = float(np.abs(end - start).max(initial=0.0)) / self.pitch
        share = np.linspace(0.0, 1.0, int(np.clip(_STEPS * gap, _STEPS, _MOST_STEPS)) + 1)
        heights = start[:, None] + share * (end - start)[:, None]
        flat = np.broadcast_to(places[:, None, :], (*heights.shape, 2))
        nodes = (np.concatenate((flat, heights[..., None]), axis=2) - self.origin) / self.pitch
        found = map_coordinates(self.values, nodes[..., ::-1].reshape(-1, 3).T, order=1, mode="nearest")
        values = found.reshape(heights.shape).astype(np.float64) - self.level
        inside = values > 0.0
        changes = inside[:, 1:] != inside[:, :-1]
        leaves = inside[:, 0] & (np.count_nonzero(changes, axis=1) == 1)
        row, first = np.arange(len(places)), np.argmax(changes, axis=1)
        before, after = values[row, first], values[row, first + 1]
        part = (first + before / np.where(leaves, before - after, 1.0)) / (len(share) - 1)
        return np.where(leaves, start + part * (end - start), np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """Nodes in x, y and height, the place of the first one in the units of the box, and their distance."""

    shape: tuple[int, int, int]
    first: Floats
    pitch: float


def indicator_of(meshes: Sequence[Mesh], frame: AxisFrame, cells: int = CELLS) -> Indicator | None:
    """Solve for the indicator function of what meshes are the surface of.

    Parameters
    ----------
    meshes : sequence of Mesh
        Open or closed, overlapping or with gaps; all of them oriented outward, or all inward.
    frame : AxisFrame
        Of the axis across the planes.
    cells : int
        Along the longest edge of their box in the frame.

    Returns
    -------
    Indicator or None
        None where there is no area, where all lies within a cell of a plane across an axis of the frame,
        or where faces are turned both ways.
    """
    vertices, faces = _together(meshes)
    if not len(faces):
        return None
    unit = inverse_power_of_two(float(np.abs(vertices).max()))
    corner = unit * vertices.min(axis=0)
    turned = (unit * vertices - corner) @ frame.axes.T  # of differences: no digits are lost far away
    grid = _grid(turned, cells)
    if grid is None:
        return None
    turned -= grid.first
    turned /= grid.pitch
    places, areas = samples_of(turned, faces, _LONGEST)
    values, level = _outward(*_solved(places, areas, grid.shape))
    inside = _inner(values, level)
    if inside is None:
        return None
    steps = np.array([part.start for part in inside[::-1]], np.float64)
    origin = (frame.axes @ corner + grid.first + grid.pitch * steps) / unit
    return Indicator(np.ascontiguousarray(values[inside]), origin, grid.pitch / unit, level)


def _together(meshes: Sequence[Mesh]) -> tuple[Floats, Ints]:
    """Put all triangles together, without vertices that none of them has."""
    some = [mesh for mesh in meshes if len(mesh.faces)]
    if not some:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in some)])
    vertices = np.concatenate([mesh.vertices for mesh in some])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(some, starts, strict=False)])
    used = np.zeros(len(vertices), np.bool_)
    used[faces.ravel()] = True
    if used.all():
        return vertices, faces
    return vertices[used], (np.cumsum(used) - 1)[faces]


def _grid(points: Floats, cells: int) -> _Grid | None:
    """Lay a grid of cubes around points, with margins; None when they lie within one layer of them."""
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    pitch = float(extent.max()) / cells
    if not float(extent.min()) > pitch:
        return None
    margin = max(_MARGIN * cells, _LEAST_MARGIN)
    least = np.ceil(extent / pitch + 2.0 * margin).astype(int) + 1
    x, y, z = (fft.next_fast_len(int(size), real=axis == 0) for axis, size in enumerate(least))
    room = (np.array([x, y, z]) - 1) * pitch - extent
    return _Grid((x, y, z), low - room / 2.0, pitch)


def _solved(places: Singles, areas: Singles, shape: tuple[int, int, int]) -> tuple[Singles, float]:
    """Return the indicator function of samples, and its value on the surface."""
    sizes = np.sqrt(np.einsum("ij,ij->i", areas, areas))
    crowd = _blurred(places, sizes, shape)
    weights = 1.0 / np.maximum(read(places, _COARSE, crowd), np.float32(1.0))
    values = np.zeros(shape[::-1], np.float32)
    add_divergence(places, areas * weights[:, None], values)
    values = _potential(values)
    found = read(places, 1, values)
    weights *= sizes
    total = float(weights.sum(dtype=np.float64))
    level = float(np.dot(weights.astype(np.float64), found)) / total if total > 0.0 else 0.0
    # What the samples' values deviate from the level varies slowly: it comes of uneven sampling and of
    # curvature, and is the same on both sides of the surface.
    deviation = _blurred(places, sizes * (found - np.float32(level)), shape) / (crowd + np.float32(_FEW))
    subtract(deviation, _COARSE, values)
    return values, level


def _blurred(places: Singles, amounts: Singles, shape: tuple[int, int, int]) -> Singles:
    """Return the density of amounts on the coarse grid; that of areas is one on a single flat sheet."""
    grid = np.zeros([(size - 1) // _COARSE + 2 for size in shape[::-1]], np.float32)
    spread(places, amounts, _COARSE, grid)
    blurred: Singles = gaussian_filter(grid, _BLUR, mode="constant", truncate=3.5)
    # Across a sheet the density is about a normal distribution; to spread and to read trilinearly adds a
    # sixth each to its variance.
    width = float(np.sqrt(_BLUR**2 + 1.0 / 3.0))
    blurred *= np.float32(np.sqrt(2.0 * np.pi) * width / _COARSE**2)
    return blurred


def _potential(divergence: Singles) -> Singles:
    """Solve the Poisson equation, and make a Gaussian of the B-splines that the samples have been."""
    spectrum = fft.rfftn(divergence, overwrite_x=True)
    depth, height, width = divergence.shape
    z, y = (_frequencies(fft.fftfreq(size)) for size in (depth, height))
    x = _frequencies(fft.rfftfreq(width))
    for k in range(depth):
        square = z[0][k] + y[0][:, None] + x[0]
        if k == 0:
            square[0, 0] = np.inf  # the mean, which is free
        spectrum[k] *= (z[1][k] * y[1])[:, None] * x[1] / square
    values: Singles = fft.irfftn(spectrum, s=divergence.shape, overwrite_x=True)
    return values


def _frequencies(cycles: Floats) -> tuple[Singles, Singles]:
    """Return squares of angular frequencies, and by what to multiply there, for one axis."""
    angular = 2.0 * np.pi * cycles
    smooth = np.exp(-0.5 * (_SMOOTHING * angular) ** 2) / np.sinc(cycles) ** 3
    return (angular**2).astype(np.float32), smooth.astype(np.float32)


def _outward(values: Singles, level: float) -> tuple[Singles, float]:
    """Turn the function of faces that look inward round: beyond everything, it is to be smaller."""
    sides = float(np.mean([side.mean() for side in _sides(values)]))
    return (np.negative(values, out=values), -level) if sides > level else (values, level)


def _sides(values: Singles) -> list[Singles]:
    """Return the six sides of a grid, as views."""
    return [side for axis in range(3) for side in (np.moveaxis(values, axis, 0)[end] for end in (0, -1))]


def _inner(values: Singles, level: float) -> tuple[slice, slice, slice] | None:
    """Return the part of the grid beyond which nothing is inside; None when that is none, or outside in.

    What goes on beyond the grid ends on its border.
    """
    sides = [side for axis in range(3) for side in (np.moveaxis(values, axis, 0)[end] for end in (0, -1))]
    lowest, outside = values.min(), sum(float(side.mean()) for side in sides) / len(sides)
    if values.max() - lowest < _LEAST_STEP or outside >= level:
        return None
    for side in sides:
        side[...] = lowest
    inside = values > level
    parts = [np.flatnonzero(inside.any(axis=others)) for others in ((1, 2), (0, 2), (0, 1))]
    if not len(parts[0]):
        return None
    k, j, i = (slice(int(part[0]) - 1, int(part[-1]) + 2) for part in parts)
    return k, j, i
