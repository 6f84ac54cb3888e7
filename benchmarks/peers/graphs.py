"""A graph with straight edges, such as a thinned picture, as curves: no spurs, straight through forks."""

from __future__ import annotations

import warnings
from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import splev, splprep

__all__ = ["Branch", "branches", "curves_of_graph", "smoothed"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Polyline = tuple[Floats, bool]

TURN = np.cos(np.radians(60.0))  # a sharper turn at a fork is not gone through
TIGHT = 3.0  # a loop shorter than this many limits, pi diameters of a spur, is a hole in a broad place


@dataclass(eq=False)
class Branch:
    """A stretch of a graph between two nodes, or a ring: then both nodes are -1, or one node twice."""

    line: Floats
    nodes: tuple[int, int]

    @cached_property
    def length(self) -> float:
        """Length of the line."""
        return float(np.linalg.norm(np.diff(self.line, axis=0), axis=1).sum())

    def ahead(self, end: int, reach: float) -> Floats:
        """Return the unit vector in which the branch leaves its node at an end (0 or 1)."""
        line = self.line if end == 0 else self.line[::-1]
        way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))))
        near, far = (np.array([np.interp(s, way, c) for c in line.T]) for s in (reach / 2, 3 * reach / 2))
        step = far - near if np.any(far != near) else line[-1] - line[0]
        return np.asarray(step / max(float(np.linalg.norm(step)), 1e-300))


def branches(vertices: Floats, edges: Ints) -> list[Branch]:
    """Take a graph apart at its nodes, the vertices that have not just two edges."""
    near: dict[int, list[int]] = defaultdict(list)
    for a, b in {(min(e), max(e)) for e in edges.tolist() if e[0] != e[1]}:
        near[a].append(b)
        near[b].append(a)
    nodes = [v for v in near if len(near[v]) != 2]
    used: set[tuple[int, int]] = set()
    found = []
    for start in [*nodes, *near]:  # rings without a node come last
        for ahead in near[start]:
            if (start, ahead) not in used and (len(near[start]) != 2 or start not in nodes):
                chain = _follow(start, ahead, near, used)
                if chain:
                    ends = (chain[0], chain[-1])
                    ring = len(near[start]) == 2
                    found.append(Branch(vertices[chain], (-1, -1) if ring else ends))
    return found


def _follow(start: int, ahead: int, near: dict[int, list[int]], used: set[tuple[int, int]]) -> list[int]:
    """Walk from a vertex to the next node, or round to where the walk began."""
    chain = [start]
    last, here = start, ahead
    while True:
        if (last, here) in used:
            return []
        used.update(((last, here), (here, last)))
        chain.append(here)
        if len(near[here]) != 2 or here == start:
            return chain
        last, here = here, next(v for v in near[here] if v != last)


def curves_of_graph(vertices: Floats, edges: Ints, limit: float) -> list[Polyline]:
    """Read a graph as curves.

    Parameters
    ----------
    vertices, edges : (V, d) and (E, 2) arrays
    limit : float
        Spurs and bridges between forks that are shorter are none, nor are gaps between loose ends.

    Returns
    -------
    list of ((M, d) vertices, closed)
        A closed curve does not repeat its first vertex.
    """
    if not len(edges):
        return []
    found = _merged(branches(vertices, edges), limit)
    found = _pruned(found, limit)
    found = _without_nodes_of_two([*found, *_bridges(found, limit)])
    return _joined(found, limit)


def _merged(every: list[Branch], limit: float) -> list[Branch]:
    """Make one node of forks with a short bridge between them."""
    degree = _degree(every)
    name = {node: node for node in degree}

    def root(node: int) -> int:
        while name[node] != node:
            node = name[node]
        return node

    place: dict[int, list[Floats]] = defaultdict(list)
    kept, result = [], []
    for one in every:
        a, b = one.nodes
        if a != -1 and min(degree[a], degree[b]) >= 3 and one.length < limit:
            name[root(a)] = root(b)
        else:
            kept.append(one)
    for one in every:
        for end, node in enumerate(one.nodes):
            if node != -1:
                place[root(node)].append(one.line[-end])
    centre = {node: np.mean(places, axis=0) for node, places in place.items()}
    for one in kept:
        if one.nodes[0] != -1:
            a, b = (root(node) for node in one.nodes)
            moved = np.vstack((centre[a], one.line[1:-1], centre[b]))
            result.append(Branch(moved, (a, b)))
        else:
            result.append(one)
    return result


def _degree(every: list[Branch]) -> dict[int, int]:
    degree: dict[int, int] = defaultdict(int)
    for one in every:
        for node in one.nodes:
            degree[node] += 1
    return degree


def _pruned(every: list[Branch], limit: float) -> list[Branch]:
    """Drop what is too short, the shortest first, and join what is left where a node has two ends."""
    every = [one for one in every if one.nodes != (-1, -1) or one.length >= TIGHT * limit]
    while True:
        every = _without_nodes_of_two(every)
        degree, shortest = _degree(every), _shortest(every)
        short = [one for one in every if _is_spur(one, degree, shortest, limit)]
        if not short:
            return every
        first = min(short, key=lambda one: one.length)
        touched = set(first.nodes)
        every.remove(first)
        for one in sorted(short, key=lambda one: one.length):  # others far from it may go at the same time
            if not touched & set(one.nodes):
                every.remove(one)
                touched |= set(one.nodes)


