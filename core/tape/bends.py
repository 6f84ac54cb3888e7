"""Curves drawn through smoothed crossings: arms are cut short and joined by bends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.refine.crossings import Meeting, crossings
from core.refine.polyline import Polyline
from core.tape.arrangement import Arc, Arrangement, Node
from core.tape.smoothing import Smoothing

__all__ = ["Drawn", "draw"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GAP = 1.0  # in sigma: arms are cut where neighbours are this far apart
BOW = 1.0  # in sigma: they are cut no farther out than where they are this far off a straight line
WIDEST = 60.0  # in sigma: they are cut no farther out
SHARE = 0.4  # of an arc: the most that is cut at one end
LEAST = 1e-3  # of the shortest arc: the least that is cut
LIFT = 0.02  # of the cut: by how much a bend keeps off its crossing
STEPS = np.linspace(0.0, 1.0, 9)[1:-1, None]  # of a bend; the middle is one of them
SHRINK = 0.35
ROUNDS = 20  # the cuts shrink to 1e-9 in as many


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A curve with the arcs that it follows."""

    line: Polyline
    arcs: tuple[int, ...]


def draw(
    arrangement: Arrangement, smoothing: Smoothing, sigma: float, beside: Sequence[Polyline] = ()
) -> tuple[list[Drawn], bool]:
    """Draw the curves of a smoothing so that none crosses another or itself.

    Each join is a quadratic Bezier curve within its own sector, so that two bends of one node leave
    a gap. Bends that something else comes into the way of shrink towards the node.

    Parameters
    ----------
    arrangement : Arrangement
    smoothing : Smoothing
    sigma : float
        Noise standard deviation.
    beside : sequence of Polyline
        Other curves, which are not to be crossed either.

    Returns
    -------
    list of Drawn
    bool
        Whether no curve crosses another or itself, as is meant to be.
    """
    courses = [_Course.of(arc) for arc in arrangement.arcs]
    cuts = _cuts(arrangement, courses, smoothing, sigma)
    node_of = np.array([k for arc in arrangement.arcs for k in arc.nodes], np.int64)
    shrink = np.ones(len(arrangement.nodes) + 1)  # the last is for free ends
    drawing = _Drawing(arrangement, courses, smoothing, cuts)
    for _ in range(ROUNDS):
        met = drawing.meetings(beside)
        blamed = drawing.blamed(met)
        if not blamed:
            return drawing.curves, not met
        shrink[list(blamed)] *= SHRINK
        drawing = _Drawing(arrangement, courses, smoothing, cuts * shrink[node_of])
    return drawing.curves, not drawing.meetings(beside)


@dataclass(frozen=True, slots=True, eq=False)
class _Course:
    """An arc with the arc length at its vertices."""

    vertices: Floats
    stations: Floats

    @classmethod
    def of(cls, arc: Arc) -> _Course:
        return cls(arc.vertices, arc.line.stations)

    @property
    def length(self) -> float:
        return float(self.stations[-1])

    def at(self, s: Floats) -> Floats:
        """Points at arc lengths, clamped to the ends."""
        return np.stack([np.interp(s, self.stations, column) for column in self.vertices.T], axis=1)

    def seen_from(self, side: int, s: Floats) -> Floats:
        """Points at arc lengths from the first vertex (0) or from the last (1)."""
        return self.at(self.length - s if side else s)

    def between(self, first: float, last: float) -> Floats:
        """Return what remains when that much is cut off at each end."""
        inside = (self.stations > first) & (self.stations < self.length - last)
        a, b = self.at(np.array([first, self.length - last]))
        return np.concatenate([a[None], self.vertices[inside], b[None]])


def _cuts(arrangement: Arrangement, courses: Sequence[_Course], smoothing: Smoothing, sigma: float) -> Floats:
    """(2 A,) by how much each arm is cut short; nothing where one curve only ends on another."""
    length = np.repeat([course.length for course in courses], 2)
    cuts = np.zeros(len(length))
    for node, joins in zip(arrangement.nodes, smoothing, strict=True):
        if len(joins) < 2:
            continue
        arms = [*node.arms, *node.ending]
        least = LEAST * float(length[arms].min())
        most = np.clip(_reaches(node, courses, length, sigma), least, SHARE * length[arms])
        nested = any(abs(arms.index(x) - arms.index(y)) not in (1, len(node.arms) - 1) for x, y in joins)
        # Bends around others are kept apart by a common size.
        groups = [arms] if nested else [*map(list, joins), *([arm] for arm in node.ending)]
        for group in groups:
            cuts[group] = min(most[arms.index(arm)] for arm in group)
    return cuts


