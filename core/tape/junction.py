"""Junctions of the skeleton: nodes merged into crossings, and their arms paired (§5.2).

An X crossing of two tapes has no node of degree four: its skeleton has two nodes of degree
three with a bar between them, short or, at a small angle, with the samples of both branches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from core.refine.polyline import Polyline
from core.tape.graph import Graph, GraphEdge

__all__ = ["Arm", "ArmKey", "Junction", "junctions", "merged", "paired"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
ArmKey = tuple[int, int]  # edge, and which of its ends

MERGE = 1.6  # of the sum of two nodes' disc radii: shorter bars belong to a crossing
TINY = 0.5  # of that sum: forks this near are one, however many
DOUBLE = 1.5  # times the density of the arms: two branches share a bar
LONGEST = 12.0  # of the sum of disc radii: no bar is longer
TRIM = 1.0  # disc radii of an arm that belong to the junction
TANGENT = 2.5  # disc radii from the node to where the parabola of an arm ends
ALL_PAIRINGS = 7  # arms up to which every pairing is tried


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An edge's end at a junction.

    Attributes
    ----------
    key : ArmKey
    place : (2,) array
        Where the arm leaves the junction's disc.
    inward : (2,) array
        Unit direction there, towards the junction.
    trimmed : float
        Length between the node and that place.
    """

    key: ArmKey
    place: Floats
    inward: Floats
    trimmed: float


@dataclass(frozen=True, slots=True, eq=False)
class Junction:
    """Merged nodes: the largest of their disc radii, and the arms that leave them."""

    radius: float
    arms: tuple[Arm, ...]


def junctions(graph: Graph, samples: Floats) -> tuple[list[Junction], NDArray[np.bool_]]:
    """Merge nodes that belong to one crossing.

    Parameters
    ----------
    graph : Graph
    samples : (E,) array
        How many samples each edge has.

    Returns
    -------
    list of Junction
    bars : (E,) array of bool
        Edges inside a junction.
    """
    bars, label = _groups(graph, samples)
    radius = _largest(label, graph.radius)
    arms: list[list[Arm]] = [[] for _ in radius]
    for number in np.flatnonzero(~bars).tolist():
        for end in (0, 1):
            node = graph.edges[number].ends[end]
            arms[int(label[node])].append(_arm(graph.edges[number], (number, end), float(graph.radius[node])))
    return [Junction(float(r), tuple(a)) for r, a in zip(radius, arms, strict=True)], bars


def merged(graph: Graph, samples: Floats) -> Graph:
    """Make one node of each junction, which all its arms reach.

    Parameters
    ----------
    graph : Graph
    samples : (E,) array
        How many samples each edge has.
    """
    bars, label = _groups(graph, samples)
    radius = _largest(label, graph.radius)
    size = np.bincount(label).astype(np.float64)
    places = np.column_stack([np.bincount(label, graph.places[:, k]) for k in (0, 1)]) / size[:, None]
    edges = []
    for edge, bar in zip(graph.edges, bars, strict=True):
        if not bar:
            a, b = (int(label[node]) for node in edge.ends)
            # A node of one alone is where its edges end already.
            head, tail = [a] if size[a] > 1 else [], [b] if size[b] > 1 else []
            course = np.concatenate([places[head], edge.places, places[tail]])
            edges.append(GraphEdge((a, b), course, np.concatenate([radius[head], edge.radius, radius[tail]])))
    return Graph(places, radius, tuple(edges))


def _groups(graph: Graph, samples: Floats) -> tuple[NDArray[np.bool_], Ints]:
    """The bars, and for each node the junction that it belongs to."""
    bars = _bars(graph, samples)
    size = len(graph.places)
    links = coo_matrix((np.ones(int(bars.sum())), _ends(graph)[bars].T), shape=(size, size))
    return bars, connected_components(links, directed=False)[1].astype(np.int64)


def _largest(label: Ints, radius: Floats) -> Floats:
    out = np.zeros(int(label.max(initial=-1)) + 1)
    np.maximum.at(out, label, radius)
    return out


def _ends(graph: Graph) -> Ints:
    return np.array([edge.ends for edge in graph.edges], np.int64).reshape(-1, 2)


