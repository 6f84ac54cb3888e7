"""Levels that were not seen whole, completed from a guide (§5.1.1).

The guide tells which loops there are and how they run: the contours between the neighbours, or a first
guess that is shown. Where the level has samples of its own they tell where: each place of a loop moves
onto the level's own curve if that lies near and runs alike, and elsewhere by what the places at both
ends of the gap have moved. Loops that the level has seen whole stand as they are, whatever the guide
makes of them, and what it has seen of a loop that the guide does not know is completed from one side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.surface.draft import STRAY, Draft, is_simple
from core.surface.evidence import NOISE, SAME, Evidence, mean_step, refined
from core.surface.interpolated import Stratum, between, closest, resampled, signed_distances, steps_of

__all__ = ["completed_loops"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

_CELLS = 256  # of the grid of distances, along the longer edge
_STEEP = 2.0  # how far a contour moves from level to level, in distances between them, beyond what is seen
_STEEPER = 6.0  # the same for contours that only one side knows: they end soon, where surfaces are flat
_MOSTLY = 0.5  # share of a contour that must have been seen where it has a neighbour on one side only
_ALIKE = 0.7  # cosine between directions of a contour and of its neighbours'
_FADE = 2.0  # way, in distances between the neighbours, over which what the end of a gap tells fades
_ACROSS = 0.5  # of an offset's length may lie along the curve: more is the way round an open end
_NORMAL = 1.4826  # standard deviations of normal noise in a median distance
_UNTANGLINGS = 4  # rounds, each with a wider neighbourhood of the crossings


def completed_loops(
    draft: Draft,
    points: Floats,
    below: Sequence[Draft],
    above: Sequence[Draft],
    shown: Sequence[Floats] | None = None,
) -> list[Floats]:
    """Return the contours of an incomplete level.

    Parameters
    ----------
    draft : Draft
        What the level says by itself; it may be nothing.
    points : (N, 2) array
        Its samples, in the plane.
    below, above : sequences of Draft
        Complete levels, the nearest first; two of each are enough, and each of them may be empty.
    shown : sequence of (M, 2) arrays, optional
        Closed first guesses of the level's contours, by which it is completed rather than by its neighbours.

    Returns
    -------
    list of (M, 2) arrays
        Closed, without crossings. Empty without any guide, and beyond the last complete level where less
        than half of the contours was seen and nothing is shown: nobody knows whether they go on.
    """
    own = Evidence(draft, points, max((one.sigma for one in (*below[:1], *above[:1])), default=0.0))
    guide = _shown(shown, own) if shown and is_simple(shown) else _guide(draft, below, above)
    if guide is None:
        return []
    if not own.curves or not len(points):
        return [] if guide.one_sided else guide.loops
    fits = _fits(own, guide)
    if guide.one_sided and np.concatenate([one.seen for one in fits]).mean() < _MOSTLY:
        return []
    others = [_beside(draft, one) for one in (below[:1], above[:1]) if one and one[0].loops]
    best = _best(_candidates(fits, own, [] if guide.one_sided else others), own)
    return refined(best, own) if best else guide.loops


@dataclass(frozen=True, slots=True, eq=False)
class _Guide:
    """First guesses of a level's contours, with vertices close to each other.

    ``beside`` has the contours that they were made of, level by level: the level's own may lie as far off
    as these do, and ``slack`` farther. What the end of a gap tells has faded after the way ``fade``.
    """

    loops: list[Floats]
    beside: list[list[Floats]]
    slack: float
    fade: float
    one_sided: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """A loop of a guide, moved; which of its vertices the level has seen, and which on loops seen whole."""

    guess: Floats
    loop: Floats
    seen: Bools
    whole: Bools

    @property
    def is_known(self) -> bool:
        """Whether the loops that the level has seen whole say what there is to say."""
        return bool(self.whole.mean() >= _MOSTLY)

    @property
    def is_moored(self) -> bool:
        """Whether anything holds it but loops that the level has seen whole."""
        return bool(np.any(self.seen & ~self.whole))


def _guide(draft: Draft, below: Sequence[Draft], above: Sequence[Draft]) -> _Guide | None:
    """Return the contours that the neighbours tell of."""
    near = [*below[:1], *above[:1]]
    if not near or not all(one.loops for one in near):
        return None
    if len(near) == 1:
        return _beside(draft, near, _STEEP)
    beside = [_loops(one) for one in near]
    pitch = _pitch([loop for loops in beside for loop in loops])
    strata = [Stratum(one.height, _loops(one)) for one in _used(below, above)]
    loops = [resampled(loop, pitch, closed=True) for loop in between(strata, draft.height, pitch)]
    return _Guide(loops, beside, 0.0, _FADE * (near[1].height - near[0].height)) if loops else None


def _beside(draft: Draft, near: Sequence[Draft], steep: float = _STEEPER) -> _Guide:
    """Return the contours of one level as a guide for another."""
    loops, slack = _loops(near[0]), steep * abs(near[0].height - draft.height)
    pitch = _pitch(loops)
    return _Guide([resampled(one, pitch, closed=True) for one in loops], [loops], slack, np.inf, True)


def _shown(shown: Sequence[Floats], own: Evidence) -> _Guide:
    """Return first guesses as a guide; they may lie as far off as the level's samples tell."""
    pitch = _pitch(shown)
    loops = [resampled(one, pitch, closed=True) for one in shown]
    if not len(own.points):
        return _Guide(loops, [], 0.0, np.inf)
    off = float(np.median(np.linalg.norm(own.points - closest(loops, own.points)[0], axis=1)))
    return _Guide(loops, [], NOISE * _NORMAL * off, _FADE * own.limit)


