"""From fragments to curves: drop what is explained twice, then join ends (§4.2.2, §5.1).

Whether two ends belong together is asked of the samples: a bridge is refused when the
Poisson likelihood says that its corridor is empty, and of the admissible bridges the
shortest and straightest are taken first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.march.fragments import Fragment
from core.march.strip import HALF_WIDTH, SIGMA
from core.march.walk import DENSITY, RADIUS, is_empty
from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["join_fragments", "prune_fragments"]

Floats = NDArray[np.float64]

CONFIDENCE = 5.0  # added to ln N: how sure a corridor's emptiness must be
EXCLUSIVE = 0.35  # share of a fragment's samples that no other fragment explains
SHARPEST = np.cos(np.radians(80.0))
MOST_BRIDGES = 400
TOUCHING = 4.0  # in sigma: ends this close are one place, whatever their directions (a sharp tip)


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """An open end: which fragment, its last (True) or first node, place and outward direction."""

    fragment: int
    last: bool
    place: Floats
    outward: Floats
    sigma: float
    density: float
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class _Bridge:
    """A way from one end to another; ``between`` are vertices to insert."""

    cost: float
    first: _End
    second: _End
    between: Floats


def prune_fragments(sample: Sample, fragments: list[Fragment], sigma: float) -> list[Fragment]:
    """Drop fragments most of whose samples another fragment explains as well.

    Parameters
    ----------
    sample : Sample
    fragments : list of Fragment
    sigma : float
        Noise standard deviation.
    """
    reach = max(HALF_WIDTH * sigma, 1e-9)
    kept = list(fragments)
    while len(kept) > 1:
        feet = project(sample.few, [_line(f) for f in kept], reach, rivals=True)
        size = len(kept)
        own = np.bincount(feet.curve[feet.curve >= 0], minlength=size)
        # Samples at a fragment's side of the middle count for it, those beyond 1.5 sigma of others exclusively.
        alone = np.bincount(feet.curve[(feet.curve >= 0) & (feet.other > reach)], minlength=size)
        share = alone / np.maximum(own, 1)
        expected = np.array([f.length * float(np.median(f.nodes[:, DENSITY])) for f in kept]) * (
            sample.thinning
        )
        share = np.minimum(share, alone / np.maximum(expected, 1.0))
        worst = int(np.argmin(share + 1e-6 * np.array([f.length for f in kept])))
        if share[worst] >= EXCLUSIVE:
            break
        del kept[worst]
    return kept


def _line(fragment: Fragment) -> Polyline:
    return Polyline(fragment.centres, fragment.closed)


def join_fragments(sample: Sample, fragments: list[Fragment]) -> list[Polyline]:
    """Join ends of fragments where the samples allow it; ends of one fragment close it.

    Parameters
    ----------
    sample : Sample
    fragments : list of Fragment

    Returns
    -------
    list of Polyline
    """
    done = [_line(f) for f in fragments if f.closed]
    opened = _without_overlaps([f for f in fragments if not f.closed])
    if not opened:
        return done
    ends = [_end(k, f, last) for k, f in enumerate(opened) for last in (False, True)]
    few, thinning = sample.few, sample.thinning
    bridges = _bridges(few, thinning, len(sample.points), opened, ends)
    tips = {(e.fragment, e.last): _tip(few, thinning, e, opened[e.fragment]) for e in ends}
    return done + _assemble(opened, bridges, tips)


def _without_overlaps(opened: list[Fragment]) -> list[Fragment]:
    """Shorten ends that run along a stretch which another end, or their own start, covers too."""
    out = list(opened)
    for k in range(len(out)):
        for last in (True, False):
            while len(out[k].nodes) > 4 and _runs_along(out, k, last):
                out[k] = Fragment(out[k].nodes[:-1] if last else out[k].nodes[1:], False)
    return out


def _runs_along(opened: list[Fragment], k: int, last: bool) -> bool:
    """Whether the end node of fragment ``k`` lies on some stretch, seen from that stretch's own fits."""
    own = opened[k].nodes if last else opened[k].nodes[::-1]
    node = own[-1]
    way = np.linalg.norm(np.diff(own[::-1, :3], axis=0), axis=1).cumsum()
    far = own[::-1][1:][way > 2.5 * node[RADIUS]]
    others = np.concatenate([far] + [f.nodes[1:-1] for j, f in enumerate(opened) if j != k])
    if not len(others):
        return False
    offset = node[:3] - others[:, :3]
    t = np.einsum("ij,ij->i", offset, others[:, 3:6])
    bow = offset - t[:, None] * others[:, 3:6] - 0.5 * t[:, None] ** 2 * others[:, 6:9]
    beside = np.linalg.norm(bow, axis=1) < 1.5 * others[:, SIGMA] + 0.05 * others[:, RADIUS]
    aligned = np.abs(others[:, 3:6] @ node[3:6]) > 0.8
    # The far end of the own course covers only what lies inward of it.
    inward = np.ones(len(others), np.bool_)
    if len(far):
        first = len(far) - 1
        inward[first] = (t[first] > 0.0) == last
    return bool(np.any(beside & aligned & inward & (np.abs(t) < 0.6 * others[:, RADIUS])))


