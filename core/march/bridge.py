"""Bridges between ends of fragments: which are admissible, and what each costs.

Whether two ends belong together is asked of the samples: a bridge is refused when the
Poisson likelihood says that its corridor is empty.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.sampling import Sample
from core.march.fragments import Fragment
from core.march.strip import HALF_WIDTH, SIGMA
from core.march.walk import DENSITY, RADIUS, is_empty
from core.refine.polyline import Polyline
from core.refine.project import project

__all__ = ["Bridge", "End", "admissible_bridges", "tip_of"]

Floats = NDArray[np.float64]

CONFIDENCE = 5.0  # added to ln N: how sure a corridor's emptiness must be
SHARPEST = np.cos(np.radians(80.0))
MOST_BRIDGES = 400
TOUCHING = 4.0  # in sigma: ends this close are one place, whatever their directions (a sharp tip)
# Last fits see half a strip and may point astray: ends are also tried with a node or two taken back.
DEPTHS = ((0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2))
COST_OF_DEPTH = 0.5
BOW = 0.08  # of its length: how far a curve may bow from a bridge, where the noise is less
CHEAP = 1.0  # a bridge this good is not looked at further


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """An open end.

    Attributes
    ----------
    fragment : int
    last : bool
        Whether it is at the fragment's last node or its first.
    depth : int
        Nodes taken back.
    place, outward : (3,) array
    sigma, density, radius : float
        Noise, samples per unit length and strip length there.
    """

    fragment: int
    last: bool
    depth: int
    place: Floats
    outward: Floats
    sigma: float
    density: float
    radius: float

    @classmethod
    def of(cls, index: int, fragment: Fragment, last: bool, depth: int = 0) -> End:
        """The end of a fragment."""
        nodes = fragment.nodes if last else fragment.nodes[::-1]
        node, typical = nodes[-1 - depth], nodes[-4:]
        return cls(
            fragment=index,
            last=last,
            depth=depth,
            place=node[:3],
            outward=node[3:6] if last else -node[3:6],
            sigma=float(np.median(typical[:, SIGMA])),
            density=float(np.max(typical[:, DENSITY])),
            radius=float(np.max(typical[:, RADIUS])),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Bridge:
    """A way from one end to another; ``between`` (K, 3) are vertices to insert."""

    cost: float
    first: End
    second: End
    between: Floats


def admissible_bridges(sample: Sample, opened: list[Fragment]) -> list[Bridge]:
    """All bridges that the samples allow, the shortest and straightest first.

    Parameters
    ----------
    sample : Sample
    opened : list of Fragment
        Open ones.
    """
    confidence = float(np.log(max(len(sample.many), 2))) + CONFIDENCE
    ends = [(k, last) for k in range(len(opened)) for last in (False, True)]
    places = np.array([opened[k].nodes[-1 if last else 0, :3] for k, last in ends])
    pairs = sorted((float(np.linalg.norm(places[a] - places[b])), a, b) for a, b in _near_pairs(places))
    found = (_best_bridge(sample, confidence, opened, ends[a], ends[b]) for _, a, b in pairs[:MOST_BRIDGES])
    return sorted((bridge for bridge in found if bridge is not None), key=lambda bridge: bridge.cost)


def _near_pairs(places: Floats) -> list[tuple[int, int]]:
    """All pairs of ends, or each end's nearest ones where there are very many."""
    if len(places) <= 60:
        return list(combinations(range(len(places)), 2))
    _, near = cKDTree(places).query(places, 8)
    return sorted(
        {(min(a, b), max(a, b)) for a, row in enumerate(np.asarray(near).tolist()) for b in row if a != b}
    )


def _best_bridge(
    sample: Sample, confidence: float, opened: list[Fragment], a: tuple[int, bool], b: tuple[int, bool]
) -> Bridge | None:
    """The cheapest bridge between two ends, with as few nodes taken back as will do."""
    best: Bridge | None = None
    for depth_a, depth_b in DEPTHS:
        if _too_short(opened, a[0], b[0], depth_a, depth_b):
            continue
        first, second = End.of(a[0], opened[a[0]], a[1], depth_a), End.of(b[0], opened[b[0]], b[1], depth_b)
        bridge = _bridge(sample, confidence, first, second, opened)
        if bridge is not None and (best is None or bridge.cost < best.cost):
            best = bridge
        if best is not None and best.cost < CHEAP:
            break
    return best


