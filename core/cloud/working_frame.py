"""The coordinates in which a component is worked on, and the way back (§4.1).

Centred, isotropically scaled and, when the component is worked on in its best plane,
rigidly turned so that this plane is z = 0 and projected onto it. One layout, (N, 3),
serves the plane and space alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.points import Normalisation, centred

__all__ = ["WorkingFrame", "working_frame"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class WorkingFrame:
    """A similarity from input space to working space, which may mirror.

    Attributes
    ----------
    way : Normalisation
        Centre and scale.
    axes : (3, 3) array
        Rows are the working axes in the centred input space; the identity for 2D input that is not turned.
    dimension : int
        Of the input, 2 or 3.
    flat : bool
        Whether the working points lie in z = 0.
    """

    way: Normalisation
    axes: Floats
    dimension: int
    flat: bool

    @property
    def scale(self) -> float:
        """Length in input units of one working unit."""
        return self.way.scale

    @property
    def mirrored(self) -> bool:
        """Whether the way back turns counter-clockwise rings into clockwise ones."""
        return bool(np.linalg.det(self.axes) < 0.0)

    def restore(self, places: Floats) -> Floats:
        """Bring (M, 3) working coordinates back to (M, d) input coordinates."""
        return self.way.restore((places @ self.axes)[:, : self.dimension])


def working_frame(
    points: Floats, axes: Floats, flat: bool, turned: bool = False
) -> tuple[Floats, WorkingFrame]:
    """Bring a component to working coordinates.

    Parameters
    ----------
    points : (N, d) array
    axes : (3, 3) array
        Principal axes of the component, the plane's normal last.
    flat : bool
        Whether to project on the best plane. 2D input always lies in a plane.
    turned : bool
        Whether 2D input too is turned to its principal axes, and flat input so that both point to where
        the points reach farther (positive skewness). What depends on the axes, such as the corners of a
        buffer, is then the same for a rotated or mirrored point set.

    Returns
    -------
    (N, 3) array
        Working coordinates: centred, root mean square one per coordinate of the input.
    WorkingFrame
        The way back.
    """
    unit, way = centred(points)
    if points.shape[1] == 2:
        axes = axes if turned else np.eye(3)
        unit, flat = np.concatenate([unit, np.zeros((len(unit), 1))], axis=1), True
        if not turned:
            return unit, WorkingFrame(way, axes, 2, flat)
    work = unit @ axes.T
    if flat:
        work[:, 2] = 0.0
    if flat and turned and float(np.sum(work[:, 1] ** 3)) < 0.0:
        work[:, 1] *= -1.0
        axes = axes * np.array([[1.0], [-1.0], [1.0]])
    return work, WorkingFrame(way, axes, points.shape[1], flat)