def _tip(few: Floats, thinning: float, end: _End, fragment: Fragment) -> Floats:
    """Vertices from an open end to where its samples run out, along the last fit's parabola.

    The march stops when too few samples are ahead for a fit: up to a radius early.
    """
    node = fragment.nodes[-1 if end.last else 0]
    reach = end.radius * np.arange(0.0, 1.01, 0.25)
    course = end.place + reach[:, None] * end.outward + 0.5 * reach[:, None] ** 2 * node[6:9]
    feet = project(few, [Polyline(course, False)], max(HALF_WIDTH * end.sigma, 1e-9))
    stations = np.sort(feet.station[(feet.curve == 0) & (feet.station > 0.0)])
    # Samples are followed as long as they come: a hole wider than iid samples leave is an end.
    hole = (np.log1p(end.density * thinning * end.radius) + 3.0) / (end.density * thinning)
    holes = np.flatnonzero(np.diff(stations, prepend=0.0) > hole)
    stations = stations[: holes[0]] if len(holes) else stations
    inner = reach[1:][reach[1:] < (stations[-1] if len(stations) else 0.0)]
    return end.place + inner[:, None] * end.outward + 0.5 * inner[:, None] ** 2 * node[6:9]


def _end(index: int, fragment: Fragment, last: bool) -> _End:
    node = fragment.nodes[-1 if last else 0]
    outward = node[3:6] if last else -node[3:6]
    typical = fragment.nodes[-4:] if last else fragment.nodes[:4]
    return _End(
        index, last, node[:3], outward, float(np.median(typical[:, SIGMA])),
        float(np.max(typical[:, DENSITY])), float(np.max(typical[:, RADIUS])),
    )  # fmt: skip


def _bridges(
    few: Floats, thinning: float, count: int, opened: list[Fragment], ends: list[_End]
) -> list[_Bridge]:
    """All admissible bridges, the cheapest first."""
    confidence = float(np.log(max(count, 2))) + CONFIDENCE
    places = np.array([e.place for e in ends])
    pairs = []
    for a in range(len(ends)):
        gap = np.linalg.norm(places[a + 1 :] - places[a], axis=1)
        pairs += [(float(g), a, a + 1 + b) for b, g in enumerate(gap)]
    pairs.sort()
    out = []
    for gap, a, b in pairs[:MOST_BRIDGES]:
        bridge = _bridge(few, thinning, confidence, gap, ends[a], ends[b], opened)
        if bridge is not None:
            out.append(bridge)
    return sorted(out, key=lambda bridge: bridge.cost)


