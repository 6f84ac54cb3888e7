"""How the arms at each crossing are joined so that no curves cross: the readings of Fig. 11b and 11c."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet

from core.tape.arrangement import FREE, Arrangement
from core.tape.checkerboard import black_sectors

__all__ = ["Join", "Smoothing", "graph_smoothing", "split_smoothing", "waist_smoothing"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Join = tuple[int, int]  # two arms of a node, joined through the sector counter-clockwise of the first
Smoothing = list[list[Join]]  # the joins at each node; joins of one node do not cross each other


def graph_smoothing(arrangement: Arrangement) -> Smoothing:
    """Join nothing but the two arms of a node where nothing else is.

    Parameters
    ----------
    arrangement : Arrangement
    """
    return [_pairs(node.arms, 0) if node.degree == 2 else [] for node in arrangement.nodes]


def split_smoothing(arrangement: Arrangement) -> Smoothing:
    """Join arms so that tangent closed curves arise (Fig. 11b).

    They bound the black faces of a checkerboard with a white unbounded face; where such a face
    touches itself, its outline and its hole are two curves, not one. Stretches that have the same
    face on both sides do not count. Where open curves leave no checkerboard, the crossings
    that can close a curve do, the shortest first.

    Parameters
    ----------
    arrangement : Arrangement
    """
    if not arrangement.arcs:
        return [[] for _ in arrangement.nodes]
    black = black_sectors(arrangement)
    phases = _chosen(arrangement, [_phase(black[list(node.arms)]) for node in arrangement.nodes])
    for k in _self_touches(arrangement, _smoothed(arrangement, phases)):
        phases[k] = 1 - phases[k]
    return _smoothed(arrangement, phases)


def waist_smoothing(arrangement: Arrangement) -> Smoothing:
    """Join arms so that each connected part is one curve (Fig. 11c), or as few as its open curves allow.

    Starting from :func:`split_smoothing`, crossings are switched that merge two curves, those
    with the least sharp turning first.

    Parameters
    ----------
    arrangement : Arrangement
    """
    split = split_smoothing(arrangement)
    if not arrangement.arcs:
        return split
    curves = DisjointSet(range(len(arrangement.arcs)))
    for joins in split:
        for x, y in joins:
            curves.merge(x // 2, y // 2)
    opened = {curves[arm // 2] for arm in _tips(arrangement)}
    switched: list[set[int]] = [set() for _ in split]
    for _, node, k in sorted(_switches(split, _directions(arrangement))):
        one, other = (curves[split[node][i % len(split[node])][0] // 2] for i in (k, k + 1))
        if one == other or (one in opened and other in opened):
            continue
        curves.merge(one, other)
        if one in opened or other in opened:
            opened.add(curves[one])
        switched[node].add(k)
    return [_switched(joins, there) for joins, there in zip(split, switched, strict=True)]


def _smoothed(arrangement: Arrangement, phases: list[int]) -> Smoothing:
    """Join at each node the arms of that parity to the next ones counter-clockwise."""
    return [_pairs(node.arms, phase) for node, phase in zip(arrangement.nodes, phases, strict=True)]


def _pairs(arms: tuple[int, ...], phase: int) -> list[Join]:
    """Neighbouring arms, counter-clockwise from one with that parity."""
    turned = arms[phase:] + arms[:phase]
    return list(zip(turned[::2], turned[1::2], strict=True))


def _tips(arrangement: Arrangement) -> list[int]:
    """Arms that are joined to nothing."""
    free = [
        2 * k + side for k, arc in enumerate(arrangement.arcs) for side in (0, 1) if arc.nodes[side] == FREE
    ]
    return free + [arm for node in arrangement.nodes for arm in node.ending]


def _directions(arrangement: Arrangement) -> Floats:
    """(2 A,) the angle in which each arm leaves its node."""
    ends = np.array([(v[1] - v[0], v[-2] - v[-1]) for v in (arc.vertices for arc in arrangement.arcs)])
    steps = ends.reshape(-1, 3)
    return np.asarray(np.arctan2(steps[:, 1], steps[:, 0]))


def _sharpness(directions: Floats, join: Join) -> float:
    """By how much a join through a sector turns: 0 straight on, pi back."""
    return float(abs(np.pi - (directions[join[1]] - directions[join[0]]) % (2.0 * np.pi)))


# -- waists -----------------------------------------------------------------------------------------


def _switches(split: Smoothing, directions: Floats) -> Iterator[tuple[float, int, int]]:
    """Yield the sharpness, the node and the number of each join that can be merged with the next."""
    for node, joins in enumerate(split):
        if len(joins) > 1:
            for k, (one, other) in enumerate(pairwise([*joins, joins[0]])):
                yield _sharpness(directions, (one[1], other[0])), node, k


def _switched(joins: list[Join], there: set[int]) -> list[Join]:
    """Merge the joins in ``there`` with the next ones.

    Of joins (a, b), (c, d), (e, f) that follow each other, merged are (b, c), (d, e) and (a, f).
    """
    if not there:
        return joins
    count = len(joins)
    out: list[Join] = []
    for first in (k for k in range(count) if (k - 1) % count not in there):
        last = first
        while last % count in there:
            out.append((joins[last % count][1], joins[(last + 1) % count][0]))
            last += 1
        whole = (joins[first][0], joins[last % count][1])
        out.append(whole[::-1] if last - first == count - 1 else whole)
    return out


# -- tangent closed curves --------------------------------------------------------------------------


def _chosen(arrangement: Arrangement, phases: list[int | None]) -> list[int]:
    """Phases of all nodes: those that the colours leave open are chosen."""
    chains = _Chains(arrangement)
    for node, phase in zip(arrangement.nodes, phases, strict=True):
        if phase is not None:
            chains.join(_pairs(node.arms, phase))
    free = {k for k, phase in enumerate(phases) if phase is None}
    chosen = _Greedy(arrangement, chains, free).phases()
    return [chosen[k] if phase is None else phase for k, phase in enumerate(phases)]


def _phase(black: Bools) -> int | None:
    """The phase that follows from the colours of a node's sectors; None when none does."""
    count = len(black)
    if count <= 2:
        return 0
    if np.all(black != np.roll(black, 1)):
        return 0 if black[0] else 1
    odd = np.flatnonzero(black == (black.sum() == 1))
    return int(odd[0] % 2) if count == 4 and len(odd) == 1 else None


