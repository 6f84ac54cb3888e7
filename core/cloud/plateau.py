"""The hop that joins what belongs together, from the shortest that may to one four times as long (§3.3).

From the shortest hop upward, parts of curves come together; beyond, different curves touch one
another. In between nothing merges over some range of hops, the wider the better. Where it is
narrow, how the curves lie that the next hop would join tells which of the two they are: parts
of one curve meet end to end, different curves mostly beside each other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.linkage import components
from core.cloud.sampling import spread_subsample

__all__ = ["Witnesses", "clearest", "least_component_size"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CANDIDATES = 20_000  # points by which meetings are looked at
LEAST_SEEN = 5  # of them, on either side
# The epsilons considered: RATIO^0 … RATIO^(STEPS - 1) times the shortest, a range of 1 : 3.9.
RATIO = 1.12
STEPS = 13
# An epsilon is a clear choice when it lies amid this many steps that merge nothing: a factor of 1.76.
PLATEAU = 5
# Or amid this many, of which the last is this far from the shortest, when beyond it curves meet sideways:
# parts of one curve meet end to end.
SHORT = 2
SAFE = 3
FAR = 6  # beyond this, no independent sample leaves gaps: what meets end to end are two curves
# Parts lie beside each other where the centres of their samples, within so many hops, are apart across.
NEAR = 6.0
ASIDE = 0.5
# Components of six times the least size count as curves when plateaus are sought: clumps of outliers do not.
CURVE = 6
# The longest hop may cover this much more of the points than the one chosen.
DUST = 0.1
# One curve that covers so much needs no comparison with longer hops.
WHOLE = 0.8
# The same of the length that the probes stand for: sparse parts are long, however few their samples.
LENGTH_DUST = 0.05
LENGTH_WHOLE = 0.95
# A component of so much of that length is a curve.
LONG = 0.03


def least_component_size(count: int) -> int:
    """Size below which a component of ``count`` points is taken for outliers: ceil(ln N) + 1.

    Clumps of outliers grow rarer exponentially with their size, so that the largest to
    be expected grows with ln N. Never more than N.
    """
    return math.ceil(math.log(count)) + 1


def clearest(points: Floats, shortest: float, witnesses: Witnesses) -> float:
    """Find the first epsilon from the shortest upward beyond which nothing merges over a wide range."""
    ladder = Ladder(points, shortest, witnesses, {})
    top = STEPS - 1
    if ladder.curves(0) == 1 and ladder.covered(0) > WHOLE and ladder.length(0) > LENGTH_WHOLE:
        return ladder.epsilon(top / 2)
    step = 0
    while step < top and (
        ladder.covered(step) < ladder.covered(top) - DUST
        or ladder.length(step) < ladder.length(top) - LENGTH_DUST
    ):
        step += 1
    while step < top and ladder.curves(step) != ladder.curves(top):
        end = step
        while end < top and ladder.curves(end + 1) == ladder.curves(step):
            end += 1
        if _is_clear(ladder, step, end):
            return ladder.epsilon((step + end) / 2)
        step = end + 1
    return ladder.epsilon((step + top) / 2)


def _is_clear(ladder: Ladder, first: int, last: int) -> bool:
    """Whether the curves of these steps, all the same, are whole: longer hops only join different ones."""
    wide = last - first + 1 >= PLATEAU
    if last - first + 1 < SHORT or last < SAFE:
        return False
    if wide and last >= FAR:
        return True
    meeting = ladder.meeting(last)
    return meeting == "beside" or (wide and meeting == "unclear")


@dataclass(frozen=True, slots=True, eq=False)
class Witnesses:
    """Points on curves, by their index, and the length of curve that each stands for."""

    index: Ints
    length: Floats

    @classmethod
    def none(cls) -> Witnesses:
        """Nobody: all lengths are then covered."""
        return cls(np.zeros(0, np.int64), np.zeros(0))


@dataclass(frozen=True, slots=True, eq=False)
class Ladder:
    """Partitions of a point set at geometrically growing epsilons, computed when asked for."""

    points: Floats
    shortest: float
    witnesses: Witnesses
    known: dict[int, tuple[int, float, float]]

    def epsilon(self, step: float) -> float:
        """Hop of a step."""
        return self.shortest * float(RATIO**step)

    def curves(self, step: int) -> int:
        """Count the components large enough to be curves."""
        return self._census(step)[0]

    def covered(self, step: int) -> float:
        """Share of the points in components that are not taken for outliers."""
        return self._census(step)[1]

    def length(self, step: int) -> float:
        """Share of the length in components that are not taken for outliers."""
        return self._census(step)[2]

    def meeting(self, step: int) -> Literal["beside", "end to end", "unclear"]:
        """How the curves lie that the next step joins; end to end when any two do."""
        chosen = spread_subsample(self.points, CANDIDATES)
        points = self.points[chosen]
        own, joined = (self._curves(s)[chosen] for s in (step, step + 1))
        found: set[str] = set()
        for curve in np.unique(own[own >= 0]).tolist():
            here = own == curve
            rivals = points[(joined == joined[here][0]) & ~here & (own >= 0)]
            if not len(rivals):
                continue
            distance, nearest = map(np.asarray, cKDTree(rivals).query(points[here]))
            tip, other = points[here][np.argmin(distance)], rivals[nearest[np.argmin(distance)]]
            found.add(_meeting(points[here], rivals, (tip + other) / 2, NEAR * self.epsilon(step)))
        if "end to end" in found:
            return "end to end"
        return "beside" if found == {"beside"} else "unclear"

    def _curves(self, step: int) -> Ints:
        """The component of each point, -1 for those too small to be curves."""
        labels, sizes, length = self._components(step)
        return np.where(self._are_curves(sizes, length).take(labels), labels, -1)

    def _components(self, step: int) -> tuple[Ints, Ints, Floats]:
        """Label of each point, size of each component, and share of the length in it."""
        labels = components(self.points, self.epsilon(step))
        sizes = np.bincount(labels)
        witnessed = np.bincount(labels[self.witnesses.index], self.witnesses.length, len(sizes))
        return labels, sizes, witnessed / max(float(witnessed.sum()), 1e-300)

    def _are_curves(self, sizes: Ints, length: Floats) -> NDArray[np.bool_]:
        least = least_component_size(len(self.points))
        return np.asarray((sizes >= CURVE * least) | ((sizes >= least) & (length >= LONG)))

    def _census(self, step: int) -> tuple[int, float, float]:
        if step not in self.known:
            _, sizes, length = self._components(step)
            kept = sizes >= least_component_size(len(self.points))
            covered = float(sizes[kept].sum()) / len(self.points)
            told = float(length[kept].sum()) if len(self.witnesses.index) else 1.0
            self.known[step] = int(self._are_curves(sizes, length).sum()), covered, told
        return self.known[step]


def _meeting(
    points: Floats, others: Floats, middle: Floats, reach: float
) -> Literal["beside", "end to end", "unclear"]:
    """How two parts lie near the place where they meet, seen along the course of both."""
    parts = [part[np.linalg.norm(part - middle, axis=1) <= reach] for part in (points, others)]
    if min(len(part) for part in parts) < LEAST_SEEN:
        return "unclear"
    means = [part.mean(axis=0) for part in parts]
    within = np.concatenate([part - mean for part, mean in zip(parts, means, strict=True)])
    course = np.linalg.eigh(within.T @ within)[1][:, -1]
    apart = means[1] - means[0]
    return "beside" if abs(apart @ course) < ASIDE * np.linalg.norm(apart) else "end to end"
