"""Meshes cut by parallel planes (§5.1.1, step ii).

A vertex on a plane counts as below it (symbolic perturbation), so that every
triangle crosses a plane along one segment or not at all, and the edges of a
closed mesh are crossed in pairs: closed meshes give closed polylines, and
nothing is special. Which planes a triangle crosses follows from the ranks of
its vertices among the heights of the planes; segments are linked where they
leave one triangle and enter the next by the same edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from core.errors import InvalidInput, InvalidParameter
from core.surface.axis import AxisFrame, axis_frame
from core.surface.levels import level_heights
from core.surface.parameters import SliceParameters
from core.surface.results import Mesh, Slice

__all__ = ["slices_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

_MOST = 10_000_000  # crossings of planes and triangles
_DETAIL = 0.01  # of the extent: samples of a contour lie no further apart, for any mesh

# For the pattern 1 a + 2 b + 4 c of the vertices above the plane: where, counter-clockwise, the first
# vertex of the edge lies that comes down through the plane, and of the one that goes up.
_DOWN = np.array([0, 0, 1, 1, 2, 0, 2, 0])
_UP = np.array([0, 2, 0, 2, 1, 1, 0, 0])


@dataclass(frozen=True, slots=True, eq=False)
class _Segments:
    """Where triangles cross planes: ``level`` (S,), nodes at start and end (S, 2), places of nodes (M, 3)."""

    level: Ints
    nodes: Ints
    places: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Spans:
    """Planes below each vertex; planes below each triangle, and how many cross it."""

    rank: Ints
    lowest: Ints
    count: Ints


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """Polylines by level: vertices of all (M, 3), where each starts (P + 1,), closed and level (P,)."""

    points: Floats
    starts: Ints
    closed: Bools
    level: Ints


def slices_of(meshes: Sequence[Mesh], parameters: SliceParameters | None = None) -> tuple[Slice, ...]:
    """Cut meshes by parallel planes; every plane cuts all of them.

    Parameters
    ----------
    meshes : sequence of Mesh
        Open or closed, of any number of parts. Polylines have the inside of outward-oriented faces on
        their left, seen from the tip of the axis.
    parameters : SliceParameters, optional
        By default planes across z, as far apart as the samples.

    Returns
    -------
    tuple of Slice
        One for each height, ascending, in the coordinates of the meshes; empty where nothing is cut.
        ``points`` are the vertices of its polylines, and on long segments further ones.

    Raises
    ------
    InvalidInput
        When there is no triangle, a vertex is not finite, or a face names a vertex that is not there.
    InvalidParameter
        When the planes are too many.

    Examples
    --------
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> slices = slices_of([Mesh(corners, faces)], SliceParameters(heights=(0.25, 0.5)))
    >>> [(one.height, len(one.polylines[0]), one.closed) for one in slices]
    [(0.25, 3, (True,)), (0.5, 3, (True,))]
    """
    parameters = parameters or SliceParameters()
    for k, mesh in enumerate(meshes):
        _check(mesh, k)
    if not any(len(mesh.faces) for mesh in meshes):
        raise InvalidInput("There is no triangle to slice.", ("meshes",))
    frame = axis_frame(parameters.axis)
    heights = [frame.heights(mesh.vertices) for mesh in meshes]
    planes = level_heights(meshes, heights, parameters)
    spans = [_spans(mesh, some, planes) for mesh, some in zip(meshes, heights, strict=True)]
    _check_work(spans, parameters)
    cuts = [_cut(*one, planes, frame) for one in zip(meshes, heights, spans, strict=True)]
    segments = _joined(cuts)
    extent = max(float(np.ptp(mesh.vertices, axis=0).max()) for mesh in meshes if len(mesh.vertices))
    spacing = float(np.median(np.diff(planes))) if len(planes) > 1 else 0.0
    return _slices(planes, _linked(segments), max(_DETAIL * extent, spacing))


def _check(mesh: Mesh, index: int) -> None:
    """Refuse what cannot be cut, with its place."""
    if not np.isfinite(mesh.vertices).all():
        row = int(np.argwhere(~np.isfinite(mesh.vertices))[0, 0])
        raise InvalidInput("This vertex is not finite.", ("meshes", index, "vertices", row))
    if len(mesh.faces) and not 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices):
        wrong = (mesh.faces < 0) | (mesh.faces >= len(mesh.vertices))
        row = int(np.argwhere(wrong)[0, 0])
        raise InvalidInput("This face names a vertex that is not there.", ("meshes", index, "faces", row))


def _spans(mesh: Mesh, heights: Floats, planes: Floats) -> _Spans:
    """Rank the vertices of a mesh among the planes, and its triangles."""
    rank = np.searchsorted(planes, heights, side="left")  # planes below the vertex, its own not among them
    a, b, c = (rank[mesh.faces[:, k]] for k in range(3))
    lowest = np.minimum(np.minimum(a, b), c)
    return _Spans(rank, lowest, np.maximum(np.maximum(a, b), c) - lowest)


def _check_work(spans: Sequence[_Spans], parameters: SliceParameters) -> None:
    """Refuse more crossings than memory has room for, before room is made for them."""
    if sum(int(one.count.sum()) for one in spans) > _MOST:
        given = [name for name in ("levels", "heights") if getattr(parameters, name) is not None]
        raise InvalidParameter(
            f"The planes cross the triangles more than {_MOST} times in all; give fewer planes.",
            ("parameters", *(given or ["spacing"])),
        )


def _cut(mesh: Mesh, heights: Floats, spans: _Spans, planes: Floats, frame: AxisFrame) -> _Segments:
    """Cut one mesh by all planes."""
    crossed = np.flatnonzero(spans.count)
    count = spans.count[crossed]
    triangle = np.repeat(crossed, count)
    level = np.repeat(spans.lowest[crossed] - (np.cumsum(count) - count), count) + np.arange(len(triangle))
    a, b, c = (spans.rank[mesh.faces[triangle, k]] for k in range(3))
    pattern = (a > level) + 2 * (b > level) + 4 * (c > level)
    corners = np.stack((_DOWN[pattern], _UP[pattern]), axis=1)
    one, other = (mesh.faces[triangle[:, None], ends] for ends in (corners, (corners + 1) % 3))
    low, high = np.minimum(one, other), np.maximum(one, other)
    edges = low * len(mesh.vertices) + high
    if len(mesh.vertices) ** 2 * len(planes) > np.iinfo(np.int64).max:
        edges = np.unique(edges, return_inverse=True)[1].reshape(-1, 2)
    _, first, node = np.unique(edges * len(planes) + level[:, None], return_index=True, return_inverse=True)
    ends = np.column_stack((low.ravel()[first], high.ravel()[first]))
    places = _places(mesh.vertices, heights, ends, planes[level[first // 2]], frame)
    return _Segments(level, node.reshape(-1, 2), places)


def _places(vertices: Floats, heights: Floats, edges: Ints, planes: Floats, frame: AxisFrame) -> Floats:
    """Return where edges cross planes, in the plane to the last bit but rounding."""
    low, high = heights[edges[:, 0]], heights[edges[:, 1]]
    share = ((planes - low) / (high - low))[:, None]
    places = (1.0 - share) * vertices[edges[:, 0]] + share * vertices[edges[:, 1]]
    result: Floats = places + (planes - frame.heights(places))[:, None] * frame.axes[2]
    return result


def _joined(parts: Sequence[_Segments]) -> _Segments:
    """Put the segments of all meshes together."""
    offsets = np.cumsum([0, *(len(one.places) for one in parts)])
    return _Segments(
        np.concatenate([one.level for one in parts]),
        np.concatenate([one.nodes + offset for one, offset in zip(parts, offsets, strict=False)]),
        np.concatenate([one.places for one in parts]),
    )


def _linked(segments: _Segments) -> _Lines:
    """Link the segments, level by level, without vertices that repeat the one before.

    Edges that meet on a plane are crossed in one place; what is left with one vertex, or closed with two,
    is where a plane touches.
    """
    from core.surface.linking import link  # noqa: PLC0415 # numba, which requests need not import

    level = np.zeros(len(segments.places), np.int64)
    level[segments.nodes[:, 0]] = segments.level
    chains, starts, closed = link(segments.nodes, len(segments.places))
    points = segments.places[chains]
    differs = np.any(points != points[_before(starts)], axis=1)
    differs[starts[:-1][~closed]] = True
    sizes = np.add.reduceat(differs, starts[:-1]) if len(closed) else np.zeros(0, np.int64)
    kept = np.flatnonzero(sizes > 1 + closed)
    kept = kept[np.argsort(level[chains[starts[kept]]], kind="stable")]
    points, ends = points[differs], np.cumsum(sizes)
    return _Lines(
        points[_ranges((ends - sizes)[kept], sizes[kept])],
        np.concatenate(([0], np.cumsum(sizes[kept]))),
        closed[kept],
        level[chains[starts[kept]]],
    )


def _before(starts: Ints) -> Ints:
    """Return for each vertex of polylines the one before it; before the first one comes the last."""
    before = np.arange(starts[-1]) - 1
    before[starts[:-1]] = starts[1:] - 1
    return before


def _ranges(starts: Ints, sizes: Ints) -> Ints:
    """Return the indices start, start + 1, ... of all ranges, one after another."""
    offsets = np.cumsum(sizes) - sizes
    return np.repeat(starts - offsets, sizes) + np.arange(int(sizes.sum()))


def _slices(planes: Floats, lines: _Lines, longest: float) -> tuple[Slice, ...]:
    """Hand the polylines, and samples of them, to their levels."""
    samples, number = _sampled(lines, longest)
    bounds = np.searchsorted(lines.level, np.arange(len(planes) + 1))
    firsts = np.concatenate(([0], np.cumsum(number)))[lines.starts]
    parts = [lines.points[a:b] for a, b in pairwise(lines.starts.tolist())]
    rings = lines.closed.tolist()
    return tuple(
        Slice(float(height), samples[firsts[a] : firsts[b]], tuple(parts[a:b]), tuple(rings[a:b]))
        for height, (a, b) in zip(planes, pairwise(bounds.tolist()), strict=True)
    )


def _sampled(lines: _Lines, longest: float) -> tuple[Floats, Ints]:
    """Return samples of polylines no further apart than ``longest``, and their number for each segment.

    They are the vertices, and equally spaced ones between those that are further apart; the last
    vertex of an open polyline counts as a segment of its own.
    """
    after = np.arange(1, len(lines.points) + 1)
    after[lines.starts[1:] - 1] = np.where(lines.closed, lines.starts[:-1], lines.starts[1:] - 1)
    step = lines.points[after] - lines.points
    length = np.sqrt(np.einsum("ij,ij->i", step, step))
    number = np.maximum(np.ceil(length / longest), 1.0).astype(np.int64)
    segment = np.repeat(np.arange(len(number)), number)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(number) - number, number)) / number[segment]
    return lines.points[segment] + share[:, None] * step[segment], number
