"""The skeleton as a graph: nodes where it forks or ends, edges with their course and width (§4.5, §7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.refine.polyline import Polyline
from core.tape.medial_axis import MedialAxis

__all__ = ["Graph", "GraphEdge", "skeleton_graph"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ROUNDS = 50  # of leaf pruning; every round removes at most one leaf a junction


@dataclass(frozen=True, slots=True, eq=False)
class GraphEdge:
    """A stretch of the skeleton between two nodes.

    Attributes
    ----------
    ends : (int, int)
        Nodes at its first and last place; the same one twice for a loop.
    places : (M, 2) array
    radius : (M,) array
        Half-width of the tape along it.
    """

    ends: tuple[int, int]
    places: Floats
    radius: Floats

    @property
    def line(self) -> Polyline:
        """Its course in the plane z = 0."""
        return Polyline(np.column_stack([self.places, np.zeros(len(self.places))]), False)

    @property
    def length(self) -> float:
        """Length along its course."""
        return float(np.hypot(*np.diff(self.places, axis=0).T).sum())


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """The skeleton without hair.

    Attributes
    ----------
    places : (K, 2) array
        Nodes. A loop without forks has one node, of degree two.
    radius : (K,) array
        Half-width of the tape there.
    edges : tuple of GraphEdge
    """

    places: Floats
    radius: Floats
    edges: tuple[GraphEdge, ...]

    @property
    def degree(self) -> Ints:
        """(K,) number of edges that end at each node, loops twice."""
        ends = np.array([edge.ends for edge in self.edges], np.int64).ravel()
        return np.bincount(ends, minlength=len(self.places))


def skeleton_graph(axis: MedialAxis, reach: float) -> Graph:
    """Build the graph of the medial axis, short leaves removed.

    A leaf whose disc sticks out of its junction's disc by less than ``reach`` of that disc's
    radius tells of a wiggle of the border, not of a curve.

    Parameters
    ----------
    axis : MedialAxis
    reach : float
        In radii of the disc at the junction.
    """
    edges = axis.edges
    for _ in range(ROUNDS):
        chains, starts = _chains(edges, len(axis.places))
        hair = _short_leaves(axis, edges, chains, starts, reach)
        if not hair.any():
            break
        edges = edges[~hair]
    return _graph_of(axis, chains, starts)


def _short_leaves(
    axis: MedialAxis, edges: Ints, chains: Ints, starts: Ints, reach: float
) -> NDArray[np.bool_]:
    """Which edges lie on short leaves: at each junction the shortest leaf, if it is short enough."""
    hair = np.zeros(len(edges), np.bool_)
    degree = np.bincount(edges.ravel(), minlength=len(axis.places))
    shortest: dict[int, tuple[float, int]] = {}
    for k in range(len(starts) - 1):
        chain = chains[starts[k] : starts[k + 1], 0]
        tip, fork = (chain[0], chain[-1]) if degree[chain[0]] == 1 else (chain[-1], chain[0])
        if degree[tip] != 1 or degree[fork] < 3:
            continue
        length = float(np.hypot(*np.diff(axis.places[chain], axis=0).T).sum())
        out = (length + axis.radius[tip] - axis.radius[fork]) / axis.radius[fork]
        if out < reach and out < shortest.get(int(fork), (np.inf, 0))[0]:
            shortest[int(fork)] = (out, k)
    for _, k in shortest.values():
        hair[chains[starts[k] + 1 : starts[k + 1], 1]] = True
    return hair


def _graph_of(axis: MedialAxis, chains: Ints, starts: Ints) -> Graph:
    """Number the ends of the chains as nodes."""
    courses = [chains[starts[k] : starts[k + 1], 0] for k in range(len(starts) - 1)]
    ends = np.array([(c[0], c[-1]) for c in courses], np.int64).reshape(-1, 2)
    nodes, numbers = np.unique(ends, return_inverse=True)
    numbers = numbers.reshape(-1, 2)
    return Graph(
        axis.places[nodes],
        axis.radius[nodes],
        tuple(
            GraphEdge((int(a), int(b)), axis.places[course], axis.radius[course])
            for (a, b), course in zip(numbers, courses, strict=True)
        ),
    )


@njit(cache=True)
def _chains(edges, count):  # type: ignore[no-untyped-def]
    """Paths between vertices of degree other than two, then loops.

    Rows of the answer are (vertex, edge by which it was reached, -1 at the start of a path).
    """
    starts = np.zeros(count + 1, np.int64)
    for e in range(edges.shape[0]):
        starts[edges[e, 0] + 1] += 1
        starts[edges[e, 1] + 1] += 1
    for v in range(count):
        starts[v + 1] += starts[v]
    cursor = starts[:-1].copy()
    incident = np.empty(2 * edges.shape[0], np.int64)
    for e in range(edges.shape[0]):
        for side in range(2):
            incident[cursor[edges[e, side]]] = e
            cursor[edges[e, side]] += 1
    used = np.zeros(edges.shape[0], np.bool_)
    out = np.empty((2 * edges.shape[0], 2), np.int64)
    bounds = np.zeros(edges.shape[0] + 1, np.int64)
    size, paths = 0, 0
    for loops in range(2):
        for v in range(count):
            degree = starts[v + 1] - starts[v]
            if degree == 0 or (degree == 2) != (loops == 1):
                continue
            for j in range(starts[v], starts[v + 1]):
                e = incident[j]
                if used[e]:
                    continue
                out[size, 0], out[size, 1] = v, -1
                size += 1
                at = v
                while True:
                    used[e] = True
                    at = edges[e, 1] if edges[e, 0] == at else edges[e, 0]
                    out[size, 0], out[size, 1] = at, e
                    size += 1
                    if at == v or starts[at + 1] - starts[at] != 2:
                        break
                    e = incident[starts[at]] if incident[starts[at]] != e else incident[starts[at] + 1]
                paths += 1
                bounds[paths] = size
    return out[:size], bounds[: paths + 1]
