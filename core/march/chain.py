"""Sparse, clean samples: a curve through neighbours, where balls hold too few samples to march.

Each sample is linked to its nearest neighbour, and to the nearest one on the other side
(the NN-crust of Dey & Kumar 1999, right for closed curves sampled densely against their
local feature size). The links count only when they form clean chains: no sample with three
links, and few sharp turns. Noise makes them zigzag, and the answer is then None.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline

__all__ = ["MOST_SAMPLES", "chain_neighbours"]

Floats = NDArray[np.float64]

MOST_SAMPLES = 400
NEIGHBOURS = 12
LONGEST = 3.0  # a link to the other side, in units of the typical or the own nearest distance
SHARP = np.radians(50.0)
MOST_SHARP = 0.2  # share of vertices that may turn sharply: corners, not noise
LEAST_CHAINED = 0.9
LEAST_VERTICES = 5


def chain_neighbours(points: Floats) -> list[Polyline] | None:
    """Link samples to curves through all of them.

    Parameters
    ----------
    points : (N, 3) array

    Returns
    -------
    list of Polyline or None
        None when the links make no clean chains.
    """
    distinct = np.unique(points, axis=0)
    if not LEAST_VERTICES <= len(distinct) <= MOST_SAMPLES:
        return None
    links = _links(distinct)
    degree = np.bincount(links.ravel(), minlength=len(distinct))
    if degree.max(initial=0) > 2:
        return None
    chains = [_trace(distinct, links, members) for members in _groups(links, len(distinct))]
    chains = [chain for chain in chains if len(chain.vertices) >= LEAST_VERTICES]
    if sum(len(chain.vertices) for chain in chains) < LEAST_CHAINED * len(distinct):
        return None
    turns = np.concatenate([_turns(chain) for chain in chains])
    return chains if np.mean(turns > SHARP) <= MOST_SHARP else None


def _links(points: Floats) -> NDArray[np.int64]:
    """(L, 2) indices: each sample's nearest neighbour, and its nearest one beyond a right angle."""
    found = cKDTree(points).query(points, min(NEIGHBOURS, len(points)))
    distance, index = np.asarray(found[0]), np.asarray(found[1])
    offset = points[index[:, 1:]] - points[:, None]
    opposite = np.einsum("ijk,ik->ij", offset, offset[:, 0]) <= 0.0
    typical = float(np.median(distance[:, 1]))
    opposite &= distance[:, 1:] <= LONGEST * np.maximum(distance[:, 1:2], typical)
    rows = np.arange(len(points))
    has = opposite.any(axis=1)
    other = index[rows, 1 + np.argmax(opposite, axis=1)]
    pairs = np.concatenate([np.stack([rows, index[:, 1]], 1), np.stack([rows[has], other[has]], 1)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _groups(links: NDArray[np.int64], count: int) -> list[NDArray[np.int64]]:
    """Indices of the samples of each chain."""
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1)


def _trace(points: Floats, links: NDArray[np.int64], members: NDArray[np.int64]) -> Polyline:
    """Walk a chain from one end, or once around."""
    neighbours: dict[int, list[int]] = {int(i): [] for i in members}
    for a, b in links[np.isin(links[:, 0], members)].tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    ends = [i for i, near in neighbours.items() if len(near) < 2]
    course = [ends[0] if ends else int(members[0])]
    seen = set(course)
    while True:
        onward = [i for i in neighbours[course[-1]] if i not in seen]
        if not onward:
            return Polyline(points[course], not ends and len(course) > 2)
        course.append(onward[0])
        seen.add(onward[0])


def _turns(chain: Polyline) -> Floats:
    """Angles by which a chain turns at its inner vertices."""
    steps = np.diff(chain.ring, axis=0)
    steps = np.concatenate([steps, steps[:1]]) if chain.closed else steps
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    return np.asarray(np.arccos(np.clip(np.einsum("ij,ij->i", steps[:-1], steps[1:]), -1.0, 1.0)))