# -- curves that touch themselves -------------------------------------------------------------------


def _self_touches(arrangement: Arrangement, smoothing: Smoothing) -> list[int]:
    """Nodes of two joins whose switching cuts a closed curve off another curve, none undoing another."""
    directions = _directions(arrangement)
    node_of = {arm: k for k, node in enumerate(arrangement.nodes) if len(node.arms) == 4 for arm in node.arms}
    out: list[int] = []
    for course in _courses(arrangement, smoothing):
        loops = sorted(_loops(course, arrangement, node_of, directions))
        taken = np.zeros((0, 2), np.int64)
        for _, k, first, second in loops:
            inside = (taken[:, 0] < first) & (first < taken[:, 1])
            if np.all(inside == ((taken[:, 0] < second) & (second < taken[:, 1]))):
                taken = np.append(taken, [[first, second]], axis=0)
                out.append(k)
    return out


def _loops(
    course: list[tuple[int, int]], arrangement: Arrangement, node_of: dict[int, int], directions: Floats
) -> Iterator[tuple[float, int, int, int]]:
    """Yield sharpness, node and both positions of the loops that a course can be cut at."""
    seen: dict[int, int] = {}
    for position, (entered, left) in enumerate(course):
        k = node_of.get(entered)
        if k is None:
            continue
        if k not in seen:
            seen[k] = position
            continue
        arms = arrangement.nodes[k].arms
        before = course[seen[k]]
        # Opposite arms are both entered, or the loop between would be run through backwards.
        if (arms.index(before[0]) - arms.index(entered)) % 4 == 2:
            sharp = max(_sharpness(directions, join) for join in ((before[0], left), (entered, before[1])))
            yield sharp, k, seen[k], position


def _courses(arrangement: Arrangement, smoothing: Smoothing) -> Iterator[list[tuple[int, int]]]:
    """Yield for each curve the joins on its way, as the arms by which nodes are entered and left."""
    other = {x: y for joins in smoothing for join in joins for x, y in (join, join[::-1])}
    arms = range(2 * len(arrangement.arcs))
    used: set[int] = set()
    for start in [*(arm for arm in arms if arm not in other), *arms[::2]]:
        arm, course = start, []
        while arm // 2 not in used:
            used.add(arm // 2)
            if arm ^ 1 in other:
                course.append((arm ^ 1, other[arm ^ 1]))
                arm = course[-1][1]
        yield course


# -- where there is no checkerboard -------------------------------------------------------------------


class _Chains:
    """Arcs joined so far: the other end of each chain and its length, by the arms at its ends."""

    def __init__(self, arrangement: Arrangement) -> None:
        self.other = [arm ^ 1 for arm in range(2 * len(arrangement.arcs))]
        self.length = list(np.repeat([arc.line.length for arc in arrangement.arcs], 2))

    def join(self, joins: list[Join]) -> list[int]:
        """Join arms; return the ends of the chains that arise."""
        ends = []
        for x, y in joins:
            if self.other[x] == y:
                continue
            a, b = self.other[x], self.other[y]
            self.other[a], self.other[b] = b, a
            self.length[a] = self.length[b] = self.length[x] + self.length[y]
            ends += [a, b]
        return ends


class _Greedy:
    """Phases of the ``free`` nodes: the shortest chain that can be closed first.

    When there is none, the node whose sharpest join turns least is smoothed so.
    """

    def __init__(self, arrangement: Arrangement, chains: _Chains, free: set[int]) -> None:
        self._nodes, self._chains = arrangement.nodes, chains
        self._node_of = {arm: k for k in free for arm in self._nodes[k].arms}
        self._loops = [loop for k in free for loop in self._closable(k)]
        heapify(self._loops)
        self._chosen: dict[int, int] = {}
        directions = _directions(arrangement)
        self._gentle = sorted(
            (max(_sharpness(directions, join) for join in _pairs(self._nodes[k].arms, phase)), k, phase)
            for k in free
            for phase in (0, 1)
        )

    def phases(self) -> dict[int, int]:
        for _, k, phase in self._gentle:
            self._close_loops()
            if k not in self._chosen:
                self._choose(k, phase)
        return self._chosen

    def _close_loops(self) -> None:
        while self._loops:
            loop = heappop(self._loops)
            _, k, phase = loop
            if k not in self._chosen and loop in self._closable(k):
                self._choose(k, phase)

    def _choose(self, k: int, phase: int) -> None:
        self._chosen[k] = phase
        for end in self._chains.join(_pairs(self._nodes[k].arms, phase)):
            near = self._node_of.get(end)
            if near is not None and near not in self._chosen:
                for loop in self._closable(near):
                    heappush(self._loops, loop)

    def _closable(self, k: int) -> list[tuple[float, int, int]]:
        """Length, node and phase of the chains that a node can close."""
        arms, other = self._nodes[k].arms, self._chains.other
        neighbours = enumerate(pairwise([*arms, arms[0]]))
        return [(self._chains.length[x], k, n % 2) for n, (x, y) in neighbours if other[x] == y]
