"""Where a picture's paper lies: the plane that a result is projected on before it is drawn, and the eye."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["paper_of", "three_quarter"]

Floats = NDArray[np.float64]
_ABOVE_FRONT_RIGHT = np.array([0.30, -0.45, 0.84])  # from where one looks, when both sides would do
_ASIDE, _ABOVE = np.radians(30.0), np.radians(25.0)


def three_quarter(frame: Floats, above: float = _ABOVE) -> Floats:
    """Return the rows right, up and towards the eye, of a look at a thing from its front right and above.

    Parameters
    ----------
    frame : (3, 3) array
        The thing's own axes: its right, its back and what points up.
    above : float
        Elevation of the eye, in radians.
    """
    (sin_a, cos_a), (sin_e, cos_e) = (np.sin(_ASIDE), np.cos(_ASIDE)), (np.sin(above), np.cos(above))
    right = [cos_a, sin_a, 0.0]
    up = [-sin_a * sin_e, cos_a * sin_e, cos_e]
    eye = [sin_a * cos_e, -cos_a * cos_e, sin_e]
    rows: Floats = np.array([right, up, eye]) @ frame
    return rows


def paper_of(sets: Iterable[Floats]) -> Callable[[Floats], Floats]:
    """Return the projection of (N, d) arrays on the paper, the same for all of them.

    Parameters
    ----------
    sets : iterable of (N, d) arrays
        All that is to be drawn; d = 2 or 3.

    Returns
    -------
    callable
        (N, d) array to (N, 2) array. In 2D nothing changes; in 3D the paper is
        the best plane of all the points (least squares, §3.1), turned so that
        z, or else y, points up.
    """
    arrays = [array for array in sets if len(array)]
    if not arrays or arrays[0].shape[1] == 2:
        return lambda points: points
    points = np.concatenate(arrays)
    centre = points.mean(axis=0)
    axes = _axes(_normal(points - centre))
    return lambda points: (points - centre) @ axes.T


def _normal(offsets: Floats) -> Floats:
    """Direction of least variance."""
    extent = np.abs(offsets).max()
    scaled = offsets / extent if extent > 0 else offsets  # squares neither overflow nor vanish
    normal: Floats = np.linalg.eigh(scaled.T @ scaled)[1][:, 0]
    return normal if normal @ _ABOVE_FRONT_RIGHT > 0 else -normal


def _axes(normal: Floats) -> Floats:
    """Rows right and up, of a paper with this normal."""
    upright = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    up = upright - (upright @ normal) * normal
    up /= np.linalg.norm(up)
    return np.array([np.cross(up, normal), up])