def _too_short(opened: list[Fragment], a: int, b: int, depth_a: int, depth_b: int) -> bool:
    if a == b:
        return len(opened[a].nodes) < 5 + depth_a + depth_b
    return min(len(opened[a].nodes) - 2 * depth_a, len(opened[b].nodes) - 2 * depth_b) < 3


def _bridge(sample: Sample, confidence: float, a: End, b: End, opened: list[Fragment]) -> Bridge | None:
    """The better of a straight bridge and one around a corner; None when neither is admissible."""
    density, sigma, radius = min(a.density, b.density), max(a.sigma, b.sigma), max(a.radius, b.radius)
    gap = float(np.linalg.norm(b.place - a.place))
    if gap > max(2.0 * confidence / density, 4.0 * sigma + 2.0 * radius):
        return None
    if a.fragment == b.fragment and opened[a.fragment].length < 3.0 * gap:
        return None
    best = None
    for turn, between in _options(a, b, gap, density, sigma, radius):
        path = np.concatenate([a.place[None], between, b.place[None]])
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        reach = max(HALF_WIDTH * sigma, BOW * length)
        rims = 0.0, min(reach, length / 3.0)
        seen, inside = (_support(sample.few, path, reach, rim) / sample.thinning for rim in rims)
        expected = density * length
        if is_empty(seen, expected, confidence) or (len(between) and seen < 0.5 * expected):
            continue
        # Samples about the ends themselves do not tell that there are any between them.
        if is_empty(inside, density * max(length - 2.0 * reach, length / 3.0), confidence):
            continue
        missing = max(expected - seen, 0.0)
        cost = missing / confidence + turn + length / radius + COST_OF_DEPTH * (a.depth + b.depth)
        if best is None or cost < best.cost:
            best = Bridge(cost, a, b, between)
    return best


def _options(
    a: End, b: End, gap: float, density: float, sigma: float, radius: float
) -> list[tuple[float, Floats]]:
    """Ways to go, each with the cost of its turns: straight on, touching, around a corner."""
    straight = np.zeros((0, 3))
    options: list[tuple[float, Floats]] = []
    chord = (b.place - a.place) / max(gap, 1e-300)
    cosines = np.array([a.outward @ chord, -b.outward @ chord])
    facing = float(a.outward @ b.outward)
    if gap < 0.75 * radius and facing < -0.5:  # ends that have passed each other count as one place
        options.append((0.0, straight))
    elif cosines.min() > SHARPEST and facing < 0.5:
        options.append((float(np.sum(np.arccos(np.minimum(cosines, 1.0)) ** 2)), straight))
    elif gap < TOUCHING * sigma + 2.0 / density:
        options.append((2.0, straight))
    corner = _corner(a, b, sigma)
    return options if corner is None else [*options, (1.0, corner[None])]


def _support(few: Floats, path: Floats, reach: float, rim: float) -> float:
    """Number of samples beside the path, so much at its ends left out."""
    line = Polyline(path, False)
    length = line.length
    if length <= 0.0:
        return 0.0
    feet = project(few, [line], max(reach, 1e-9))
    inner = (feet.curve >= 0) & (feet.station > rim) & (feet.station < length - rim)
    return float(np.count_nonzero(inner))


def _corner(a: End, b: End, sigma: float) -> Floats | None:
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


def tip_of(sample: Sample, end: End, fragment: Fragment) -> Floats:
    """Vertices from an open end to where its samples run out, along the last fit's parabola.

    The march stops when too few samples are ahead for a fit: up to a radius early.

    Parameters
    ----------
    sample : Sample
    end : End
    fragment : Fragment
        The one that it ends.

    Returns
    -------
    (K, 3) array
    """
    few, thinning = sample.few, sample.thinning
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
    return np.asarray(end.place + inner[:, None] * end.outward + 0.5 * inner[:, None] ** 2 * node[6:9])