def _loops(draft: Draft) -> list[Floats]:
    return [one.vertices for one in draft.loops]


def _pitch(loops: Sequence[Floats]) -> float:
    return float(np.ptp(np.concatenate(loops), axis=0).max()) / _CELLS


def _used(below: Sequence[Draft], above: Sequence[Draft]) -> list[Draft]:
    """Return the levels to interpolate from: the nearest, and beyond them those with as many contours."""
    inner, outer = [below[0], above[0]], [*below[1:2], *above[1:2]]
    counts = {len(one.loops) for one in inner}
    alike = [one for one in outer if len(counts) == 1 and len(one.loops) in counts]
    return sorted([*inner, *alike], key=lambda one: one.height)


def _fits(own: Evidence, guide: _Guide) -> list[_Fit]:
    """Move the loops of a guide onto what the level has seen."""
    step = min(mean_step(guide.loops), own.limit)
    fine = [resampled(one, step, closed=False) for one in own.curves]
    vertices = cKDTree(np.concatenate(fine))
    whole = np.repeat(own.whole, [len(one) for one in fine])
    result = []
    for one in guide.loops:
        feet, along = closest(fine, one, closed=False)
        seen = _is_seen(one, feet, along, _reach(one, own, guide))
        seen &= own.samples.query(feet)[0] <= own.limit
        moved = one + _carried(one, feet - one, seen, own.limit, guide.fade)
        result.append(_Fit(one, moved, seen, seen & whole[vertices.query(feet)[1]]))
    return result


def _candidates(fits: Sequence[_Fit], own: Evidence, others: Sequence[_Guide]) -> Iterator[list[Floats]]:
    """Yield sets of contours: first with what the level has seen whole, then as the guide has them."""
    for kept in ([one for one in fits if not one.is_known], fits):
        yield _extended(_with_whole(kept, own), own, others)
    yield [one.loop for one in fits]
    yield _untangled(fits, own.limit)


def _best(candidates: Iterator[list[Floats]], own: Evidence) -> list[Floats]:
    """Return the first contours without crossings that leave hardly any samples over, or the fewest."""
    best, least = list[Floats](), np.inf
    for one in candidates:
        left = own.without(one) if one and is_simple(one) else np.inf
        if left < least:
            best, least = one, left
        if least <= STRAY:
            break
    return best


def _with_whole(kept: Sequence[_Fit], own: Evidence) -> list[Floats]:
    """Add the loops that the level has seen whole and no other follows; guesses in their place go."""
    loops = [one.loop for one in kept]
    rings = [one[:-1] for one, whole in zip(own.curves, own.whole, strict=True) if whole]
    added = [one for one in rings if _apart(one, loops)]
    return [one.loop for one in kept if one.is_moored or not _encloses_same(one.loop, added)] + added


def _extended(loops: list[Floats], own: Evidence, others: Sequence[_Guide]) -> list[Floats]:
    """Add contours that only one neighbour knows, where samples are left over and show most of them.

    Contours within each other come together or not at all: one alone turns matter into space.
    """
    for guide in others:
        if own.without(loops) <= STRAY:
            break
        for family in _families(guide.loops, _fits(own, guide)):
            new = [one for one in family if _apart(one.loop[one.seen], loops)]
            known = all(one.seen.mean() >= _MOSTLY for one in family)
            if new and known and is_simple([*loops, *(one.loop for one in new)]):
                loops = [*loops, *(one.loop for one in new)]
    return loops


def _families(loops: Sequence[Floats], fits: Sequence[_Fit]) -> list[list[_Fit]]:
    """Gather what becomes of loops that lie within each other."""
    plain = map(shapely.Polygon, loops)
    rings = [shapely.make_valid(one, method="structure", keep_collapsed=False) for one in plain]
    parts = shapely.get_parts(shapely.union_all(rings))
    first = [next((k for k, part in enumerate(parts) if part.intersects(ring)), -1) for ring in rings]
    return [[one for one, at in zip(fits, first, strict=True) if at == k] for k in range(len(parts))]


