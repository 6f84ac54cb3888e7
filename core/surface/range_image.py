"""Range images to meshes (§5.1.1, step i): neighbouring pixels are joined, unless they saw different things.

A pixel pitch is what the scanner's grid measures across the line of sight: the
distance between neighbouring pixels that see a surface face to face. It is read off
the data, for rows, columns and both diagonals apart. The rays of many scanners
spread, so that pitches grow with distance, all by one factor; of a surface seen
at an angle t from its normal distances grow by up to 1 / cos t, but hardly in that of
the four directions that runs most nearly across the slope. The least of the four
tells the factor, tile by tile. What grows by more than at the steepest angle is a
jump between two surfaces, or is seen so flatly that its noise is worse than its
information.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from core.cloud.points import inverse_power_of_two
from core.surface.results import Mesh, RangeImage

__all__ = ["triangulate"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Side = tuple[str, str]

_Number = TypeVar("_Number", np.float64, np.int64)

_STEEPEST = np.cos(np.radians(75.0))
_TILE = 8  # pixels along each side of a tile that has one pitch
_FEW = 16  # pixels that a tile needs for a pitch of its own
_FACE_TO_FACE = 0.2  # quantile of distances: of most views a fifth is seen nearly face to face

# Steps (rows, columns) to the corners of a quad; its sides along rows and columns, and its diagonals.
_CORNERS = {"00": (0, 0), "01": (0, 1), "10": (1, 0), "11": (1, 1)}
_SIDES = (("00", "01"), ("10", "11"), ("00", "10"), ("01", "11"), ("01", "10"), ("00", "11"))
# The four triangles of a quad, counter-clockwise seen from the scanner; the first two share the
# diagonal 01-10, the others the diagonal 00-11.
_TRIANGLES = (("00", "01", "10"), ("11", "10", "01"), ("00", "01", "11"), ("00", "11", "10"))


def triangulate(image: RangeImage) -> Mesh:
    """Join neighbouring pixels of a range image to triangles, and put them in place.

    Left out are triangles with an edge that spans a depth discontinuity and those seen at a grazing
    angle, 75 degrees or more from their normal. A quad of four pixels is cut along its shorter
    diagonal; three pixels make one triangle.

    Parameters
    ----------
    image : RangeImage
        Points (I, J, 3) with NaN where nothing was seen, and the pose that takes them into place.

    Returns
    -------
    Mesh
        Open as a rule; normals point to the scanner; only vertices that a face uses. It may be empty.

    Examples
    --------
    >>> y, x = np.mgrid[0:3, 0:4].astype(float)
    >>> mesh = triangulate(RangeImage(np.dstack((x, y, 0 * x))))
    >>> mesh.vertices.shape, mesh.faces.shape
    ((12, 3), (12, 3))
    """
    points = np.asarray(image.points, np.float64)
    grid = np.ascontiguousarray(np.moveaxis(points, 2, 0))
    seen = np.isfinite(grid).all(axis=0)
    largest = float(np.abs(grid).max(initial=0.0, where=seen))
    unit = inverse_power_of_two(largest)  # squares of what is left neither over- nor underflow
    faces = _faces(np.where(seen, grid * unit, np.nan))
    used = np.zeros(seen.size, np.bool_)
    used[faces] = True
    vertices = points.reshape(-1, 3)[used]
    if image.pose is not None:
        vertices = vertices @ image.pose.rotation.T + image.pose.translation
    return Mesh(np.ascontiguousarray(vertices), (np.cumsum(used) - 1)[faces])


def _faces(grid: Floats) -> Ints:
    """Return the triangles that are kept of a grid (3, I, J), as flat indices of pixels."""
    rows, columns = grid.shape[1:]
    if rows < 2 or columns < 2:
        return np.zeros((0, 3), np.int64)
    sides = {pair: _distance(grid, *pair) for pair in _SIDES}
    across = _either(sides["00", "01"], sides["10", "11"])
    down = _either(sides["00", "10"], sides["01", "11"])
    directions = (across, down, sides["01", "10"], sides["00", "11"])
    across, down, *slants = _pitches(directions)
    limits = dict(zip(_SIDES, (across, across, down, down, *slants), strict=True))
    area = across * down / 2.0
    whole = {pair: sides[pair] <= limit / _STEEPEST for pair, limit in limits.items()}
    kept = [_kept(grid, whole, one, area) for one in _TRIANGLES]
    pairs = _chosen(kept, sides["01", "10"], sides["00", "11"])
    index = np.arange(rows * columns, dtype=np.int64).reshape(rows, columns)
    return np.concatenate(
        [
            np.stack([_corner(index, name)[mask] for name in one], axis=1)
            for one, mask in zip(_TRIANGLES, pairs, strict=True)
        ]
    )


def _chosen(kept: list[Bools], one: Floats, other: Floats) -> list[Bools]:
    """Choose a diagonal for each quad: the one that leaves more triangles, then the shorter one."""
    first, second = kept[0].astype(int) + kept[1], kept[2].astype(int) + kept[3]
    by_length = np.nan_to_num(one, nan=np.inf) <= np.nan_to_num(other, nan=np.inf)
    here = (first > second) | ((first == second) & by_length)
    return [kept[0] & here, kept[1] & here, kept[2] & ~here, kept[3] & ~here]


def _corner(grid: NDArray[_Number], name: str) -> NDArray[_Number]:
    """Return the given corner of every quad of a grid."""
    row, column = _CORNERS[name]
    rows, columns = grid.shape[-2:]
    return grid[..., row : rows - 1 + row, column : columns - 1 + column]


def _distance(grid: Floats, one: str, other: str) -> Floats:
    """Return the distance between two corners of every quad."""
    return _length(_corner(grid, one) - _corner(grid, other))


def _length(vectors: Floats | tuple[Floats, ...]) -> Floats:
    """Return the lengths of vectors, given by their three components."""
    x, y, z = vectors
    length: Floats = np.sqrt(x * x + y * y + z * z)
    return length


def _kept(grid: Floats, whole: dict[Side, Bools], triangle: tuple[str, ...], area: Floats) -> Bools:
    """Tell for every quad whether its triangle spans no jump and is not seen at a grazing angle."""
    a, b, c = triangle
    edges = [whole[min(p, q), max(p, q)] for p, q in ((a, b), (b, c), (c, a))]
    origin = _corner(grid, a)
    (ux, uy, uz), (vx, vy, vz) = _corner(grid, b) - origin, _corner(grid, c) - origin
    double = _length((uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx))
    small: Bools = (double > 0.0) & (double <= 2.0 * area / _STEEPEST)
    return edges[0] & edges[1] & edges[2] & small


def _either(one: Floats, other: Floats) -> Floats:
    """Return one of two distances in the same direction, where there is any."""
    return np.where(np.isnan(one), other, one)


def _pitches(directions: Sequence[Floats]) -> list[Floats]:
    """Return what the distances in each direction would be seen face to face, for every quad."""
    seen = [one[~np.isnan(one)] for one in directions]
    usual = [float(np.quantile(one, _FACE_TO_FACE)) if len(one) else np.nan for one in seen]
    relative = [one / (size or np.nan) for one, size in zip(directions, usual, strict=True)]
    factor = _by_tiles(np.fmin.reduce(relative))
    return [size * factor for size in usual]


def _by_tiles(factor: Floats) -> Floats:
    """Return the median of each tile and its neighbours; 1 where a tile sees too little."""
    rows, columns = factor.shape
    tall, wide = -(-rows // _TILE), -(-columns // _TILE)
    padded = np.full((tall * _TILE, wide * _TILE), np.nan)
    padded[:rows, :columns] = factor
    tiles = np.sort(padded.reshape(tall, _TILE, wide, _TILE).swapaxes(1, 2).reshape(tall, wide, -1), axis=2)
    count = np.count_nonzero(~np.isnan(tiles), axis=2)
    median = np.take_along_axis(tiles, np.maximum(count - 1, 0)[:, :, None] // 2, axis=2)[:, :, 0]
    median = np.where(count >= _FEW, median, 1.0)
    smooth = median_filter(median, size=3, mode="nearest")  # for a tile that sees stray pixels
    return np.repeat(np.repeat(smooth, _TILE, axis=0), _TILE, axis=1)[:rows, :columns]