def _shortest(every: list[Branch]) -> dict[tuple[int, int], Branch]:
    """Return the shortest branch between each two nodes."""
    found: dict[tuple[int, int], Branch] = {}
    for one in every:
        ends = (min(one.nodes), max(one.nodes))
        if ends not in found or one.length < found[ends].length:
            found[ends] = one
    return found


def _is_spur(
    one: Branch, degree: dict[int, int], shortest: dict[tuple[int, int], Branch], limit: float
) -> bool:
    first, last = min(one.nodes), max(one.nodes)
    if last == -1:
        return False
    if first == last:
        return one.length < TIGHT * limit
    if min(degree[first], degree[last]) == 1:
        return one.length < limit
    return shortest[first, last] is not one and one.length < TIGHT * limit


def _bridges(every: list[Branch], limit: float) -> list[Branch]:
    """Join loose ends that are each other's nearest and less than a limit apart."""
    degree = _degree(every)
    loose = {node: one.line[-end] for one in every for end, node in enumerate(one.nodes) if degree[node] == 1}
    if len(loose) < 2:
        return []
    names, places = list(loose), np.array(list(loose.values()))
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(gaps, np.inf)
    nearest = gaps.argmin(axis=1)
    return [
        Branch(places[[i, j]], (names[i], names[j]))
        for i, j in enumerate(nearest.tolist())
        if i < j and nearest[j] == i and gaps[i, j] < limit
    ]


def _without_nodes_of_two(every: list[Branch]) -> list[Branch]:
    """Join the two branches that meet where nothing else does."""
    at: dict[int, list[Branch]] = defaultdict(list)
    for one in every:
        for node in one.nodes:
            at[node].append(one)
    kept = dict.fromkeys(every)
    for node in [node for node, here in at.items() if node != -1 and len(here) == 2]:
        first, second = at[node]
        if first is second:  # a ring with a fork that is none
            first.nodes = (-1, -1)
            continue
        there, back = _turned(first, node), _turned(second, node)
        joined = Branch(np.vstack((there.line[::-1], back.line[1:])), (there.nodes[1], back.nodes[1]))
        del kept[first], kept[second]
        kept[joined] = None
        for end in joined.nodes:
            at[end] = [joined if one is first or one is second else one for one in at[end]]
    return list(kept)


def _turned(one: Branch, node: int) -> Branch:
    """Return a branch so that it begins at a node."""
    return one if one.nodes[0] == node else Branch(one.line[::-1], (one.nodes[1], one.nodes[0]))


End = tuple[int, int]


def _joined(every: list[Branch], limit: float) -> list[Polyline]:
    """Pair the branches at each fork, the straightest first, and follow the pairs."""
    partner = _partners(every, limit)
    curves: list[Polyline] = [(one.line[:-1], True) for one in every if one.nodes == (-1, -1)]
    left = {k for k, one in enumerate(every) if one.nodes != (-1, -1)}
    starts = [(k, end) for k in sorted(left) for end in (0, 1) if (k, end) not in partner]
    for start in [*starts, *((k, 0) for k in sorted(left))]:
        if start[0] not in left:
            continue
        pieces, here, closed = [], start, False
        while True:
            left.discard(here[0])
            line = every[here[0]].line if here[1] == 0 else every[here[0]].line[::-1]
            pieces.append(line[:-1])
            out = (here[0], 1 - here[1])
            following = partner.get(out)
            if following is None:
                pieces.append(line[-1:])
                break
            if following == start:
                closed = True
                break
            here = following
        curves.append((np.vstack(pieces), closed))
    return [(line, closed) for line, closed in curves if len(line) >= (3 if closed else 2)]


def _partners(every: list[Branch], limit: float) -> dict[End, End]:
    at: dict[int, list[End]] = defaultdict(list)
    for k, one in enumerate(every):
        for end, node in enumerate(one.nodes):
            if node != -1:
                at[node].append((k, end))
    partner: dict[End, End] = {}
    for ends in at.values():
        ways = np.array([every[k].ahead(end, limit) for k, end in ends])
        straight = -ways @ ways.T
        order = [(i, j) for i in range(len(ends)) for j in range(i) if straight[i, j] >= TURN]
        for i, j in sorted(order, key=lambda pair: -straight[pair]):
            if ends[i] not in partner and ends[j] not in partner:
                partner[ends[i]], partner[ends[j]] = ends[j], ends[i]
    return partner


def smoothed(curves: list[Polyline], tolerance: float) -> list[Polyline]:
    """Replace polylines by cubic smoothing splines whose vertices move by the tolerance, in the RMS."""
    result = []
    for line, closed in curves:
        ring = np.vstack((line, line[:1])) if closed else line
        ring = ring[np.concatenate(([True], np.any(np.diff(ring, axis=0) != 0, axis=1)))]
        if len(ring) < 5:
            result.append((line, closed))
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # a tolerance hardly reached is near enough
            knots, _ = splprep(ring.T, s=len(ring) * tolerance**2, per=closed, quiet=2)
        count = int(np.clip(4 * len(ring), 200, 4000))
        dense = np.column_stack(splev(np.linspace(0.0, 1.0, count, endpoint=not closed), knots))
        result.append((dense if np.all(np.isfinite(dense)) else line, closed))
    return result
