"""The other legal readings of closed curves that cross: tangent curves, and one curve with waists.

A sample does not say how its curves go on where they cross. Colour the faces that the curves cut out of
the plane like a checkerboard, the outside white. Either the black faces part at the crossings, and their
outlines are closed curves that touch there and nowhere cross (Fig. 11b); or all black faces that hang
together are joined at just as many crossings as it takes, and their outline is one closed curve, with a
wasp waist at each of these crossings (Fig. 11c).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.truth.intersections import crossings

__all__ = ["Reading", "Readings", "readings"]

Floats = NDArray[np.float64]
Polyline = tuple[Floats, bool]
Reading = Literal["through", "split", "waist"]


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What is right when closed curves are not to cross.

    Attributes
    ----------
    split : tuple of (M, 2) arrays
        The outlines of the black faces: closed curves, none of which touches itself. A face that meets
        itself at a crossing has an outer and an inner outline.
    waist : int
        The number of closed curves with wasp waists: one for all curves that hang together.
    """

    split: tuple[Floats, ...]
    waist: int

    def count(self, mode: str) -> int:
        """Return the number of curves in the reading 'split' or 'waist'."""
        return {"split": len(self.split), "waist": self.waist}[mode]


def readings(polylines: Sequence[Polyline]) -> Readings | None:
    """Return the readings without crossings; None when a curve is open or lies in space.

    Parameters
    ----------
    polylines : sequence of ((M, d) vertices, closed)

    Examples
    --------
    >>> bow = np.array([(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)])
    >>> both = readings([(bow, True)])
    >>> len(both.split), both.waist
    (2, 1)
    """
    if any(not closed or vertices.shape[1] != 2 for vertices, closed in polylines):
        return None
    groups = _connected(polylines)
    outlines = [one for group in groups for one in _outlines(group)]
    return Readings(tuple(outlines), len(groups))


def _connected(polylines: Sequence[Polyline]) -> list[list[Floats]]:
    """Group the curves that hang together by crossings."""
    count = len(polylines)
    i, j = crossings(polylines).curves.T
    _, label = connected_components(
        coo_array((np.ones(len(i)), (i, j)), shape=(count, count)), directed=False
    )
    groups: list[list[Floats]] = [[] for _ in range(label.max() + 1)]
    for (vertices, _), group in zip(polylines, label, strict=True):
        groups[group].append(vertices)
    return groups


def _outlines(rings: Sequence[Floats]) -> list[Floats]:
    """Return the outlines of the black faces of curves that hang together."""
    noded = shapely.union_all([shapely.linearrings(ring) for ring in rings])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    black = [face for face, one in zip(faces, inside, strict=True) if _is_black(one, rings)]
    return [shapely.get_coordinates(ring)[:-1] for face in black for ring in (face.exterior, *face.interiors)]


def _is_black(place: Floats, rings: Sequence[Floats]) -> bool:
    """Tell whether a ray from the place crosses the rings an odd number of times."""
    count = 0
    for ring in rings:
        (x, y), (u, v) = ring.T, np.roll(ring, -1, axis=0).T
        spans = (y > place[1]) != (v > place[1])
        at = x[spans] + (place[1] - y[spans]) / (v[spans] - y[spans]) * (u[spans] - x[spans])
        count += int(np.sum(at > place[0]))
    return count % 2 == 1
