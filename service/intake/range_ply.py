"""Range images as Stanford PLY range grids, and the ``.conf`` files that hold their poses.

A range grid has ``obj_info num_cols`` and ``num_rows``, its points as the element
``vertex``, and an element ``range_grid`` with one list for each pixel, row by
row: empty for a hole, or the index of the vertex that the pixel saw.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from core.surface.results import Pose, RangeImage
from service.intake.errors import IntakeError, refuse
from service.intake.ply import Element, Header, broken, read_header

__all__ = ["HOLES", "decode_conf", "decode_range_ply", "is_range_ply"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HOLES = 4
"""Pixels without a point that count as one point: range grids are mostly holes."""

_GRID = "range_grid"
_MAX_CONF = 1_000_000  # bytes: thousands of scans


def is_range_ply(body: bytes) -> bool:
    """Tell whether a body is a PLY file with a range grid; a mesh has none."""
    try:
        return body.startswith(b"ply") and _GRID in read_header(body).names
    except IntakeError:
        return False


def decode_range_ply(body: bytes, pose: Pose | None = None, max_points: int | None = None) -> RangeImage:
    """Read a PLY range grid, as text or binary of either order of bytes.

    Parameters
    ----------
    body : bytes
    pose : Pose, optional
        Where the scan stands; from its ``.conf`` file.
    max_points : int, optional
        How many points it may have, and four times as many pixels.

    Returns
    -------
    RangeImage
        Points (num_rows, num_cols, 3), NaN where there are none.

    Raises
    ------
    IntakeError
        400 for a body that is no such file or is cut off, 413 for too many points, 422 for points that
        are not finite or indices of points that are not there.
    """
    header = read_header(body)
    rows, columns = _size(header)
    points = max(header.elements[0].count, rows * columns // HOLES)
    if max_points is not None and points > max_points:
        detail = f"{points} points, {HOLES} holes counting as one, are more than the {max_points} allowed"
        raise refuse("too-many-points", detail)
    vertices, pixels = _text(body, header) if header.order == "" else _binary(body, header)
    if not np.isfinite(vertices).all():
        where = int(np.argwhere(~np.isfinite(vertices))[0, 0])
        raise _wrong(f"vertex {where} is not finite", "finite_number")
    if pixels.max() >= len(vertices):
        raise _wrong("a pixel names a vertex that is not there", "index_out_of_range")
    grid = np.full((rows * columns, 3), np.nan)
    seen = pixels >= 0
    grid[seen] = vertices[pixels[seen]]
    return RangeImage(grid.reshape(rows, columns, 3), pose)


def decode_conf(body: bytes) -> dict[str, Pose]:
    """Read the poses of scans from a ``.conf`` file: lines ``bmesh name tx ty tz qx qy qz qw``.

    The quaternion is that of the motion back, as in the Stanford repository: a point p of a scan
    lies at R(q)^T p + t. Lines of cameras are passed over.

    Returns
    -------
    dict of str to Pose
        By the names of the files.

    Raises
    ------
    IntakeError
        400 for anything but text, 422 with its line for a pose that cannot be read.
    """
    if len(body) > _MAX_CONF:
        raise refuse("too-many-bytes", f"a .conf file has at most {_MAX_CONF} bytes")
    try:
        text = body.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise refuse("unreadable-body", "the .conf file is not text", ("body",), "charset_invalid") from None
    poses: dict[str, Pose] = {}
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if words and words[0] in {"bmesh", "mesh"}:
            poses[words[1] if len(words) > 1 else ""] = _pose(words[2:], number)
        elif words and words[0] != "camera":
            raise _unposed(number)
    return poses


def _pose(words: list[str], line: int) -> Pose:
    """Make a pose of a translation and the conjugated quaternion."""
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        raise _unposed(line) from None
    if len(numbers) != 7 or not np.isfinite(numbers).all():
        raise _unposed(line)
    largest = float(np.abs(numbers[3:]).max())
    if largest == 0.0:
        raise _unposed(line)
    quaternion = numbers[3:] / largest
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    forth = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    return Pose(forth.T.copy(), numbers[:3])


def _unposed(line: int) -> IntakeError:
    detail = f"line {line} of the .conf file is not 'bmesh name tx ty tz qx qy qz qw' with finite numbers"
    return refuse("invalid-input", detail, ("body", "conf", line - 1), "conf_invalid")


def _wrong(reason: str, code: str) -> IntakeError:
    return refuse("invalid-points", f"in the range grid {reason}", ("body", "range_images", "points"), code)


def _size(header: Header) -> tuple[int, int]:
    """Return rows and columns; check them with the elements."""
    try:
        rows, columns = int(header.info["num_rows"]), int(header.info["num_cols"])
    except (KeyError, ValueError):
        raise broken("it names no num_rows and num_cols") from None
    if header.names != ["vertex", _GRID]:
        raise broken("a range grid has the elements vertex and range_grid, in this order")
    vertex, grid = header.elements
    if vertex.has_lists or not {"x", "y", "z"} <= {one.name for one in vertex.properties}:
        raise broken("a vertex needs the properties x, y and z, and no lists")
    if len({one.name for one in vertex.properties}) != len(vertex.properties):
        raise broken("two properties have one name")
    if len(grid.properties) != 1 or not grid.has_lists or _is_float(grid):
        raise broken("a range_grid has one property, a list of integers")
    if rows < 1 or columns < 1 or rows * columns != grid.count:
        raise broken("num_rows times num_cols is not the number of range_grid rows")
    return rows, columns


def _is_float(grid: Element) -> bool:
    lengths = grid.properties[0].length
    return grid.properties[0].dtype.kind == "f" or (lengths is not None and lengths.kind == "f")


def _text(body: bytes, header: Header) -> tuple[Floats, Ints]:
    """Read the data of a text file: vertices, and the vertex of each pixel."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy only warns of text that is no number
        try:
            numbers = np.fromstring(body[header.start :].decode("ascii"), np.float64, sep=" ")
        except (ValueError, DeprecationWarning):
            raise broken("its data are not all numbers") from None
    vertex, grid = header.elements
    names = [one.name for one in vertex.properties]
    size = vertex.count * len(names)
    if len(numbers) < size:
        raise broken("it is cut off")
    table = numbers[:size].reshape(vertex.count, len(names))
    lists = numbers[size:]
    if not np.all((np.floor(lists) == lists) & (np.abs(lists) < 2.0**53)):
        raise broken("its range_grid is not all integers")
    integers = lists.astype(np.int64)
    starts = _starts(integers, 1, 1, grid.count, len(integers))
    seen = integers[starts] > 0
    pixels = np.full(grid.count, -1, np.int64)
    pixels[seen] = _named(integers[starts[seen] + 1])
    return table[:, [names.index(axis) for axis in "xyz"]], pixels


