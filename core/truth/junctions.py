"""Where open curves end on each other, and the readings that such a place leaves open.

An end that lies inside another curve is a T-junction: the other curve goes straight on, so that there
is one reading. Where three or more ends meet, no two of them need go on into each other, and any two
may: each way of joining them in pairs is the truth as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

__all__ = ["TOUCH", "apart", "diagonal", "joinings", "junctions"]

Floats = NDArray[np.float64]
Polyline = tuple[Floats, bool]
End = tuple[int, bool]  # of which open curve, and whether it is its last vertex
Pairs = list[tuple[End, End]]

TOUCH = 1e-4  # of the diagonal: more than the sag of a dense polyline's chords


def junctions(polylines: Sequence[Polyline]) -> Floats:
    """Return the places where an end of an open curve lies on another curve, shape (K, d).

    A place where several ends meet is returned once.

    Parameters
    ----------
    polylines : sequence of ((M, d) vertices, closed)
        Exact curves, finely sampled.
    """
    touch = TOUCH * diagonal(polylines)
    places: list[Floats] = []
    for end in _ends(polylines):
        place = _place(polylines, end)
        gaps = [_distance(place, one) for k, one in enumerate(polylines) if k != end[0]]
        known = any(np.linalg.norm(place - one) <= touch for one in places)
        if min(gaps, default=np.inf) <= touch and not known:
            places.append(place)
    return np.array(places).reshape(-1, polylines[0][0].shape[1])


def joinings(polylines: Sequence[Polyline]) -> Iterator[list[Polyline]]:
    """Yield the curves with their ends joined in every way where three or more meet; first as they are."""
    for pairings in product(*(list(_pairings(star)) for star in _stars(polylines))):
        joined = list(chain.from_iterable(pairings))
        yield _linked(polylines, dict(joined) | {b: a for a, b in joined})


def apart(locations: Floats, places: Floats, distance: float) -> NDArray[np.bool_]:
    """Tell which of (M, d) locations are farther than ``distance`` from every one of (K, d) places."""
    if not len(places) or not len(locations):
        return np.ones(len(locations), bool)
    return np.asarray(cdist(locations, places).min(axis=1) > distance)


def diagonal(polylines: Sequence[Polyline]) -> float:
    """Return the diagonal of the bounding box of all vertices."""
    return float(np.linalg.norm(np.ptp(np.concatenate([v for v, _ in polylines]), axis=0)))


def _ends(polylines: Sequence[Polyline]) -> list[End]:
    return [(k, last) for k, (_, closed) in enumerate(polylines) if not closed for last in (False, True)]


def _place(polylines: Sequence[Polyline], end: End) -> Floats:
    place: Floats = polylines[end[0]][0][-1 if end[1] else 0]
    return place


def _stars(polylines: Sequence[Polyline]) -> list[list[End]]:
    """Group the ends that share a place, three or more of them, where no curve passes."""
    touch = TOUCH * diagonal(polylines)
    stars: list[list[End]] = []
    for end in _ends(polylines):
        place = _place(polylines, end)
        near = [s for s in stars if np.linalg.norm(_place(polylines, s[0]) - place) <= touch]
        if near:
            near[0].append(end)
        else:
            stars.append([end])
    return [star for star in stars if len(star) > 2]


def _pairings(ends: Sequence[End]) -> Iterator[Pairs]:
    """Yield every set of disjoint pairs of the ends, the empty one first."""
    if len(ends) < 2:
        yield []
        return
    first, *rest = ends
    yield from _pairings(rest)
    for partner in rest:
        for more in _pairings([end for end in rest if end != partner]):
            yield [(first, partner), *more]


def _linked(polylines: Sequence[Polyline], partner: Mapping[End, End]) -> list[Polyline]:
    """Chain curves from end to end; curves that are joined to nobody stay as they are."""
    result = [one for one in polylines if one[1]]
    used: set[int] = set()
    every = _ends(polylines)
    for start in [*(end for end in every if end not in partner), *every]:  # rings have no free end
        if start[0] in used:
            continue
        pieces, end = [], start
        while end[0] not in used:
            used.add(end[0])
            vertices = polylines[end[0]][0]
            pieces.append(vertices[::-1] if end[1] else vertices)
            end = partner.get((end[0], not end[1]), end)
        ring = start in partner
        chained = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
        result.append((chained[:-1], True) if ring else (chained, False))
    return result


def _distance(place: Floats, polyline: Polyline) -> float:
    """Distance from a place to a polyline."""
    vertices, closed = polyline
    start = vertices if closed else vertices[:-1]
    edge = (np.roll(vertices, -1, axis=0) if closed else vertices[1:]) - start
    along = np.einsum("ij,ij->i", place - start, edge) / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
    foot = start + np.clip(along, 0.0, 1.0)[:, None] * edge
    return float(np.linalg.norm(foot - place, axis=1).min())
