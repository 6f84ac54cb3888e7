"""The regions of all levels: what their contours enclose, by the even-odd rule, on one grid.

Nested contours are holes and islands; the levels at both ends are followed by empty ones, so that
caps are slabs like all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from core.errors import DegenerateInput, InvalidInput
from core.results import Curve, Warn
from core.surface.linework import Grid, Linework, linework_of
from core.surface.results import ContourLevel

__all__ = ["Regions", "regions_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_VERTICES = 3
CLOSED_ENOUGH = 0.1  # of an open curve's length: a gap that is closed by a straight edge
LARGEST = 1e60  # beyond it, or its inverse, products of coordinates overflow
STRAIGHT = 1e-9  # of the loop's extent: vertices less far from a straight line show nothing
ALIKE = 8.0  # grid units
RESOLVED = 1e-9  # of the extent: levels closer to each other are one


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """Borders of the regions of all levels, the empty ones at both ends included.

    Attributes
    ----------
    lines : Linework
        Not yet noded.
    heights : (K + 2,) array
        Increasing.
    grid : Grid
    warnings : tuple of Warn
    """

    lines: Linework
    heights: Floats
    grid: Grid
    warnings: tuple[Warn, ...]

    def coarser(self) -> Regions:
        """The same on a grid of four times the pitch."""
        ends = np.rint(self.lines.ends / 4.0).astype(np.int64)
        some = np.any(ends[:, 0] != ends[:, 1], axis=1)
        lines = Linework(ends[some], self.lines.level[some], self.lines.gated[some])
        return replace(self, lines=lines, grid=Grid(self.grid.origin, 4.0 * self.grid.pitch))


def regions_of(levels: Sequence[ContourLevel], axes: Floats) -> Regions:
    """Regions of contour levels in any order.

    Parameters
    ----------
    levels : sequence of ContourLevel
        Curves of (M, 2) vertices in the planes' axes, or of (M, 3) in place.
    axes : (3, 3) array
        Rows: the planes' two axes and the direction of the heights.

    Raises
    ------
    InvalidInput
        Two levels of one height, or numbers too large to be computed with.
    DegenerateInput
        Fewer than two levels, or no closed contour.
    """
    _check_size(levels)
    order = np.argsort([level.height for level in levels], kind="stable")
    heights = np.array([levels[k].height for k in order], float)
    warnings: list[Warn] = []
    loops: list[Floats] = []
    owners: list[int] = []
    for place, k in enumerate(order):
        for curve in levels[k].curves:
            loop = _loop(curve, heights[place], axes, warnings)
            if loop is not None:
                loops.append(loop)
                owners.append(place + 1)
    _check(heights, loops)
    grid = Grid.over(np.concatenate(loops))
    lines = linework_of(_repeated([grid.snapped(_corners(loop)) for loop in loops], owners), owners)
    return Regions(lines, _with_ends(heights), grid, tuple(warnings))


def _loop(curve: Curve, height: float, axes: Floats, warnings: list[Warn]) -> Floats | None:
    """The curve in its plane, closed; None for one left out."""
    vertices = curve.vertices
    flat = vertices if vertices.shape[1] == 2 else vertices @ axes[:2].T
    if curve.closed:
        return flat if len(flat) >= LEAST_VERTICES else None
    middle = np.append(flat.mean(axis=0), height) @ axes
    gap = float(np.hypot(*(flat[-1] - flat[0])))
    if len(flat) >= LEAST_VERTICES and gap <= CLOSED_ENOUGH * curve.length:
        message = (
            f"At height {height:.6g}, a contour is open by {gap:.3g}; it was closed with a straight edge."
        )
        warnings.append(Warn("contour-closed", message, tuple(middle.tolist())))
        return flat
    message = (
        f"At height {height:.6g}, a contour is open by {gap:.3g} of its length {curve.length:.3g}; left out."
    )
    warnings.append(Warn("open-contour", message, tuple(middle.tolist())))
    return None


def _corners(loop: Floats) -> Floats:
    """The loop without vertices on straight stretches: on walls, each would be a node of all levels."""
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    size = np.ptp(loop, axis=0).max() * np.hypot(*(before + after).T)
    turn: Floats = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    straight = (turn <= STRAIGHT * size) & ((before * after).sum(axis=1) > 0.0)
    corners: Floats = loop[~straight]
    return corners


def _repeated(loops: list[Ints], owners: list[int]) -> list[Ints]:
    """The loops on the grid, where one hardly differs from one of the level before, that one again.

    Else, along upright walls, the nodes of each level would pass on to all others.
    """
    out: list[Ints] = []
    by_level: dict[int, list[Ints]] = {}
    for loop, owner in zip(loops, owners, strict=True):
        same = next((other for other in by_level.get(owner - 1, ()) if _alike(loop, other)), loop)
        by_level.setdefault(owner, []).append(same)
        out.append(same)
    return out


def _alike(loop: Ints, other: Ints) -> bool:
    """Whether two loops are the same but for a few units of the grid."""
    boxes = [np.concatenate((each.min(axis=0), each.max(axis=0))) for each in (loop, other)]
    if min(len(loop), len(other)) < LEAST_VERTICES or np.abs(boxes[0] - boxes[1]).max() > ALIKE:
        return False
    return _is_along(loop, other) and _is_along(other, loop)


def _is_along(loop: Ints, other: Ints) -> bool:
    """Whether all vertices of a loop lie within a few units of another one."""
    ring = shapely.linearrings(other)
    shapely.prepare(ring)
    return bool(shapely.dwithin(ring, shapely.points(loop), ALIKE).all())


def _check_size(levels: Sequence[ContourLevel]) -> None:
    values = [np.array([level.height for level in levels], float)]
    values += [curve.vertices.ravel() for level in levels for curve in level.curves]
    if not np.abs(np.concatenate(values)).max(initial=0.0) < LARGEST:  # nor when it is NaN
        raise InvalidInput("Coordinates of contours must be finite and smaller than 1e60.", ("contours",))


def _check(heights: Floats, loops: list[Floats]) -> None:
    if len(heights) < 2:
        raise DegenerateInput("A surface needs at least two levels.", ("contours",))
    if not loops or np.ptp(np.concatenate(loops), axis=0).max() == 0.0:
        raise DegenerateInput("No closed contour encloses anything.", ("contours",))
    places = np.concatenate(loops)
    extent = max(np.ptp(heights), np.ptp(places, axis=0).max())
    if np.ptp(places, axis=0).max() < RESOLVED * np.abs(places).max():
        raise InvalidInput(
            "Contours this far from the origin are not resolved by their numbers.", ("contours",)
        )
    if extent < 1.0 / LARGEST or np.diff(heights).min() <= RESOLVED * extent:
        raise InvalidInput("Levels must have different heights.", ("contours",), "equal-heights")


def _with_ends(heights: Floats) -> Floats:
    """One more level at each end, as far away as the nearest one."""
    return np.concatenate(([2 * heights[0] - heights[1]], heights, [2 * heights[-1] - heights[-2]]))
