"""Where two branches of curves lie so close that a sample may come from either.

Branches are different curves, or stretches of one curve that are much farther apart along it
than across. Places are found with nodes along the curves, much fewer than samples; where no two
branches are close there is nothing to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.refine.polyline import Polyline

__all__ = ["APART", "DETOUR", "Branches", "near_branches"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

APART = 8.0  # in sigma along the curve, at least, between the feet of a sample on two branches;
DETOUR = 2.0  # and in chords: on a circle the way between two points is at most pi / 2 chords
SPACING = 1.5  # of nodes, in sigma,
MOST_NODES = 2000  # unless they would be too many
LEAST = 1e-6  # of the greatest noise: a curve through all of its samples has some too


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """Curves of which some branches are near each other, with K equidistant nodes on them.

    Attributes
    ----------
    sigmas : (C,) array
        Noise of each curve.
    cut : float
        Samples farther than this many sigma do not belong to a curve.
    heads, tails : (S, 3) array
        The segments of all curves.
    spans : (S, 2) array
        Stations where they begin and end.
    first_segment, first_node : (C + 1,) array of int
        Curve k has those from its own number's to the next one's.
    closed : (C,) array of bool
    place : (K, 3) array
        The nodes.
    curve, segment : (K,) array of int
        Where they lie.
    step : (C,) array
        Distance between nodes along each curve.
    starts, partners : (K + 1,), (P,) array of int
        Node n has the nodes ``partners[starts[n]:starts[n + 1]]`` of other branches nearby.
    nearest : (K,) array
        Distance to the nearest of them.
    """

    sigmas: Floats
    cut: float
    heads: Floats
    tails: Floats
    spans: Floats
    first_segment: Ints
    first_node: Ints
    closed: NDArray[np.bool_]
    place: Floats
    curve: Ints
    segment: Ints
    step: Floats
    starts: Ints
    partners: Ints
    nearest: Floats


def near_branches(lines: Sequence[Polyline], sigmas: Floats, cut: float) -> Branches | None:
    """Find where branches come within twice ``cut`` sigma of each other; None when nowhere.

    Parameters
    ----------
    lines : sequence of Polyline
    sigmas : (C,) array
        Noise of each.
    cut : float
        Samples farther than this many sigma do not belong to a curve.
    """
    sigma = float(sigmas.max())
    lengths = np.array([line.length for line in lines])
    if not sigma > 1e-9 * float(lengths.max()):
        return None
    sigmas = np.maximum(sigmas, 1e-6 * sigma)  # a curve through few samples may have none
    spacing = max(SPACING * sigma, float(lengths.sum()) / MOST_NODES)
    sigmas = np.maximum(sigmas, LEAST * sigma)
    stations = [_stations(line, length, spacing) for line, length in zip(lines, lengths, strict=True)]
    sizes = np.array([len(s) for s in stations])
    curve, first = np.repeat(np.arange(len(lines)), sizes), np.append(0, np.cumsum(sizes))
    closed = np.array([line.closed for line in lines])
    place = np.concatenate([line.at(s) for line, s in zip(lines, stations, strict=True)])
    tree, reach = cKDTree(place), 2.0 * cut * sigma + spacing  # places are half a spacing from a node at most
    if len(place) > 2 * MOST_NODES and tree.count_neighbors(tree, reach) > MOST_NODES**2:
        return None  # a tangle of short curves
    pairs = tree.query_pairs(reach, output_type="ndarray")
    least = (1.0 - 1.0 / DETOUR) * APART * sigmas
    i, j = pairs[_apart(place, _ways(place, first, closed), pairs, curve, first, closed, least)].T
    if not len(i):
        return None
    starts, partners = _both_ways(i, j, len(place))
    nearest = np.full(len(place), np.inf)
    np.minimum.at(nearest, np.append(i, j), np.tile(np.linalg.norm(place[i] - place[j], axis=1), 2))
    heads, tails = (np.concatenate(part) for part in zip(*(line.segments() for line in lines), strict=True))
    spans = np.concatenate([np.column_stack((line.stations[:-1], line.stations[1:])) for line in lines])
    base = np.append(0, np.cumsum([len(line.ring) - 1 for line in lines]))
    segment = [b + _segments(line, s) for b, line, s in zip(base[:-1], lines, stations, strict=True)]
    step = np.maximum(lengths, 1e-9 * sigma) / (sizes - ~closed)
    return Branches(
        sigmas, cut, heads, tails, spans, base, first, closed,
        place, curve, np.concatenate(segment), step, starts, partners, nearest,
    )  # fmt: skip


def _stations(line: Polyline, length: float, spacing: float) -> Floats:
    pieces = max(int(np.ceil(length / spacing - 1e-9)), 3)  # rounding must not add one
    return np.linspace(0.0, length, pieces + (0 if line.closed else 1), endpoint=not line.closed)


def _segments(line: Polyline, station: Floats) -> Ints:
    """Numbers of the segments on which stations lie."""
    before = np.searchsorted(line.stations, station, "right") - 1
    return np.asarray(np.clip(before, 0, len(line.ring) - 2))


def _ways(place: Floats, first: Ints, closed: NDArray[np.bool_]) -> Floats:
    """Length of the chain of nodes before each node; every curve's ends with its closing edge."""
    steps = np.linalg.norm(np.diff(place, axis=0, append=place[:1]), axis=1)
    last = first[1:] - 1
    steps[last] = np.where(closed, np.linalg.norm(place[last] - place[first[:-1]], axis=1), 0.0)
    return np.append(0.0, np.cumsum(steps))


@njit(cache=True)
def _apart(place, way, pairs, curve, first, closed, least):  # type: ignore[no-untyped-def]
    """Which pairs of nodes may have places on different branches about them.

    On one curve, the way from before the one node to behind the other must exceed its chord: no
    two places between them can exceed theirs by more, by the triangle inequality.
    """
    out = np.ones(pairs.shape[0], np.bool_)
    for p in range(pairs.shape[0]):
        i, j = min(pairs[p, 0], pairs[p, 1]), max(pairs[p, 0], pairs[p, 1])
        k = curve[i]
        if k != curve[j]:
            continue
        base, size = first[k], first[k + 1] - first[k]
        i, j = i - base, j - base
        if closed[k]:
            if 2 * (j - i) > size:  # the shorter way round
                i, j = j, i + size
            i, j = i - 1, j + 1
        else:
            i, j = max(i - 1, 0), min(j + 1, size - 1)
        turns = j // size - i // size
        a, b = base + i % size, base + j % size
        length = way[b] - way[a] + turns * (way[base + size] - way[base])
        square = 0.0
        for e in range(3):
            square += (place[a, e] - place[b, e]) ** 2
        out[p] = length - np.sqrt(square) > least[k]
    return out


def _both_ways(i: Ints, j: Ints, count: int) -> tuple[Ints, Ints]:
    """Adjacency lists of the pairs, seen from both sides."""
    own, other = np.append(i, j), np.append(j, i)
    order = np.lexsort((other, own))
    return np.searchsorted(own[order], np.arange(count + 1)), other[order]
