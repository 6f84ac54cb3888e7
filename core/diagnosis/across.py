"""Samples as a curve sees them: in order along it, with signed offsets across it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.lattice import LOOKED_AT, Lattice
from core.refine.branches import Branches, near_branches
from core.refine.polyline import Polyline
from core.refine.project import Feet

__all__ = ["Across", "samples_across"]

Floats = NDArray[np.float64]

MOST = 20_000  # samples of a curve whose offsets are looked at
MOST_PLACES = 20_000
CUT = 4.0  # in sigma: farther samples are not taken for the curve's,
REACH = 6.0  # but noise that varies reaches farther
CLEAR = 3.0  # in sigma: half of the distance from other branches that leaves a sample's offset its own
BLUNT = 3.0  # in sigma: samples nearer to an end are not across the curve
BENT = np.radians(60.0)  # turn within 2 BEND: a fit misses its middle a little
BEND = 4.0  # in sigma: what is nearer to such a turn says little of the noise
ROUNDING = 1e-12  # of the length of a curve: samples nearer to each other coincide
DIRECTIONS = np.radians([0.0, 45.0, 90.0, 135.0])  # in which offsets are taken in space


@dataclass(frozen=True, slots=True, eq=False)
class Across:
    """The samples of one curve, in order along it.

    Attributes
    ----------
    line : Polyline
    sigma : float
        Noise about it.
    reach : float
        Up to which distance samples are its own.
    stations : (n,) array
        Ascending arc lengths of the feet of all samples within four sigma; of copies of one but the first.
    station : (m,) array
        The same of the samples within reach, at most 20 000, that lie beside the curve and nothing
        else: clear of ends, sharp turns and other branches.
    offset : (m, D) array
        Their signed distances across the curve; D = 1 in a plane. In space in four directions, 45
        degrees apart, that do not turn about the curve.
    distance : (m,) array
        Their distances.
    places : (G,) array
        Stations all along the curve, about half a sigma apart.
    clear : (G,) array of bool
        Whether there is nothing else there: no end, sharp turn or other branch.
    coarse : bool
        Whether the coordinates lie on a grid of steps like the noise or larger.
    """

    line: Polyline
    sigma: float
    reach: float
    stations: Floats
    station: Floats
    offset: Floats
    distance: Floats
    places: Floats
    clear: NDArray[np.bool_]
    coarse: bool = False


def samples_across(
    points: Floats,
    lines: Sequence[Polyline],
    feet: Feet,
    sigmas: Floats,
    flat: bool,
    axes: Floats | None = None,
) -> list[Across]:
    """Order the samples of each curve along it.

    Parameters
    ----------
    points : (N, 3) array
    lines : sequence of Polyline
    feet : Feet
        Of the points, on the lines.
    sigmas : (C,) array
        Noise about each line.
    flat : bool
        Whether the points lie in a plane.
    axes : (3, d) array, optional
        Columns are the axes of the input; without them no grid is looked for, and no copies.
    """
    sigmas = np.asarray(sigmas, np.float64)
    branches = near_branches(lines, sigmas, CLEAR) if np.max(sigmas) > 0.0 else None
    ordered = [_ordered(feet, k, float(sigma)) for k, sigma in enumerate(sigmas)]
    lattice = _lattice(points, ordered, axes, float(np.max(sigmas)))
    out = []
    for k, line in enumerate(lines):
        sigma, mine = float(sigmas[k]), ordered[k]
        station, distance = feet.station[mine], feet.distance[mine]
        within = distance <= CUT * max(sigma, 1e-12)
        if lattice is not None and not lattice.gridded:
            first = _is_first(station, distance, line.length)
            mine, station, within = mine[first], station[first], within[first]
        stations = station[within]
        few = mine[:: max(1, -(-len(mine) // MOST))]  # every so many-th along the curve: whatever their order
        few = few[_is_clear(line, feet.station[few], sigma, k, branches)]
        offset = _offsets(points[few], feet.station[few], line, flat)
        own = feet.station[few], offset, feet.distance[few]
        places = _places(line, sigma)
        clear = _is_clear(line, places, sigma, k, branches)
        coarse = lattice is not None and lattice.coarse
        out.append(Across(line, sigma, REACH * sigma, stations, *own, places, clear, coarse))
    return out


def _ordered(feet: Feet, k: int, sigma: float) -> NDArray[np.int64]:
    """Indices of the samples of a curve, in order along it."""
    mine = np.flatnonzero((feet.curve == k) & (feet.distance <= REACH * max(sigma, 1e-12)))
    return np.asarray(mine[np.argsort(feet.station[mine])])


def _lattice(
    points: Floats, ordered: Sequence[NDArray[np.int64]], axes: Floats | None, sigma: float
) -> Lattice | None:
    """What grid the coordinates lie on, from samples evenly along the curves."""
    total = sum(map(len, ordered))
    if axes is None or not total:
        return None
    few = np.concatenate([mine[:: max(1, -(-total // LOOKED_AT))] for mine in ordered])
    return Lattice.of(points[few] @ axes, sigma)


def _is_first(station: Floats, distance: Floats, length: float) -> NDArray[np.bool_]:
    """Which of the ordered samples are no copies of the ones before them; rounding apart."""
    same = (np.diff(station) <= ROUNDING * length) & (np.abs(np.diff(distance)) <= ROUNDING * length)
    return np.concatenate([np.ones(min(len(station), 1), np.bool_), ~same])


def _places(line: Polyline, sigma: float) -> Floats:
    count = int(min(2.0 * line.length / max(sigma, 1e-300), MOST_PLACES))
    return np.asarray((np.arange(count) + 0.5) * (line.length / max(count, 1)))


def _is_clear(
    line: Polyline, station: Floats, sigma: float, k: int, branches: Branches | None
) -> NDArray[np.bool_]:
    """Whether a foot is away from ends, corners and other branches."""
    length, blunt = line.length, BLUNT * sigma
    clear = np.ones(len(station), np.bool_)
    if not line.closed:
        clear &= (station > min(blunt, 0.1 * length)) & (station < length - min(blunt, 0.1 * length))
    clear &= ~_is_bent(line, station, sigma)
    if branches is not None:
        nearest = branches.nearest[branches.first_node[k] : branches.first_node[k + 1]]
        node = (station / float(branches.step[k]) + 0.5).astype(np.int64)
        node = node % len(nearest) if line.closed else np.minimum(node, len(nearest) - 1)
        clear &= nearest[node] > 2.0 * CLEAR * sigma
    return clear


def _is_bent(line: Polyline, station: Floats, sigma: float) -> NDArray[np.bool_]:
    """Whether the course turns sharply next to a foot."""
    step = BEND * sigma
    count = int(min(line.length / max(step, 1e-300), 20_000))
    if count < 8:
        return np.zeros(len(station), np.bool_)
    at = line.at(np.linspace(0.0, line.length, count + 1))
    steps = np.diff(at, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1), 1e-300)[:, None]
    following = np.roll(steps, -1, axis=0)
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", steps, following), -1.0, 1.0))
    if not line.closed:
        turn[-1] = 0.0
    sharp = turn > BENT
    sharp = sharp | np.roll(sharp, 1)  # the steps before the turn and behind it,
    sharp = sharp | np.roll(sharp, 1) | np.roll(sharp, -1)  # and one more either side
    return np.asarray(sharp[np.minimum((station * (count / line.length)).astype(np.int64), count - 1)])


def _units(line: Polyline) -> Floats:
    """(S, 3) directions of the segments."""
    steps = np.diff(line.ring, axis=0)
    return np.asarray(steps / np.maximum(np.linalg.norm(steps, axis=1), 1e-300)[:, None])


def _offsets(points: Floats, station: Floats, line: Polyline, flat: bool) -> Floats:
    """(n, D) signed distances across the line."""
    units = _units(line)
    segment = np.clip(np.searchsorted(line.stations, station, "right") - 1, 0, len(units) - 1)
    away = points - line.at(station)
    if flat:
        x, y = units[segment, 0], units[segment, 1]
        return np.asarray(x * away[:, 1] - y * away[:, 0])[:, None]
    first = _carried_normals(units)[segment]
    second = np.cross(units[segment], first)
    u, v = np.einsum("ij,ij->i", away, first), np.einsum("ij,ij->i", away, second)
    return np.asarray(np.outer(u, np.cos(DIRECTIONS)) + np.outer(v, np.sin(DIRECTIONS)))


def _carried_normals(units: Floats) -> Floats:
    """(S, 3) unit normals of the segments, carried along the curve without turning about it."""
    out = np.empty_like(units)
    normal = np.eye(3)[int(np.argmin(np.abs(units[0])))]
    for k, unit in enumerate(units):
        normal = normal - (normal @ unit) * unit
        size = float(np.linalg.norm(normal))
        normal = normal / size if size > 1e-6 else np.cross(unit, np.roll(unit, 1))
        out[k] = normal
    return out
