"""The connected components of the graph |p - q| <= epsilon, exactly (§3.3).

A uniform grid whose cells are so small (side just below epsilon / sqrt(d)) that all
points of a cell are connected turns the graph of N points into a graph of occupied
cells: cells at most two apart on every axis are united as soon as one pair of their
points is found within epsilon. Cells are sorted by row and column and never stored
densely, so that epsilon may be as small as it likes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.cloud.points import bounds, inverse_power_of_two, scaled_offset

__all__ = ["components"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Below 1, so that rounding never lets two points of one cell be more than epsilon apart.
SIDE = 1 - 1e-3
# Up to this many cells on an axis, the rounding of a cell's index is far below 1 - SIDE.
MOST_CELLS = 2.0**40
# Cells that may touch lie at most this many apart on every axis: ceil(sqrt(3) / SIDE).
REACH = 2
# Two cells are compared point by point up to this many pairs, and by halving them beyond.
MOST_PAIRS = 512


def components(points: Floats, epsilon: float) -> Ints:
    """Label the connected components of the graph |p - q| <= epsilon.

    Two points are neighbours exactly when ``np.sum((p - q)**2) <= epsilon * epsilon``
    in double precision, ties included. A power of two near epsilon is divided out of
    the differences, which changes no comparison but keeps squares from over- and underflow.

    Parameters
    ----------
    points : (N, d) array, d = 2 or 3
        Finite coordinates, as :func:`core.cloud.points.as_points` returns them.
    epsilon : float
        Longest hop, positive, in the units of the points.

    Returns
    -------
    (N,) array of int
        Labels 0, 1, … in the order in which the components first appear.

    Notes
    -----
    O(N log N) time, at most about 150 bytes a point.

    Examples
    --------
    >>> import numpy as np
    >>> components(np.array([[0.0, 0.0], [5.0, 0.0], [3.0, 4.0], [0.0, 1.0]]), 5.0)
    array([0, 0, 0, 0])
    >>> components(np.array([[0.0, 0.0], [5.0, 0.0], [3.0, 4.0], [0.0, 1.0]]), 4.0)
    array([0, 1, 2, 0])
    """
    unit = inverse_power_of_two(epsilon)
    cells = _occupied_cells(points, unit, SIDE * (epsilon * unit) / math.sqrt(points.shape[1]))
    members = points.take(cells.order, axis=0)
    boxes = _bounds_of_cells(members, cells.starts)
    root = _unite(
        members, cells.starts, boxes, cells.row, cells.column, cells.row_steps(), unit, (epsilon * unit) ** 2
    )
    return np.asarray(_in_order_of_appearance(root, cells.starts, cells.order))


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    """The occupied cells, sorted by (row, column).

    ``points[order[starts[c]:starts[c + 1]]]`` lie in cell c. In 2D a row is one value of x;
    in 3D the rows of consecutive x, ``height`` of them each, follow one another.
    """

    order: Ints
    starts: Ints
    row: Ints
    column: Ints
    height: int | None

    def row_steps(self) -> Ints:
        """Row differences between a cell and those that may touch it and do not come before it."""
        if self.height is None:
            return np.arange(REACH + 1)
        steps = [slab * self.height + row for slab in range(REACH + 1) for row in range(-REACH, REACH + 1)]
        return np.array([step for step in steps if step >= 0])


def _occupied_cells(points: Floats, unit: float, side: float) -> _Cells:
    """Sort the points by cell; ``side`` is the edge of a cell times ``unit``."""
    low, high = bounds(points)
    with np.errstate(over="ignore"):
        count = (high - low) * unit / side + 1
    # Rows of the next slab begin beyond the reach of this one's last rows.
    shape = [float(n) + REACH for n in count]
    if max(shape) > MOST_CELLS or math.prod(shape) > 2.0**62:
        return _cells_of_sparse_points(points, unit, side)
    size = np.array(shape).astype(np.int64)
    keys = _packed_keys(points, low, unit, 1.0 / side, size)
    order = np.argsort(keys)
    keys = keys.take(order)
    starts = _starts(keys[1:] != keys[:-1])
    row, column = np.divmod(keys.take(starts[:-1]), size[-1])
    return _Cells(order, starts, row, column, int(size[1]) if len(size) == 3 else None)


def _cells_of_sparse_points(points: Floats, unit: float, side: float) -> _Cells:
    """Sort the points by cell when the cells are too many to be numbered one by one."""
    index = [_index_along(axis, unit, side) for axis in points.T]
    height = int(index[1].max()) + 1 + REACH if len(index) == 3 else None
    row = index[0] if height is None else index[0] * height + index[1]
    order = np.lexsort((index[-1], row))
    row, column = row.take(order), index[-1].take(order)
    starts = _starts((row[1:] != row[:-1]) | (column[1:] != column[:-1]))
    return _Cells(order, starts, row.take(starts[:-1]), column.take(starts[:-1]), height)


def _index_along(values: Floats, unit: float, side: float) -> Ints:
    """Cell index of each value, gaps that no hop can cross closed up: at most 4 N indices."""
    order = np.argsort(values)
    x = values.take(order)
    with np.errstate(over="ignore"):
        breaks = np.diff(x) * unit > 2 * side
    chain = np.concatenate(([0], np.cumsum(breaks)))
    heads = np.flatnonzero(np.concatenate(([True], breaks)))
    offset = (scaled_offset(x, x[heads].take(chain), unit) / side).astype(np.int64)
    lengths = offset[np.append(heads[1:], len(x)) - 1] + 1 + REACH
    index = np.empty(len(x), np.int64)
    index[order] = offset + (np.cumsum(lengths) - lengths).take(chain)
    return index


def _starts(changes: NDArray[np.bool_]) -> Ints:
    """Where runs begin, and the end of the last, given where an element differs from the one before."""
    return np.concatenate(([0], np.flatnonzero(changes) + 1, [len(changes) + 1]))


@njit(cache=True)
def _packed_keys(points, low, unit, per_side, shape):  # type: ignore[no-untyped-def]
    """Give each point the number of its cell, the last axis fastest."""
    n, d = points.shape
    keys = np.empty(n, np.int64)
    for i in range(n):
        key = 0
        for a in range(d):
            key = key * shape[a] + int((points[i, a] - low[a]) * unit * per_side)
        keys[i] = key
    return keys


@njit(cache=True)
def _bounds(points, start, stop, box):  # type: ignore[no-untyped-def]
    """Write the lower and upper corner of points[start:stop] to ``box``."""
    for a in range(points.shape[1]):
        low = points[start, a]
        high = low
        for i in range(start + 1, stop):
            low = min(low, points[i, a])
            high = max(high, points[i, a])
        box[0, a] = low
        box[1, a] = high


@njit(cache=True)
def _bounds_of_cells(points, starts):  # type: ignore[no-untyped-def]
    """Bounding boxes (C, 2, d) of the points of each cell."""
    boxes = np.empty((len(starts) - 1, 2, points.shape[1]))
    for c in range(len(starts) - 1):
        _bounds(points, starts[c], starts[c + 1], boxes[c])
    return boxes


# Rounding is monotone: no pair of points is computed nearer than _least_distance computes
# their boxes to be, nor farther than _greatest_distance. Pruning by boxes is therefore exact.


@njit(cache=True)
def _least_distance(box, other, unit):  # type: ignore[no-untyped-def]
    """Squared distance between two boxes, times unit squared."""
    total = 0.0
    for a in range(box.shape[1]):
        gap = max(other[0, a] - box[1, a], box[0, a] - other[1, a], 0.0) * unit
        total += gap * gap
    return total


@njit(cache=True)
def _greatest_distance(box, other, unit):  # type: ignore[no-untyped-def]
    """Squared greatest distance between points of two boxes, times unit squared."""
    total = 0.0
    for a in range(box.shape[1]):
        span = max(other[1, a] - box[0, a], box[1, a] - other[0, a]) * unit
        total += span * span
    return total


@njit(cache=True)
def _any_pair(points, start, stop, other_start, other_stop, unit, limit):  # type: ignore[no-untyped-def]
    """Whether any point of one range is within the limit of any of the other, point by point."""
    for i in range(start, stop):
        for j in range(other_start, other_stop):
            total = 0.0
            for a in range(points.shape[1]):
                difference = (points[i, a] - points[j, a]) * unit
                total += difference * difference
            if total <= limit:
                return True
    return False


@njit(cache=True)
def _halve(points, start, stop, axis):  # type: ignore[no-untyped-def]
    """Reorder points[start:stop] so that its lower half along the axis comes first (Hoare's selection)."""
    middle = (start + stop) // 2
    low, high = start, stop - 1
    while low < high:
        pivot = points[(low + high) // 2, axis]
        i, j = low, high
        while i <= j:
            while points[i, axis] < pivot:
                i += 1
            while points[j, axis] > pivot:
                j -= 1
            if i <= j:
                for a in range(points.shape[1]):
                    points[i, a], points[j, a] = points[j, a], points[i, a]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            break
    return middle


@njit(cache=True)
def _longest_side(box):  # type: ignore[no-untyped-def]
    """Axis along which a box extends most, and how far."""
    axis = 0
    for a in range(1, box.shape[1]):
        if box[1, a] - box[0, a] > box[1, axis] - box[0, axis]:
            axis = a
    return axis, box[1, axis] - box[0, axis]


@njit(cache=True)
def _push_halves(points, ranges, boxes, depth, side, axis):  # type: ignore[no-untyped-def]
    """Replace the pair of ranges at ``depth`` of the stack by two, one of its ranges halved."""
    start, stop = ranges[depth, side]
    middle = _halve(points, start, stop, axis)
    ranges[depth + 1] = ranges[depth]
    boxes[depth + 1] = boxes[depth]
    ranges[depth, side, 1] = middle
    ranges[depth + 1, side, 0] = middle
    _bounds(points, start, middle, boxes[depth, side])
    _bounds(points, middle, stop, boxes[depth + 1, side])


@njit(cache=True)
def _touch_crowded(points, ranges, boxes, unit, limit):  # type: ignore[no-untyped-def]
    """Whether the pair of ranges at the bottom of the stack holds a pair of points within the limit.

    Ranges whose boxes do not decide are halved, the one that extends farther first. What
    waits on the stack are disjoint ranges or whole ones: nothing but the order of the
    points within them is disturbed.
    """
    depth = 1
    while depth > 0:
        depth -= 1
        box, other = boxes[depth]
        if _least_distance(box, other, unit) > limit:
            continue
        if _greatest_distance(box, other, unit) <= limit:
            return True
        (a, b), (c, d) = ranges[depth]
        if (b - a) * (d - c) <= MOST_PAIRS:
            if _any_pair(points, a, b, c, d, unit, limit):
                return True
            continue
        axis, extent = _longest_side(box)
        other_axis, other_extent = _longest_side(other)
        if extent >= other_extent:
            _push_halves(points, ranges, boxes, depth, 0, axis)
        else:
            _push_halves(points, ranges, boxes, depth, 1, other_axis)
        depth += 2
    return False


@njit(cache=True)
def _find(parent, i):  # type: ignore[no-untyped-def]
    """Root of i, the path halved on the way."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True)
def _unite(points, starts, boxes, row, column, row_steps, unit, limit):  # type: ignore[no-untyped-def]
    """Root of each cell in the forest of united cells.

    For each difference of rows, the cells within reach form a window that only moves
    forward while the cells are visited in order: no look-up, no hashing.
    """
    count = len(starts) - 1
    parent = np.arange(count)
    window = np.zeros(len(row_steps), np.int64)
    # The stack of pairs of ranges: 2^63 points can be halved 63 times on either side.
    ranges = np.empty((128, 2, 2), np.int64)
    stack = np.empty((128, 2, 2, boxes.shape[2]))
    for c in range(count):
        a, b = starts[c], starts[c + 1]
        for s in range(len(row_steps)):
            target = row[c] + row_steps[s]
            n = c + 1 if s == 0 else window[s]
            while n < count and (row[n] < target or (row[n] == target and column[n] < column[c] - REACH)):
                n += 1
            window[s] = n
            while n < count and row[n] == target and column[n] <= column[c] + REACH:
                mine, its = _find(parent, c), _find(parent, n)
                if mine != its and _least_distance(boxes[c], boxes[n], unit) <= limit:
                    if (b - a) * (starts[n + 1] - starts[n]) <= MOST_PAIRS:
                        near = _any_pair(points, a, b, starts[n], starts[n + 1], unit, limit)
                    else:
                        ranges[0, 0, 0], ranges[0, 0, 1], ranges[0, 1, 0], ranges[0, 1, 1] = (
                            a,
                            b,
                            starts[n],
                            starts[n + 1],
                        )
                        stack[0, 0], stack[0, 1] = boxes[c], boxes[n]
                        near = _touch_crowded(points, ranges, stack, unit, limit)
                    if near:
                        parent[max(mine, its)] = min(mine, its)
                n += 1
    for c in range(count):
        parent[c] = _find(parent, c)
    return parent


@njit(cache=True)
def _in_order_of_appearance(root, starts, order):  # type: ignore[no-untyped-def]
    """Labels of the points, numbered as they first appear, from the roots of their cells."""
    labels = np.empty(len(order), np.int64)
    for c in range(len(root)):
        for i in range(starts[c], starts[c + 1]):
            labels[order[i]] = root[c]
    number = np.full(len(root), -1)
    count = 0
    for i in range(len(labels)):
        r = labels[i]
        if number[r] < 0:
            number[r] = count
            count += 1
        labels[i] = number[r]
    return labels
