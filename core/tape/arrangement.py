"""The arrangement of curves in a plane: nodes where they cross, arcs between, and the faces they bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline
from core.tape.contacts import contacts

__all__ = ["FREE", "Arc", "Arrangement", "Node", "arrange"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FREE = -1  # the node of a free end
ONE_PLACE = 1e-7  # of the extent: crossings nearer than this are one node
COMPACT = 3.0  # times the distance of merging: the largest extent of what is merged
LOOP = 4.0  # times the distance of merging: a loop no longer than this is lost in its node


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A stretch of a curve between two nodes, of which either may be ``FREE``.

    Its two arms, that is its ends seen from their nodes, are numbered twice the arc's number
    (at the first vertex) and one more (at the last).

    Attributes
    ----------
    vertices : (M, 3) array
        From node to node, both included.
    nodes : (int, int)
    curve : int
        The curve that it is part of.
    closed : bool
        Whether that curve is closed.
    ending : (bool, bool)
        Whether its curve ends on another one at that node.
    """

    vertices: Floats
    nodes: tuple[int, int]
    curve: int
    closed: bool
    ending: tuple[bool, bool]

    @property
    def line(self) -> Polyline:
        """The arc as an open curve."""
        return Polyline(self.vertices, False)


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A place where curves cross, or where one ends on another.

    Attributes
    ----------
    place : (3,) array
    arms : tuple of int
        The arms that pass through, counter-clockwise; an even number.
    ending : tuple of int
        Arms of curves that end here.
    """

    place: Floats
    arms: tuple[int, ...]
    ending: tuple[int, ...]

    @property
    def degree(self) -> int:
        """Number of arms."""
        return len(self.arms) + len(self.ending)

    @property
    def arcs(self) -> tuple[int, ...]:
        """The arc of each arm; one that returns occurs twice."""
        return tuple(arm // 2 for arm in self.arms + self.ending)


@dataclass(frozen=True, slots=True, eq=False)
class Arrangement:
    """Nodes and arcs; ``uncut`` lists the curves without a node."""

    nodes: tuple[Node, ...]
    arcs: tuple[Arc, ...]
    uncut: tuple[int, ...]

    @property
    def connected(self) -> Ints:
        """(A,) for each arc the number of the connected part that it belongs to.

        A curve that only ends on another is not connected with it.
        """
        pairs = [(arm // 2, node.arms[0] // 2) for node in self.nodes for arm in node.arms[1:]]
        return _components(np.array(pairs, np.int64).reshape(-1, 2), len(self.arcs))


@dataclass(frozen=True, slots=True)
class _Passage:
    """A curve at a node, from one station to another."""

    begin: float
    end: float
    node: int


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Where the nodes are, how far what belongs to them may be off, and how long a loop is lost in them.

    Places within ``near`` are one.
    """

    near: float
    place: Floats
    spread: Floats
    lost: Floats


def arrange(curves: Sequence[Polyline], touching: float = 0.0, merging: float = 0.0) -> Arrangement:
    """Cut curves in the plane z = 0 where they cross, and where one ends on another.

    Parameters
    ----------
    curves : sequence of Polyline
    touching : float
        An open curve that ends within this distance of another curve, or of a far part of itself,
        ends on it, on whichever side.
    merging : float
        Crossings within this distance of each other become one node, unless there is a crowd of them.
    """
    extent = max((float(np.ptp(line.vertices, axis=0).max()) for line in curves), default=0.0)
    near = ONE_PLACE * extent
    touching, merging = max(touching, near), max(merging, near)
    met = contacts(curves, touching)
    if not met:
        return Arrangement((), (), tuple(range(len(curves))))
    nodes, places = _clustered(np.array([contact.place for contact in met]), near, merging)
    passages: list[list[tuple[float, int]]] = [[] for _ in curves]
    for contact, node in zip(met, nodes, strict=True):
        for k, station in zip(contact.curves, contact.stations, strict=True):
            passages[k].append((station, int(node)))
    arcs: list[Arc] = []
    for k, line in enumerate(curves):
        if passages[k]:
            arcs += _arcs(line, k, _passages(passages[k], line, places), places, touching)
    uncut = tuple(k for k in range(len(curves)) if not passages[k])
    return Arrangement(_nodes(places.place, arcs), tuple(arcs), uncut)


def _clustered(where: Floats, near: float, merging: float) -> tuple[Ints, _Places]:
    """Give the node of each contact: those that are near each other share one."""
    tree = cKDTree(where)
    fine, coarse = (
        _components(tree.query_pairs(reach, output_type="ndarray"), len(where)) for reach in (near, merging)
    )
    crowd = _spread(where, coarse) > 0.5 * COMPACT * merging
    _, node = np.unique(np.where(crowd[coarse], fine + len(where), coarse), return_inverse=True)
    lost = np.full(node.max() + 1, LOOP * merging)
    lost[node[crowd[coarse]]] = LOOP * near
    spread = np.maximum(near, 1.5 * _spread(where, node))
    return np.asarray(node, np.int64), _Places(near, _means(where, node), spread, lost)


