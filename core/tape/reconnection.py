"""Which arms belong together where two branches meet: the samples decide (§5.2).

Four arms that meet can be joined in three ways, and one of them crosses. A skeleton sees
only the shape of the tape there; where its reading does not cross, the crossing one is
tried as well, and the one that explains the samples better stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.sampling import Sample, Scale, spread_subsample
from core.refine.crossings import crossings
from core.refine.evidence import bending, description_length
from core.refine.polyline import Polyline
from core.tape.outermost import smoothed

__all__ = ["Approach", "approaches", "reconnected", "rewired"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LOOK = 6.0  # in units: branches this near may belong to one crossing
STRETCH = 12.0  # in units: approaches nearer along both branches are one
WINDOW = 8.0  # in units: how far from an approach its arms are looked at
CUT = 3.0  # in units: what a swap takes out of each branch
MOST_NODES = 6000  # a curve
MOST_APPROACHES = 200
MOST_TRIALS = 40  # with up to FEW curves; fewer with more, which take longer each
FEW = 4
JUDGED = 3000  # samples by which readings are compared
MARGIN = 3.0  # nats that going straight on may cost
PARALLEL = 0.9  # cosine beyond which an end may as well run along
TOUCH = 3.0  # in units: branches this near that do not cross may as well
SPARSE = 1.5  # mean distances between samples that count as near
DOUBT = 5.0  # nats that do not tell

# Arms: 0 and 1 before and after the approach on its first branch, 2 and 3 on its second.
READINGS = (((0, 1), (2, 3)), ((0, 3), (1, 2)), ((0, 2), (1, 3)))


@dataclass(frozen=True, slots=True)
class Approach:
    """A place where two branches come close.

    Attributes
    ----------
    curves : (int, int)
        The curves of the two branches, or one twice.
    stations : (float, float)
        Arc length on each.
    gap : float
        Distance between them.
    """

    curves: tuple[int, int]
    stations: tuple[float, float]
    gap: float


def reconnected(
    sample: Sample, curves: Sequence[Polyline], sigma: float, scale: Scale, extent: float
) -> tuple[list[Polyline], Floats]:
    """Let branches that touch cross instead wherever the samples do not object.

    Parameters
    ----------
    sample : Sample
    curves : sequence of Polyline
        In the plane z = 0.
    sigma : float
        Noise estimate.
    scale : Scale
        Where samples are farther apart than the noise is wide, approaches are looked for in units of
        their distance.
    extent : float
        Radius of the region of the samples.

    Returns
    -------
    curves : list of Polyline
    doubts : (K, 3) array
        Places where both readings explain the samples about as well.
    """
    judged = Sample.of(sample.few[spread_subsample(sample.few, JUDGED)])
    smooth = smoothed(judged, curves, sigma)
    best, sigma = list(smooth.curves), max(sigma, smooth.sigma)
    unit = max(sigma, SPARSE / scale.density)

    def cost_of(readings: Sequence[Polyline]) -> float:
        """Nats, whatever the number of curves: it is not in question here."""
        told = description_length(judged.points, readings, sigma, extent, flat=True, whole=True)
        return told + bending(readings, sigma, scale.curvature)

    nats = cost_of(best)
    trials, crossed = 0.0, True
    doubts: list[Floats] = []
    while crossed and trials < MOST_TRIALS:
        crossed, doubts = False, []
        for approach in approaches(best, unit):
            other = _crossing_instead(best, approach, unit)
            if other is None:
                continue
            trials += max(len(other) / FEW, 1.0)
            if trials > MOST_TRIALS:
                break
            other = list(smoothed(judged, other, sigma).curves)
            cost = cost_of(other)
            if cost < nats + MARGIN:
                best, nats, crossed = other, cost, True
                break
            if cost < nats + DOUBT:
                doubts.append(best[approach.curves[0]].at(np.array(approach.stations[:1]))[0])
    doubts += _touching(best, unit)
    return best, np.array(doubts).reshape(-1, 3)


def _touching(curves: Sequence[Polyline], unit: float) -> list[Floats]:
    """Places where two branches are within the noise of each other, and neither cross nor clearly end."""
    met = np.array([meeting.place for meeting in crossings(curves)]).reshape(-1, 3)
    out = []
    for approach in approaches(curves, unit):
        place = curves[approach.curves[0]].at(np.array(approach.stations[:1]))[0]
        crossed = len(met) and np.linalg.norm(met - place, axis=1).min() < STRETCH * unit
        if approach.gap < TOUCH * unit and not crossed and not _clear_end(curves, approach, unit):
            out.append(place)
    return out


def _clear_end(curves: Sequence[Polyline], approach: Approach, unit: float) -> bool:
    """Whether one branch ends there, at a clear angle to the other."""
    free, ways = False, []
    for k, s in zip(approach.curves, approach.stations, strict=True):
        line = curves[k]
        free |= not line.closed and min(s, line.length - s) < LOOK * unit
        way = np.diff(line.at(np.array([s - LOOK * unit, s + LOOK * unit])), axis=0)[0]
        ways.append(way / max(float(np.linalg.norm(way)), 1e-300))
    return free and abs(float(ways[0] @ ways[1])) < PARALLEL


def approaches(curves: Sequence[Polyline], unit: float) -> list[Approach]:
    """Find the closest places of every two branches that come near each other, the closest first.

    Parameters
    ----------
    curves : sequence of Polyline
    unit : float
        Length that counts as near.
    """
    stations = [_stations(line, 0.5 * unit) for line in curves]
    places = np.concatenate([line.at(s) for line, s in zip(curves, stations, strict=True)])
    curve = np.repeat(np.arange(len(curves)), [len(s) for s in stations])
    station = np.concatenate(stations)
    period = np.array([line.length if line.closed else np.inf for line in curves])
    pairs = cKDTree(places).query_pairs(LOOK * unit, output_type="ndarray")
    chord = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    way = np.abs(station[pairs[:, 0]] - station[pairs[:, 1]])
    around = period[curve[pairs[:, 0]]]
    same = curve[pairs[:, 0]] == curve[pairs[:, 1]]
    way = np.where(same, np.minimum(way, around - way), np.inf)
    apart = way > 3.0 * chord + LOOK * unit
    pairs, chord = pairs[apart], chord[apart]
    order = np.argsort(chord, kind="stable")
    return _one_a_stretch(curve, station, period, pairs[order], chord[order], unit)


def _stations(line: Polyline, step: float) -> Floats:
    count = int(min(max(line.length / step, 16), MOST_NODES))
    return np.linspace(0.0, line.length, count, endpoint=not line.closed)


def _one_a_stretch(
    curve: Ints, station: Floats, period: Floats, pairs: Ints, chord: Floats, unit: float
) -> list[Approach]:
    """The closest pair, then the closest one of other stretches, and so on."""
    out: list[Approach] = []
    while len(pairs) and len(out) < MOST_APPROACHES:
        (i, j), gap = pairs[0], float(chord[0])
        out.append(Approach((int(curve[i]), int(curve[j])), (float(station[i]), float(station[j])), gap))
        reach = STRETCH * unit + 2.0 * gap
        beside_i, beside_j = (_beside(curve, station, period, k, reach) for k in (i, j))
        a, b = pairs[:, 0], pairs[:, 1]
        taken = (beside_i[a] & beside_j[b]) | (beside_i[b] & beside_j[a])
        pairs, chord = pairs[~taken], chord[~taken]
    return out


def _beside(curve: Ints, station: Floats, period: Floats, k: int, reach: float) -> NDArray[np.bool_]:
    """Which nodes lie within ``reach`` of node ``k`` along its curve."""
    way = np.abs(station - station[k])
    way = np.minimum(way, np.abs(period[curve] - way))
    return np.asarray((curve == curve[k]) & (way < reach))


def _crossing_instead(curves: Sequence[Polyline], approach: Approach, unit: float) -> list[Polyline] | None:
    """The curves with the arms there joined crosswise; None where they are so, or too short."""
    reading = _alternating(curves, approach, WINDOW * unit + approach.gap)
    return rewired(curves, approach, reading, CUT * unit + approach.gap) if reading else None


def _alternating(curves: Sequence[Polyline], approach: Approach, reach: float) -> int | None:
    """The reading whose pairs of arms alternate around the approach."""
    tips, heart = [], np.zeros(3)
    for k in (0, 1):
        line, s = curves[approach.curves[k]], approach.stations[k]
        rival = approach.stations[1 - k] if approach.curves[0] == approach.curves[1] else None
        back, fore = _room(line, s, rival)
        if min(back, fore) < 0.3 * reach:
            return None
        tips.append(line.at(np.array([s - min(back, reach), s + min(fore, reach)])))
        heart += 0.5 * line.at(np.array([s]))[0]
    away = np.concatenate(tips) - heart
    order = np.argsort(np.arctan2(away[:, 1], away[:, 0])).tolist()
    pairs = {frozenset(order[::2]), frozenset(order[1::2])}
    return next(k for k, reading in enumerate(READINGS) if {frozenset(p) for p in reading} == pairs)


def _room(line: Polyline, s: float, rival: float | None) -> tuple[float, float]:
    """How far arms reach back and forth: to an end, or half way to its other station."""
    length = line.length
    back, fore = (0.5 * length, 0.5 * length) if line.closed else (s, length - s)
    if rival is not None:
        if line.closed:
            return 0.5 * ((s - rival) % length), 0.5 * ((rival - s) % length)
        if rival > s:
            fore = 0.5 * (rival - s)
        else:
            back = 0.5 * (s - rival)
    return back, fore


def rewired(
    curves: Sequence[Polyline], approach: Approach, reading: int, cut: float
) -> list[Polyline] | None:
    """Cut both branches at an approach and join the four arms by another of the READINGS.

    Parameters
    ----------
    curves : sequence of Polyline
    approach : Approach
    reading : int
    cut : float
        What is taken out of each branch before and after the approach.

    Returns
    -------
    list of Polyline or None
        None where a branch is too short for the cuts.
    """
    arcs: list[_Arc] = []
    for k in dict.fromkeys(approach.curves):
        marks = [(approach.stations[side], 2 * side) for side in (0, 1) if approach.curves[side] == k]
        pieces = _arcs(curves[k], sorted(marks), cut)
        if pieces is None:
            return None
        arcs += pieces
    rest = [line for k, line in enumerate(curves) if k not in approach.curves]
    return rest + _joined(arcs, READINGS[reading])


@dataclass(frozen=True, slots=True, eq=False)
class _Arc:
    """A piece of a cut curve; ``arms`` names the arm at its start and at its end, None at a free end."""

    places: Floats
    arms: tuple[int | None, int | None]


def _arcs(line: Polyline, marks: list[tuple[float, int]], cut: float) -> list[_Arc] | None:
    """What is left of a curve between its cuts; None when nothing is left somewhere."""
    bounds: list[tuple[float, float, int | None, int | None]] = []
    if line.closed:
        for (s, arm), (t, next_arm) in zip(marks, marks[1:] + marks[:1], strict=True):
            end = t if t > s else t + line.length
            bounds.append((s + cut, end - cut, arm + 1, next_arm))
    else:
        starts = [(0.0, None), *((s + cut, arm + 1) for s, arm in marks)]
        ends = [*((s - cut, arm) for s, arm in marks), (line.length, None)]
        bounds = [(low, high, a, b) for (low, a), (high, b) in zip(starts, ends, strict=True)]
    if any(high <= low for low, high, *_ in bounds):
        return None
    return [_Arc(_between(line, low, high), (a, b)) for low, high, a, b in bounds]


def _between(line: Polyline, low: float, high: float) -> Floats:
    """The course of a curve from one station to another, past the start of a closed one if need be."""
    stations = line.stations
    if line.closed:
        stations = np.concatenate([stations[:-1], stations[:-1] + line.length])
    inner = stations[(stations > low) & (stations < high)]
    return line.at(np.concatenate([[low], inner, [high]]))


def _joined(arcs: list[_Arc], reading: tuple[tuple[int, int], tuple[int, int]]) -> list[Polyline]:
    """Follow arcs from arm to partner: from every free end, then around what is closed."""
    partner = {a: b for pair in reading for a, b in (pair, pair[::-1])}
    where = {
        arm: (k, end) for k, arc in enumerate(arcs) for end, arm in enumerate(arc.arms) if arm is not None
    }
    heads = [(k, end) for k, arc in enumerate(arcs) for end in (0, 1) if arc.arms[end] is None]
    used: set[int] = set()
    out = []
    for start in heads + [(k, 0) for k in range(len(arcs))]:
        if start[0] in used:
            continue
        parts, at = [], start
        while True:
            k, end = at
            used.add(k)
            parts.append(arcs[k].places[::-1] if end else arcs[k].places)
            leaving = arcs[k].arms[1 - end]
            if leaving is None:
                out.append(Polyline(np.concatenate(parts), False))
                break
            at = where[partner[leaving]]
            if at == start:
                out.append(Polyline(np.concatenate(parts), True))
                break
    return out