def _binary(body: bytes, header: Header) -> tuple[Floats, Ints]:
    """Read the data of a binary file: vertices, and the vertex of each pixel."""
    vertex, grid = header.elements
    if len(body) < header.start + vertex.count * vertex.row.itemsize:
        raise broken("it is cut off")
    table = np.frombuffer(body, vertex.row, vertex.count, header.start)
    vertices = np.stack([table[axis].astype(np.float64) for axis in "xyz"], axis=1)
    index, length = grid.properties[0].dtype, grid.properties[0].length
    assert length is not None  # noqa: S101 # has_lists said so
    rest = np.frombuffer(body, np.uint8, offset=header.start + table.nbytes)
    if len(rest) > grid.count * (length.itemsize + index.itemsize):
        raise broken("a pixel has more than one vertex, or more bytes follow")
    counts = _at(rest, np.arange(max(len(rest) - length.itemsize + 1, 0)), length)
    starts = _starts(counts, length.itemsize, index.itemsize, grid.count, len(rest))
    seen = counts[starts] > 0
    pixels = np.full(grid.count, -1, np.int64)
    pixels[seen] = _named(_at(rest, starts[seen] + length.itemsize, index))
    return vertices, pixels


def _at(octets: NDArray[np.uint8], places: Ints, dtype: np.dtype[np.generic]) -> Ints:
    """Read the integers that begin at these places."""
    rows = octets[places[:, None] + np.arange(dtype.itemsize)]
    return np.asarray(rows.view(dtype).ravel(), np.int64)


def _starts(counts: Ints, head: int, step: int, rows: int, size: int) -> Ints:
    """Return where each of ``rows`` lists begins, the next one after the last item of the one before.

    Where the next list would begin is known at every place; jumps of 1, 2, 4 ... lists are composed of
    those of half as many, so that there is no loop over lists. Lists have one item at most, and
    the last one ends at ``size``.
    """
    jump = np.full(size + 2, size + 1)
    jump[: len(counts)] = np.where(counts == 0, head, np.where(counts == 1, head + step, size + 1))
    jump[: len(counts)] += np.arange(len(counts))
    np.minimum(jump, size + 1, out=jump)
    starts = np.zeros(1, np.int64)
    while len(starts) <= rows:
        starts = np.concatenate((starts, jump[starts]))
        jump = jump[jump]
    if starts[rows] != size:
        raise broken("its range_grid is cut off, has more than one vertex a pixel, or more follows")
    return starts[:rows]


def _named(indices: Ints) -> Ints:
    """Return the indices of vertices, none of which may be negative: -1 stands for a hole here."""
    if (indices < 0).any():
        raise _wrong("a pixel names a vertex that is not there", "index_out_of_range")
    return indices