def _untangled(fits: Sequence[_Fit], reach: float) -> list[Floats]:
    """Return moved loops that stay what they were about the places where they would cross."""
    loops, known = [one.loop for one in fits], np.zeros((0, 2))
    for _ in range(_UNTANGLINGS):
        knots = _knots(loops)
        if not len(knots):
            break
        known = np.vstack((known, knots))
        near = [cKDTree(known).query(one.guess)[0] for one in fits]
        shares = [np.clip(distance / reach, 0.0, 1.0)[:, None] for distance in near]
        loops = [one.guess + share * (one.loop - one.guess) for one, share in zip(fits, shares, strict=True)]
        reach *= 2.0
    return loops


def _knots(loops: Sequence[Floats]) -> Floats:
    """Return where closed curves cross themselves or each other, (K, 2)."""
    ends = np.concatenate([np.stack((one, np.roll(one, -1, axis=0)), axis=1) for one in loops])
    sizes = np.array([len(one) for one in loops])
    size = np.repeat(sizes, sizes)
    first = np.repeat(np.cumsum(sizes) - sizes, sizes)
    edges = shapely.linestrings(ends)
    a, b = shapely.STRtree(edges).query(edges, predicate="intersects")
    apart = np.mod(b - a, size[a])
    pairs = (a < b) & ((first[a] != first[b]) | ((apart > 1) & (apart < size[a] - 1)))
    places = shapely.centroid(shapely.intersection(edges[a[pairs]], edges[b[pairs]]))
    return np.asarray(shapely.get_coordinates(places), np.float64)


def _apart(places: Floats, loops: Sequence[Floats]) -> bool:
    """Tell whether most places lie beside contours, by more than these are rounded by."""
    if not loops or not len(places):
        return True
    distance = np.linalg.norm(places - closest(loops, places)[0], axis=1)
    return bool(np.mean(distance > SAME * mean_step(loops)) > _MOSTLY)


def _encloses_same(loop: Floats, others: Sequence[Floats]) -> bool:
    """Tell whether a loop encloses mostly the same as those of the others that lie in it, or about it."""
    ring = shapely.Polygon(loop)
    rings = [one for one in map(shapely.Polygon, others) if one.is_valid]
    if not ring.is_valid or not rings:
        return False
    inner = [one for one in rings if ring.intersection(one).area > _MOSTLY * one.area]
    together = [*rings, shapely.union_all(inner)]
    return any(ring.intersection(one).area > _MOSTLY * ring.union(one).area for one in together)


def _reach(loop: Floats, own: Evidence, guide: _Guide) -> Floats:
    """Return how far the level's own curve may lie from each vertex."""
    result = np.full(len(loop), NOISE * own.draft.sigma + guide.slack)
    for one in guide.beside:
        result += np.abs(signed_distances(one, loop))
    return result


def _is_seen(loop: Floats, feet: Floats, along: Floats, reach: Floats) -> Bools:
    """Tell for each vertex whether its foot on the level's own curves is a place of the same contour."""
    offset = feet - loop
    way = np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), np.finfo(float).tiny)
    size = np.linalg.norm(offset, axis=1)
    across = np.abs(np.einsum("ij,ij->i", offset, along)) <= _ACROSS * size + 1e-9 * reach
    alike = np.abs(np.einsum("ij,ij->i", way, along)) >= _ALIKE
    return np.asarray((size <= reach) & across & alike)


def _carried(loop: Floats, offset: Floats, seen: Bools, margin: float, fade: float) -> Floats:
    """Return the offsets where they were seen, and in gaps what both ends tell, fading with the way.

    What was seen within ``margin`` of a gap does not count: ends of curves are their worst parts.
    """
    steps = steps_of(loop)
    arc, length = np.cumsum(steps) - steps, float(steps.sum())
    seen = seen & (_way_to(arc, ~seen, length) > margin)
    if not seen.any():
        return np.zeros_like(offset)
    columns = [np.interp(arc, arc[seen], offset[seen, k], period=length) for k in range(2)]
    return np.stack(columns, axis=1) * np.exp(-_way_to(arc, seen, length) / fade)[:, None]


def _way_to(arc: Floats, marked: Bools, length: float) -> Floats:
    """Return the way along a closed curve from each vertex to the nearest marked one."""
    places = arc[marked]
    if not len(places):
        return np.full(len(arc), np.inf)
    around = np.concatenate((places - length, places, places + length))
    after = np.searchsorted(around, arc)
    return np.asarray(np.minimum(around[after] - arc, arc - around[after - 1]))