def _bridge(
    few: Floats, thinning: float, confidence: float, gap: float, a: _End, b: _End, opened: list[Fragment]
) -> _Bridge | None:
    """The better of a straight bridge and one around a corner; None when neither is admissible."""
    density = min(a.density, b.density)
    sigma = max(a.sigma, b.sigma)
    far = max(2.0 * confidence / density, 4.0 * sigma + 2.0 * max(a.radius, b.radius))
    if gap > far or (
        a.fragment == b.fragment
        and (len(opened[a.fragment].nodes) < 5 or opened[a.fragment].length < 3.0 * gap)
    ):
        return None
    options = []
    chord = b.place - a.place
    cos_a, cos_b = float(a.outward @ chord) / max(gap, 1e-300), float(-b.outward @ chord) / max(gap, 1e-300)
    facing = float(a.outward @ b.outward)
    near = gap < 0.75 * max(a.radius, b.radius) and facing < -0.5
    if near or (min(cos_a, cos_b) > SHARPEST and facing < 0.5):
        turn = 0.0 if near else float(np.arccos(min(cos_a, 1.0)) ** 2 + np.arccos(min(cos_b, 1.0)) ** 2)
        options.append((turn, np.zeros((0, 3))))
    elif gap < TOUCHING * sigma + 2.0 / density:
        options.append((2.0, np.zeros((0, 3))))
    corner = _corner(a, b, sigma)
    if corner is not None:
        options.append((1.0, corner[None]))
    best = None
    for turn, between in options:
        path = np.concatenate([a.place[None], between, b.place[None]])
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        seen = _support(few, path, HALF_WIDTH * sigma) / thinning
        expected = density * length
        if is_empty(seen, expected, confidence) or (len(between) and seen < 0.5 * expected):
            continue
        cost = length * density / confidence + turn + length / max(a.radius, b.radius)
        if best is None or cost < best.cost:
            best = _Bridge(cost, a, b, between)
    return best


def _support(few: Floats, path: Floats, reach: float) -> float:
    """Number of samples beside the path, its ends' caps left out."""
    line = Polyline(path, False)
    length = line.length
    if length <= 0.0:
        return 0.0
    feet = project(few, [line], max(reach, 1e-9))
    inner = (feet.curve >= 0) & (feet.station > 0.0) & (feet.station < length)
    return float(np.count_nonzero(inner))


def _corner(a: _End, b: _End, sigma: float) -> Floats | None:
    """Where the tangents at two ends meet ahead of both, not farther than a strip's length."""
    w = b.place - a.place
    c = float(a.outward @ b.outward)
    spread = 1.0 - c * c
    if spread < 0.05:
        return None
    t = (float(a.outward @ w) - c * float(b.outward @ w)) / spread
    u = (c * float(a.outward @ w) - float(b.outward @ w)) / spread
    reach = 2.0 * max(a.radius, b.radius) + 6.0 * sigma
    if not (-sigma < t < reach and -sigma < u < reach):
        return None
    p, q = a.place + t * a.outward, b.place + u * b.outward
    return 0.5 * (p + q) if float(np.linalg.norm(p - q)) < 3.0 * sigma else None


def _assemble(
    opened: list[Fragment], bridges: list[_Bridge], tips: dict[tuple[int, bool], Floats]
) -> list[Polyline]:
    """Take bridges greedily, then read the chains of fragments off."""
    link: dict[tuple[int, bool], tuple[_Bridge, tuple[int, bool]]] = {}
    for bridge in bridges:
        a, b = (bridge.first.fragment, bridge.first.last), (bridge.second.fragment, bridge.second.last)
        if a not in link and b not in link:
            link[a], link[b] = (bridge, b), (bridge, a)
    used = [False] * len(opened)
    lines = []
    starts = [(k, last) for k in range(len(opened)) for last in (False, True) if (k, last) not in link]
    for k, last in starts + [(k, False) for k in range(len(opened))]:
        if not used[k]:
            lines.append(_chain(opened, link, used, k, last, tips))
    return lines


def _chain(
    opened: list[Fragment],
    link: dict[tuple[int, bool], tuple[_Bridge, tuple[int, bool]]],
    used: list[bool],
    k: int,
    entered_at_last: bool,
    tips: dict[tuple[int, bool], Floats],
) -> Polyline:
    """Follow links from one end until an open end or the start is reached."""
    first = k
    parts: list[Floats] = [] if (k, entered_at_last) in link else [tips[k, entered_at_last][::-1]]
    while True:
        used[k] = True
        centres = opened[k].centres
        parts.append(centres[::-1] if entered_at_last else centres)
        exit_end = (k, not entered_at_last)
        if exit_end not in link:
            parts.append(tips[exit_end])
            return Polyline(np.concatenate(parts), False)
        bridge, (k, entered_at_last) = link[exit_end]
        parts.append(bridge.between)
        if used[k]:
            return Polyline(np.concatenate(parts), k == first)
