"""Which contours of neighbouring levels are connected: the similarity gate of Ruiz et al. (2005).

Two parts a, c of neighbouring regions that overlap are connected when they share enough of the
smaller one's area, |a and c| >= tau min(|a|, |c|). Where some overlap is refused, an intermediate
level holds the overlaps that are accepted: what is refused ends in caps below and above it.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.surface.linework import Linework, borders_of, node_keys
from core.surface.overlay import area_of

__all__ = ["gated"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

ROUNDING = 1e-9  # of an area
NEITHER = np.zeros(2, np.bool_)


def gated(lines: Linework, count: int, similarity: float) -> Linework:
    """Noded borders with intermediate levels: level k becomes 2 k, and 2 k + 1 lies above it.

    Parameters
    ----------
    lines : Linework
        Noded, no region touching itself.
    count : int
        Number of levels.
    similarity : float
        Least share of the smaller area, above 0.

    Returns
    -------
    Linework
        To be noded again, two levels far.
    """
    flags = lines.gated.copy()
    parts = [_parts(lines, mine) for mine in lines.by_level(count)]
    between = []
    for k in range(count - 1):
        (lower, edges_below), (upper, edges_above) = parts[k], parts[k + 1]
        refused_below, refused_above, shared = _gate(lower, upper, similarity)
        flags[_of(edges_below, refused_below), 1] = True
        flags[_of(edges_above, refused_above), 0] = True
        between += [borders_of(part, 2 * k + 1, NEITHER) for part in shared]
    out = Linework(lines.ends, 2 * lines.level, flags)
    for each in between:
        out = out.joined(each)
    return out


def _parts(lines: Linework, mine: Ints) -> tuple[NDArray[np.object_], list[Ints]]:
    """The connected parts of a level's region, and the edges of each."""
    parts = shapely.get_parts(area_of(lines, mine))
    keys = np.sort(node_keys(lines.ends[mine]), axis=1)
    index = {(int(a), int(b)): int(edge) for (a, b), edge in zip(keys, mine, strict=True)}
    edges = []
    for part in parts:
        border = np.sort(node_keys(borders_of(part, 0, NEITHER).ends), axis=1)
        edges.append(np.array([index[int(a), int(b)] for a, b in border], np.int64))
    return parts, edges


def _gate(
    lower: NDArray[np.object_], upper: NDArray[np.object_], similarity: float
) -> tuple[Bools, Bools, NDArray[np.object_]]:
    """Parts below and above that hang together with a refused overlap, and their accepted overlaps."""
    below, above = shapely.STRtree(upper).query(lower, predicate="intersects")
    shared = shapely.intersection(lower[below], upper[above])
    area = shapely.area(shared)
    below, above, shared, area = (x[area > 0.0] for x in (below, above, shared, area))
    least = np.minimum(shapely.area(lower[below]), shapely.area(upper[above]))
    refused = area < similarity * least * (1.0 - ROUNDING)
    total = len(lower) + len(upper)
    links = coo_array((np.ones(len(below)), (below, len(lower) + above)), (total, total))
    block = connected_components(links, directed=False)[1]
    concerned = np.isin(block, block[below[refused]])
    kept = concerned[below] & ~refused
    return concerned[: len(lower)], concerned[len(lower) :], shared[kept]


def _of(edges: list[Ints], which: Bools) -> Ints:
    """The edges of some parts."""
    return np.concatenate([np.zeros(0, np.int64), *(edges[k] for k in np.flatnonzero(which))])