def _means(where: Floats, node: Ints) -> Floats:
    sums = np.stack([np.bincount(node, column) for column in where.T], axis=1)
    return np.asarray(sums / np.bincount(node)[:, None], np.float64)


def _spread(where: Floats, node: Ints) -> Floats:
    """Largest distance of the members of each node from their mean."""
    out = np.zeros(node.max() + 1)
    np.maximum.at(out, node, np.linalg.norm(where - _means(where, node)[node], axis=1))
    return out


def _components(pairs: Ints, count: int) -> Ints:
    """Numbers of the connected components of a graph."""
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], np.int64)


def _passages(stations: list[tuple[float, int]], line: Polyline, places: _Places) -> list[_Passage]:
    """Passages in order along the curve; one that soon returns to its node is one with the last."""
    out: list[_Passage] = []
    for s, node in sorted(stations):
        if out and out[-1].node == node and s - out[-1].end <= places.lost[node]:
            out[-1] = _Passage(out[-1].begin, s, node)
        else:
            out.append(_Passage(s, s, node))
    first, last, length = out[0], out[-1], line.length
    around = first.begin + length - last.end
    if line.closed and len(out) > 1 and first.node == last.node and around <= places.lost[first.node]:
        return [*out[1:-1], _Passage(last.begin, first.end + length, first.node)]
    return out


def _arcs(line: Polyline, k: int, passages: list[_Passage], places: _Places, touching: float) -> list[Arc]:
    """The stretches between passages, and those to the free ends of an open curve."""
    first, last, length = passages[0], passages[-1], line.length
    begins = ends = False
    if line.closed:
        stops = [*passages, _Passage(first.begin + length, first.end + length, first.node)]
    else:
        begins, ends = first.begin <= touching, length - last.end <= touching
        head, tail = _Passage(0.0, 0.0, FREE), _Passage(length, length, FREE)
        stops = [head] * (not begins) + passages + [tail] * (not ends)
    track = _Track.of(line)
    out = []
    for n, (a, b) in enumerate(pairwise(stops)):
        course = track.between(a, b, places)
        if len(course) > 2 or (len(course) == 2 and a.node != b.node):
            ending = (begins and n == 0, ends and n == len(stops) - 2)
            out.append(Arc(course, (a.node, b.node), k, line.closed, ending))
    return out


@dataclass(frozen=True, slots=True, eq=False)
class _Track:
    """The way along a curve, (3, M) and (M,); of a closed one three times around."""

    columns: Floats
    stations: Floats

    @classmethod
    def of(cls, line: Polyline) -> _Track:
        vertices, stations = line.ring, line.stations
        if line.closed:
            vertices = np.concatenate([vertices[:-1], vertices[:-1], vertices])
            stations = np.concatenate([stations[:-1] + turn * line.length for turn in (0, 1)])
            stations = np.concatenate([stations, line.stations + 2.0 * line.length])
        return cls(np.ascontiguousarray(vertices.T), stations)

    def between(self, a: _Passage, b: _Passage, places: _Places) -> Floats:
        """Vertices from node to node, or to a free end."""
        room = (b.begin - a.end) / 3.0
        head, low = self._leave(a.node, a.end, room, places)
        tail, high = self._leave(b.node, b.begin, -room, places)
        inner = slice(
            np.searchsorted(self.stations, low, "left" if a.node == FREE else "right"),
            np.searchsorted(self.stations, high, "right" if b.node == FREE else "left"),
        )
        return np.concatenate([head, self.columns[:, inner].T, tail[::-1]])

    def _leave(self, node: int, station: float, room: float, places: _Places) -> tuple[Floats, float]:
        """First vertices on the way from a node, and the station from where on there are others."""
        if node == FREE:
            return np.zeros((0, 3)), station
        place = places.place[node]
        if np.linalg.norm(self._at(station) - place) <= places.near:
            return place[None], station + float(np.copysign(places.near, room))
        # Where the curve misses its node, it is led there from a little way off.
        beyond = station + float(np.copysign(min(abs(room), places.spread[node]), room))
        return np.stack([place, self._at(beyond)]), beyond

    def _at(self, station: float) -> Floats:
        return np.array([np.interp(station, self.stations, column) for column in self.columns])


def _nodes(places: Floats, arcs: Sequence[Arc]) -> tuple[Node, ...]:
    """Nodes with their arms in order of the directions in which they leave."""
    arms: list[list[tuple[float, int]]] = [[] for _ in places]
    ending: list[list[int]] = [[] for _ in places]
    for k, arc in enumerate(arcs):
        for side in (0, 1):
            if arc.nodes[side] == FREE:
                continue
            if arc.ending[side]:
                ending[arc.nodes[side]].append(2 * k + side)
            else:
                step = arc.vertices[1] - arc.vertices[0] if side == 0 else arc.vertices[-2] - arc.vertices[-1]
                arms[arc.nodes[side]].append((float(np.arctan2(step[1], step[0])), 2 * k + side))
    return tuple(
        Node(place, tuple(arm for _, arm in sorted(around)), tuple(tips))
        for place, around, tips in zip(places, arms, ending, strict=True)
    )
