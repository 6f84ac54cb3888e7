"""Regions that touch themselves at points: a narrow band along the borders there is cut out of them.

A border that passes twice through a point bounds no 2-manifold. The band is a few units of the grid
wide, far less than any sample spacing; borders that leave the point side by side need a longer one.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from core.surface.linework import Linework, borders_of, node_keys
from core.surface.overlay import area_of

__all__ = ["cut_apart"]

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


WIDTH, WIDER = (
    2.0,
    1.5,
)  # grid units on either side of the border; for each further attempt so many times more
REACH = 4.0  # grid units along it; for each further attempt so many times more


def cut_apart(lines: Linework, attempt: int) -> tuple[Linework, Bools]:
    """The noded borders of regions cut at their touching points, and which edges are new.

    Attempts are counted from 0; later ones cut further.
    """
    width, reach = WIDTH * WIDER**attempt, REACH ** (1 + attempt)
    level, point = _touching(lines)
    kind = 4 * lines.level + lines.gated @ np.array((2, 1))
    kept = np.ones(len(lines), np.bool_)
    cut = lines.taken(~kept)
    order = np.argsort(kind, kind="stable")
    for one in np.unique(kind[np.isin(lines.level, level)]):
        # Contours that the similarity gate treats alike; the others of the level do not touch them.
        mine = order[slice(*np.searchsorted(kind[order], (one, one + 1)))]
        around = point[level == one // 4]
        squares = shapely.union_all(shapely.box(*(around - reach).T, *(around + reach).T))
        area = area_of(lines, mine)
        band = shapely.buffer(shapely.intersection(shapely.boundary(area), squares), width, quad_segs=1)
        rest = shapely.difference(area, band)
        kept[mine] = False
        cut = cut.joined(borders_of(rest, int(one // 4), lines.gated[mine[0]]))
    lines = lines.taken(kept).joined(cut)
    return lines, np.arange(len(lines)) >= np.count_nonzero(kept)


def _touching(lines: Linework) -> tuple[Ints, Ints]:
    """Levels and points (M, 2) where more than two edges of a level end, some more than once."""
    level, node = np.repeat(lines.level, 2), node_keys(lines.ends).ravel()
    order = np.lexsort((node, level))
    first, third = order[:-2], order[2:]
    many = third[(node[first] == node[third]) & (level[first] == level[third])]
    return level[many], lines.ends.reshape(-1, 2)[many]
