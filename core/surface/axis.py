"""The axis across the planes of a stack, and coordinates in those planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["AxisFrame", "axis_frame"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class AxisFrame:
    """A right-handed orthonormal frame: rows of the (3, 3) array are the plane's x and y, and the axis."""

    axes: Floats

    def heights(self, points: Floats) -> Floats:
        """Return the heights of (N, 3) points along the axis, shape (N,)."""
        heights: Floats = points @ self.axes[2]
        return heights

    def to_plane(self, points: Floats) -> Floats:
        """Return the coordinates in the plane of (N, 3) points, shape (N, 2)."""
        flat: Floats = points @ self.axes[:2].T
        return flat

    def lift(self, flat: Floats, height: float) -> Floats:
        """Return the (N, 3) points in space of (N, 2) points of the plane at a height."""
        points: Floats = flat @ self.axes[:2] + height * self.axes[2]
        return points


def axis_frame(axis: Sequence[float]) -> AxisFrame:
    """Return the frame of an axis of any length but zero.

    It is turned from the frame of the coordinates by the smallest angle, so that the plane's axes
    for the axis z are x and y, exactly.

    Examples
    --------
    >>> axis_frame((0, 0, 2)).to_plane(np.array([[1.0, 2.0, 3.0]]))
    array([[1., 2.]])
    >>> float(axis_frame((0, 3, 4)).heights(np.array([[0.0, 3.0, 4.0]]))[0])
    5.0
    """
    wide = np.asarray(axis, np.float64)
    wide = wide / np.abs(wide).max()  # so that no square overflows or vanishes
    x, y, z = wide / np.linalg.norm(wide)
    if z < 0.0:  # half a turn about the x axis first: the formula below is singular at -z
        return AxisFrame(_turned(x, -y, -z) * _HALF_TURN + 0.0)  # no negative zeros
    return AxisFrame(_turned(x, y, z))


_HALF_TURN = np.array([1.0, -1.0, -1.0])


def _turned(x: float, y: float, z: float) -> Floats:
    """Return the rows of the smallest rotation that takes z to the unit vector (x, y, z), z >= 0."""
    shared = -x * y / (1.0 + z)
    rows = [[1.0 - x * x / (1.0 + z), shared, -x], [shared, 1.0 - y * y / (1.0 + z), -y], [x, y, z]]
    return np.array(rows) + 0.0