def _bars(graph: Graph, samples: Floats) -> NDArray[np.bool_]:
    """Edges between forks that are short, or have the samples of two branches."""
    ends = _ends(graph)
    length = np.array([edge.length for edge in graph.edges])
    reach = graph.radius[ends].sum(axis=1)
    forks = (graph.degree[ends] >= 3).all(axis=1)
    beside, way = np.zeros(len(graph.places)), np.zeros(len(graph.places))
    for side in (0, 1):
        np.add.at(beside, ends[:, side], samples)
        np.add.at(way, ends[:, side], length)
    others = beside[ends].sum(axis=1) - 2.0 * samples
    due = others / np.maximum(way[ends].sum(axis=1) - 2.0 * length, 1e-300) * length
    shared = (samples > DOUBLE * due + np.sqrt(np.maximum(due, 0.0))) & (length < LONGEST * reach)
    wanted = forks & ((length < MERGE * reach) | (shared & (ends[:, 0] != ends[:, 1])))
    return _one_a_fork(ends, length / np.maximum(reach, 1e-300), wanted)


def _one_a_fork(ends: Ints, length: Floats, wanted: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Of the wanted bars the shortest of each fork, and all that are tiny: a crossing has one bar."""
    bars = wanted & (length < TINY)
    taken = set(ends[bars].ravel().tolist())
    for k in np.argsort(length, kind="stable"):
        pair = ends[k].tolist()
        if wanted[k] and not bars[k] and taken.isdisjoint(pair):
            bars[k] = True
            taken.update(pair)
    return bars


def _arm(edge: GraphEdge, key: ArmKey, radius: float) -> Arm:
    """The arm's tangent where it leaves the disc, of the parabola through three places on it."""
    line = edge.line if key[1] == 0 else Polyline(edge.line.vertices[::-1], False)
    length = line.length
    near, far = min(TRIM * radius, 0.2 * length), min(TANGENT * radius, 0.45 * length)
    p, q, r = line.at(np.array([near, 0.5 * (near + far), far]))[:, :2]
    inward = 3.0 * p - 4.0 * q + r
    return Arm(key, p, inward / max(float(np.hypot(*inward)), 1e-300), near)


def paired(junction: Junction) -> list[tuple[ArmKey, ArmKey]]:
    """Pair the arms so that curves go on as straight as they can; of an odd number one is left.

    Parameters
    ----------
    junction : Junction
    """
    arms = junction.arms
    size = len(arms)
    cost = np.zeros((size, size))
    for a in range(size):
        for b in range(a):
            cost[a, b] = cost[b, a] = _bend(arms[a], arms[b], junction.radius)
    pairs = _cheapest(tuple(range(size)), cost)[1] if size <= ALL_PAIRINGS else _greedy(cost)
    return [(arms[a].key, arms[b].key) for a, b in pairs]


def _bend(a: Arm, b: Arm, radius: float) -> float:
    """Squared angles by which two arms fall short of one straight line: of directions, and of offset."""
    turn = _angle(-float(a.inward @ b.inward))
    chord = b.place - a.place
    gap = float(np.hypot(*chord))
    if gap <= 1e-12 * radius:
        return turn**2
    off = _angle(float(a.inward @ chord) / gap) ** 2 + _angle(-float(b.inward @ chord) / gap) ** 2
    return turn**2 + gap / (gap + radius) * off


def _angle(cosine: float) -> float:
    return float(np.arccos(min(max(cosine, -1.0), 1.0)))


def _cheapest(rest: tuple[int, ...], cost: Floats) -> tuple[float, list[tuple[int, int]]]:
    """The pairing of least total cost, by trying all."""
    if len(rest) < 2:
        return 0.0, []
    first, others = rest[0], rest[1:]
    options = []
    for partner in others:
        total, pairs = _cheapest(tuple(x for x in others if x != partner), cost)
        options.append((total + cost[first, partner], [(first, partner), *pairs]))
    if len(rest) % 2:
        options.append(_cheapest(others, cost))
    return min(options, key=lambda option: option[0])


def _greedy(cost: Floats) -> list[tuple[int, int]]:
    """The cheapest pairs first."""
    pairs = []
    left = set(range(len(cost)))
    for a, b in zip(*np.unravel_index(np.argsort(cost, axis=None), cost.shape), strict=True):
        if a != b and left.issuperset((a, b)):
            pairs.append((int(a), int(b)))
            left -= {a, b}
    return pairs