def _reaches(node: Node, courses: Sequence[_Course], length: Floats, sigma: float) -> Floats:
    """How far along each arm, the ending ones last, a bend may begin.

    That is where the arm is clear of its neighbours' noise, unless it has left the straight line before.
    """
    reach = np.geomspace(0.5 * GAP, WIDEST, 20) * sigma
    arms, count = [*node.arms, *node.ending], len(node.arms)
    places = np.stack([courses[arm // 2].seen_from(arm % 2, reach) for arm in arms])
    gap = np.linalg.norm(places[:count] - np.roll(places[:count], -1, axis=0), axis=2)
    shorter = np.minimum(length[arms[:count]], np.roll(length[arms[:count]], -1))
    parted = (gap >= GAP * sigma) | (reach > shorter[:, None])
    parting = [_first(clear) for clear in parted & np.roll(parted, 1, axis=0)]
    parting += [min(parting)] * len(node.ending)
    chord = np.linalg.norm(places - node.place, axis=2)
    sagitta = np.sqrt(0.375 * reach * np.maximum(reach - chord, 0.0))  # of an arc of a circle
    straight = [max(_first(bow > BOW * sigma) - 1, 0) for bow in sagitta]
    return np.append(reach, reach[-1])[np.minimum(parting, straight)]


def _first(true: NDArray[np.bool_]) -> int:
    """Index of the first true value, or the length."""
    return int(np.argmax(np.append(true, True)))


class _Drawing:
    """Curves of a smoothing, and of each of their edges the node whose bend it belongs to (-1: none)."""

    def __init__(
        self, arrangement: Arrangement, courses: Sequence[_Course], smoothing: Smoothing, cuts: Floats
    ) -> None:
        self._pieces = [
            course.between(*cut) for course, cut in zip(courses, cuts.reshape(-1, 2), strict=True)
        ]
        self._bends: dict[int, tuple[int, int, Floats]] = {}  # by arm: the other arm, the node, the bend
        for k, joins in enumerate(smoothing):
            for x, y in joins:
                bend = self._bend(arrangement.nodes[k], x, y) if len(joins) > 1 else np.zeros((0, 3))
                self._bends[x], self._bends[y] = (y, k, bend), (x, k, bend[::-1])
        self.curves: list[Drawn] = []
        self._bend_of: list[Ints] = []
        used: set[int] = set()
        arms = range(2 * len(courses))
        for arm in [*(arm for arm in arms if arm not in self._bends), *arms[::2]]:
            if arm // 2 not in used:
                used |= set(self._follow(arm))

    def meetings(self, beside: Sequence[Polyline]) -> list[Meeting]:
        """Crossings, also with other curves, which are numbered last."""
        return crossings([*(curve.line for curve in self.curves), *beside])

    def blamed(self, met: Sequence[Meeting]) -> set[int]:
        """Nodes whose bends cross something."""
        out: set[int] = set()
        stations = [curve.line.stations for curve in self.curves]
        for meeting in met:
            for k, station in zip(meeting.curves, meeting.stations, strict=True):
                if k >= len(self.curves):
                    continue
                edge = int(np.searchsorted(stations[k], station, "right")) - 1
                out.add(int(self._bend_of[k][min(edge, len(self._bend_of[k]) - 1)]))
        return out - {-1}

    def _bend(self, node: Node, x: int, y: int) -> Floats:
        """Vertices between two arms, (K, 3), within the sector from the first to the second."""
        a, b = self._end(x) - node.place, self._end(y) - node.place
        control = np.zeros(3)
        if node.arms[(node.arms.index(x) + 1) % len(node.arms)] == y:
            control = _lifted(a, b)
        t = STEPS
        return np.asarray(node.place + (1.0 - t) ** 2 * a + 2.0 * t * (1.0 - t) * control + t**2 * b)

    def _end(self, arm: int) -> Floats:
        return np.asarray(self._pieces[arm // 2][-1 if arm % 2 else 0])

    def _follow(self, start: int) -> list[int]:
        """Draw the curve that begins with an arm; return its arcs."""
        parts: list[Floats] = []
        bend_of: list[int] = []
        arcs: list[int] = []
        arm = start
        while not arcs or arm != start:
            arcs.append(arm // 2)
            piece = self._pieces[arm // 2][:: -1 if arm % 2 else 1]
            joined = self._bends.get(arm ^ 1)
            if joined is None:
                parts.append(piece)
                bend_of += [-1] * len(piece)
                break
            arm, node, bend = joined
            # Without a bend the node itself is where the next piece begins.
            parts += [piece, bend] if len(bend) else [piece[:-1]]
            bend_of += [-1] * (len(piece) - 1) + [node] * (len(bend) + 1 if len(bend) else 0)
        line = Polyline(np.concatenate(parts), start in self._bends)
        self.curves.append(Drawn(line, tuple(arcs)))
        self._bend_of.append(np.array(bend_of))
        return arcs


def _lifted(a: Floats, b: Floats) -> Floats:
    """Control point of a bend on the bisector of its sector, from a to b counter-clockwise.

    The middle of the bend lies on it too: in a reflex sector the control point must outweigh
    the arms, which pull to the other side.
    """
    half = 0.5 * float((np.arctan2(b[1], b[0]) - np.arctan2(a[1], a[0])) % (2.0 * np.pi))
    along = float(np.arctan2(a[1], a[0])) + half
    reach = min(float(np.linalg.norm(a)), float(np.linalg.norm(b)))
    lift = reach * (LIFT + max(0.0, -float(np.cos(half))))
    return lift * np.array([np.cos(along), np.sin(along), 0.0])
