"""Curves read straight through the skeleton graph (§4.5, 5.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.refine.polyline import Polyline
from core.tape.graph import Graph
from core.tape.junction import ArmKey, junctions, paired

__all__ = ["straight_through"]

Floats = NDArray[np.float64]


def straight_through(graph: Graph, samples: Floats) -> list[Polyline]:
    """Follow the graph straight on at every junction.

    Parameters
    ----------
    graph : Graph
    samples : (E,) array
        How many samples each edge has.

    Returns
    -------
    list of Polyline
        In the plane z = 0. An arm that no other continues ends at its junction.
    """
    if not graph.edges:
        return []
    merged, bars = junctions(graph, samples)
    partner: dict[ArmKey, ArmKey] = {}
    trimmed: dict[ArmKey, float] = {}
    for junction in merged:
        if len(junction.arms) < 2:
            continue
        if len(junction.arms) > 2:
            trimmed |= {arm.key: arm.trimmed for arm in junction.arms}
        for a, b in paired(junction):
            partner[a], partner[b] = b, a
    edges = np.flatnonzero(~bars).tolist()
    free = [(k, end) for k in edges for end in (0, 1) if (k, end) not in partner]
    used: set[int] = set()
    heads = free + [(k, 0) for k in edges]
    return [_follow(graph, key, partner, trimmed, used) for key in heads if key[0] not in used]


def _follow(
    graph: Graph, key: ArmKey, partner: dict[ArmKey, ArmKey], trimmed: dict[ArmKey, float], used: set[int]
) -> Polyline:
    """From one end of an edge on, until a free end or the start is reached."""
    first, parts = key, []
    while True:
        number, end = key
        used.add(number)
        parts.append(_course(graph, number, end, trimmed))
        leaving = (number, 1 - end)
        if leaving not in partner:
            return _polyline(parts, closed=False)
        key = partner[leaving]
        if key[0] in used:
            return _polyline(parts, closed=key == first)


def _course(graph: Graph, number: int, end: int, trimmed: dict[ArmKey, float]) -> Floats:
    """An edge's places from one end to the other, without what its junctions took."""
    line = graph.edges[number].line
    low, high = trimmed.get((number, 0), 0.0), line.length - trimmed.get((number, 1), 0.0)
    stations = line.stations
    inner = stations[(stations > low) & (stations < high)]
    course = line.at(np.concatenate([[low], inner, [high]]))
    return course if end == 0 else course[::-1]


def _polyline(parts: list[Floats], closed: bool) -> Polyline:
    """One polyline without repeated places."""
    x = np.concatenate(parts)
    x = x[np.append(True, np.any(x[1:] != x[:-1], axis=1))]
    return Polyline(x[:-1] if closed and len(x) > 3 and np.all(x[0] == x[-1]) else x, closed)
