"""How far a reconstruction is from the truth, and whether it has the right shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree

from core.truth.intersections import crossings
from core.truth.junctions import apart, diagonal, joinings
from core.truth.point_sets import PointSet, TrueCurve
from core.truth.readings import Reading, readings

__all__ = ["Score", "distances", "resample", "rms", "score", "true_points"]

Floats = NDArray[np.float64]
Polyline = tuple[Floats, bool]

_SAMPLES = 4096  # per set of curves, spread by length
_TOLERANCE = 3.0  # sigmas within which a place counts as covered
_EXACT = 1e-3  # of the diagonal: the same for a sample without noise
_AT_JUNCTION = 2.0  # tolerances from a junction within which an end that runs past it does not cross
_NEAR_TURN = 5.0  # tolerances from a crossing within which curves that do not cross are rounded off
_COVER = 0.95  # of the length, on both sides, makes a curve the other's own


@dataclass(frozen=True, slots=True)
class Score:
    """A reconstruction measured against the truth; lengths in the units of the points.

    Attributes
    ----------
    rms, maximum : float
        RMS and largest distance from the points of the true curves to the result.
    rms_back, maximum_back : float
        The same from the points of the result to the true curves.
    completeness : float
        Fraction of the true length within three sigma of the result.
    excess : float
        Fraction of the result's length farther than that from the truth.
    curves, true_curves : int
        Where three or more ends meet, each way of joining them in pairs is true; the best for the result.
    crossings, true_crossings : int
        An end that runs past the curve on which it should end does not count.
    flags_right : bool
        As many curves as in truth, and the matched ones open or closed as in truth.
    covered : bool
        Each true curve and its matched result lie within three sigma of each other, for 95 % of both;
        in readings without crossings, all true curves and all of the result.
    """

    rms: float
    maximum: float
    rms_back: float
    maximum_back: float
    completeness: float
    excess: float
    curves: int
    true_curves: int
    crossings: int
    true_crossings: int
    flags_right: bool
    covered: bool

    @property
    def topology_right(self) -> bool:
        """Right number of curves, flags, cover and number of crossings."""
        return self.flags_right and self.covered and self.crossings == self.true_crossings


def resample(polylines: Sequence[Polyline], count: int = _SAMPLES) -> list[Floats]:
    """Return about ``count`` points in all, equidistant along each polyline, one (M, d) array each."""
    rings = [np.vstack((v, v[:1])) if closed else v for v, closed in polylines]
    ways = [np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(r, axis=0), axis=1)))) for r in rings]
    total = sum(way[-1] for way in ways) or 1.0
    result = []
    for ring, way in zip(rings, ways, strict=True):
        m = max(2, round(count * way[-1] / total))
        middle = (np.arange(m) + 0.5) / m * way[-1]  # each point stands for the same length
        result.append(np.column_stack([np.interp(middle, way, column) for column in ring.T]))
    return result


def true_points(curves: Sequence[TrueCurve], count: int = _SAMPLES) -> Floats:
    """Return about ``count`` points of the exact curves, equidistant in arc length, shape (M, d)."""
    total = sum(one.length for one in curves)
    sizes = [max(2, round(count * one.length / total)) for one in curves]
    return np.concatenate(
        [one.exact.at((np.arange(m) + 0.5) / m) for one, m in zip(curves, sizes, strict=True)]
    )


def distances(points: Floats, polylines: Sequence[Polyline], count: int = _SAMPLES) -> Floats:
    """Return the distances from points to the nearest place on the polylines, shape (M,).

    The polylines are cut into short chords first, so that the nearest chord touches the nearest
    cut or one of its neighbours.
    """
    start, end = _chords(polylines, count)
    nearby = KDTree((start + end) / 2).query(points, k=min(4, len(start)))[1].reshape(len(points), -1)
    best = np.full(len(points), np.inf)
    for column in nearby.T:
        a, edge = start[column], end[column] - start[column]
        along = np.einsum("ij,ij->i", points - a, edge) / np.maximum(
            np.einsum("ij,ij->i", edge, edge), 1e-300
        )
        foot = a + np.clip(along, 0.0, 1.0)[:, None] * edge
        best = np.minimum(best, np.linalg.norm(points - foot, axis=1))
    return best


def rms(values: Floats) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def score(curves: Sequence[Polyline], truth: PointSet, reading: Reading = "through") -> Score:
    """Measure curves, each given as ((M, d) vertices, closed), against the truth of a point set.

    A closed curve does not repeat its first vertex. Without any curve all distances are infinite.

    Parameters
    ----------
    curves : sequence of ((M, d) vertices, closed)
    truth : PointSet
    reading : {"through", "split", "waist"}
        How the true curves go on where they cross; see :mod:`core.truth.readings` for the other two.
        There, no curve may cross, all must be closed, and together they cover the truth; near its
        crossings, where they turn a corner, twice as loosely.

    Raises
    ------
    ValueError
        When the point set has no such reading.

    Examples
    --------
    >>> from core.truth.point_sets import point_set
    >>> sample = point_set("ellipse", n=10)
    >>> score([(c.vertices, c.closed) for c in sample.curves], sample).topology_right
    True
    """
    true = [(one.vertices, one.closed) for one in truth.curves]
    wanted = len(truth.crossings) if reading == "through" else 0
    if not curves:
        inf = float("inf")
        return Score(inf, inf, inf, inf, 0.0, 0.0, 0, len(true), 0, wanted, False, False)
    tolerance = max(_TOLERANCE * truth.sigma, _EXACT * diagonal(true))
    found = apart(crossings(curves).locations, truth.junctions, _AT_JUNCTION * tolerance)
    exact, places = true_points(truth.curves), np.concatenate(resample(curves))
    there = distances(exact, curves)
    fine = [(one.exact.polyline(2 * _SAMPLES), one.closed) for one in truth.curves]
    back = distances(places, fine)
    if reading == "through":
        best = _best_agreement(curves, true, tolerance)
    else:
        gaps = (exact, there), (places, back)
        near = min(_share_near(*one, truth.crossings, tolerance) for one in gaps)
        best = _without_crossings(curves, _count(true, reading), near >= _COVER)
    return Score(
        rms(there),
        float(there.max()),
        rms(back),
        float(back.max()),
        float(np.mean(there <= tolerance)),
        float(np.mean(back > tolerance)),
        len(curves),
        best.curves,
        int(found.sum()),
        wanted,
        best.flags,
        best.covered,
    )


def _chords(polylines: Sequence[Polyline], count: int) -> tuple[Floats, Floats]:
    """Cut polylines into chords no longer than the total length over ``count``; starts and ends."""
    rings = [np.vstack((v, v[:1])) if closed else v for v, closed in polylines]
    edges = [np.linalg.norm(np.diff(ring, axis=0), axis=1) for ring in rings]
    longest = sum(float(e.sum()) for e in edges) / count or 1.0
    starts, ends = [], []
    for ring, edge in zip(rings, edges, strict=True):
        pieces = np.maximum(1, np.ceil(edge / longest)).astype(np.int64)
        number = np.repeat(np.arange(len(edge)), pieces)
        step = np.arange(len(number)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        rise = ring[number + 1] - ring[number]
        starts.append(ring[number] + (step / pieces[number])[:, None] * rise)
        ends.append(ring[number] + ((step + 1) / pieces[number])[:, None] * rise)
    return np.concatenate(starts), np.concatenate(ends)


@dataclass(frozen=True, slots=True)
class _Agreement:
    """How a result agrees with one reading of the truth, which has ``curves`` curves."""

    curves: int
    flags: bool
    covered: bool


def _best_agreement(curves: Sequence[Polyline], true: Sequence[Polyline], tolerance: float) -> _Agreement:
    agreements = [_agreement(curves, one, tolerance) for one in joinings(true)]
    return max(agreements, key=lambda one: (one.flags and one.covered, one.flags, one.covered))


def _agreement(curves: Sequence[Polyline], true: Sequence[Polyline], tolerance: float) -> _Agreement:
    pairs = _match(curves, true)
    flags = len(curves) == len(true) and all(curves[i][1] == true[j][1] for i, j in pairs)
    covered = len(pairs) == len(true) and all(_own(curves[i], true[j], tolerance) for i, j in pairs)
    return _Agreement(len(true), flags, covered)


def _without_crossings(curves: Sequence[Polyline], count: int, covered: bool) -> _Agreement:
    """Compare with a reading that is so many closed curves."""
    return _Agreement(count, len(curves) == count and all(closed for _, closed in curves), covered)


def _share_near(places: Floats, gaps: Floats, turns: Floats, tolerance: float) -> float:
    """Return the share of gaps within tolerance; within twice as much near the turns of curves."""
    loosely = np.where(apart(places, turns, _NEAR_TURN * tolerance), tolerance, 2 * tolerance)
    return float(np.mean(gaps <= loosely))


def _count(true: Sequence[Polyline], reading: Reading) -> int:
    """Return the number of curves in a reading without crossings."""
    known = readings(true)
    if known is None:
        raise ValueError("Only closed curves in the plane can be read as curves that do not cross.")
    return known.count(reading)


def _match(curves: Sequence[Polyline], true: Sequence[Polyline]) -> list[tuple[int, int]]:
    """Pair results and true curves so that the sum of their symmetric RMS distances is smallest."""
    cost = np.array([[_symmetric(a, b) for b in true] for a in curves])
    rows, columns = linear_sum_assignment(cost)
    return list(zip(rows.tolist(), columns.tolist(), strict=True))


def _symmetric(a: Polyline, b: Polyline) -> float:
    there = distances(resample([a], 256)[0], [b], 256)
    back = distances(resample([b], 256)[0], [a], 256)
    return float(np.sqrt((np.mean(there**2) + np.mean(back**2)) / 2))


def _own(curve: Polyline, true: Polyline, tolerance: float) -> bool:
    """Tell whether a result covers one true curve, and nothing much besides it."""
    there = distances(resample([true], 1024)[0], [curve], 1024)
    back = distances(resample([curve], 1024)[0], [true], 1024)
    return bool(min(np.mean(there <= tolerance), np.mean(back <= tolerance)) >= _COVER)
