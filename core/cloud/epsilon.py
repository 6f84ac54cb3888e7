"""The hop epsilon of the partition, when the data must say it (§3.3).

An independent sample of a curve has gaps of about (ln N + c) / rho, rho the samples
per unit length; noise of standard deviation sigma widens it to a band whose sparse
flanks ask for a hop of their own when rho sigma is large. Both come from optimal balls
(§4.2.1) over a subsample. From there upward, the epsilon chosen is the first that
merges nothing over a wide range: there the curves have come together, and not yet
touched one another.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.balls import Balls, optimal_balls
from core.cloud.lattice import lattice_step
from core.cloud.plateau import Witnesses, clearest, least_component_size
from core.cloud.points import LARGEST, Normalisation, centred, distinct, inverse_power_of_two
from core.cloud.sampling import spread_subsample

__all__ = ["estimate_epsilon", "least_component_size"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Coordinates smaller than this, or larger than its inverse, are scaled before anything is squared.
TINY = 1e-100

CANDIDATES = 20_000
SEEDS = 240

# Balls whose points scatter more than this across their line, relative to along it, or whose
# centre is this far from the seed, are of outliers, or of a curve beside the seed.
LINEAR = 0.15
LARGEST_SHIFT = 0.5
LARGEST_OFFSET = 3.0
# Trusted balls must be at least so many, and at least this share of those found.
LEAST_BALLS = 5
LEAST_SHARE = 0.25
# Balls of a sparse part grow into denser ones beside it. The nearest NEARBY samples tell better there: they
# count where they line up, and lie at most 1 / DILUTED as dense as the ball.
NEARBY = 12
WIDE = 6.0  # in sigma: the least reach, for noise not to hide the course
CURVED = 0.006  # variance across, beside the noise's, as a share of the squared radius
NOISY = 2.0  # in sigma squared: the noise's
DILUTED = 2.0
# Two in a hundred of the trusted balls may yet be of outliers: when they are this much thinner than the rest.
STRAY_SHARE = 0.02
STRAY_DENSITY = 0.5

# The band of an independent sample with normal noise comes together, but for its sparse flanks, at
# FLANK sigma (rho sigma)^-DECAY: fitted to simulated bands with 5 < rho sigma < 500, in 2D and 3D.
FLANK = {2: 1.8, 3: 2.5}
DECAY = {2: 0.304, 3: 0.24}

FILLED = 0.5  # of the points distinct: fewer leave no gaps longer than a lattice's steps
DIAGONAL = 1.5  # steps: joins diagonal neighbours


def estimate_epsilon(points: Floats) -> float:
    """Estimate the longest hop between neighbours on one curve (§3.3).

    Parameters
    ----------
    points : (N, d) array, d = 2 or 3
        Finite, at least one row.

    Returns
    -------
    float
        Positive. The same, but for rounding, for the points rotated, translated or in another
        order, and scaled with them. Points that all coincide have no length to go by: four
        units in the last place of their largest coordinate.

    Notes
    -----
    O(N log N). Repeated points count once.
    """
    largest = float(np.abs(points).max())
    unit = inverse_power_of_two(largest) if not TINY < largest < 1 / TINY and largest > 0 else 1.0
    every = points * unit if unit != 1 else points
    points = distinct(every)
    if len(points) == 1:
        return 4 * math.ulp(largest)
    step = lattice_step(points) if len(points) < FILLED * len(every) else None
    return min(max(_estimate(points, step) / unit, math.ulp(largest)), LARGEST)


def _estimate(points: Floats, step: float | None) -> float:
    """Estimate epsilon for distinct points of moderate size, on a lattice of that step or on none."""
    chosen = spread_subsample(points, CANDIDATES)
    candidates, way = centred(points.take(chosen, axis=0))
    probes = _probe(candidates, len(points) / len(candidates))
    shortest = _hop_by_neighbours(candidates) if probes is None else _shortest_hop(points, probes, way)
    if step is not None:  # rounded, samples have no gaps shorter than the step, and few longer ones
        shortest = min(shortest, DIAGONAL * step / way.scale)
    witnesses = Witnesses.none() if probes is None else probes.witnesses(chosen)
    # A hop below the resolution of the coordinates joins nothing more than equal points.
    return clearest(points, max(shortest * way.scale, math.ulp(float(np.abs(points).max()))), witnesses)


@dataclass(frozen=True, slots=True, eq=False)
class _Probes:
    """Trusted places on curves: where they are, and what they say of density and noise."""

    seed: Ints
    centre: Floats
    direction: Floats
    density: Floats
    sigma: float

    @property
    def certain(self) -> NDArray[np.bool_]:
        """Which are not so much thinner than the rest that they may be of outliers."""
        usual = np.sort(self.density)[int(STRAY_SHARE * len(self.density))]
        return np.asarray(self.density >= STRAY_DENSITY * usual)

    def witnesses(self, candidates: Ints) -> Witnesses:
        """The places of the certain ones; ``candidates`` are the indices of the points asked."""
        return Witnesses(candidates[self.seed[self.certain]], 1 / self.density[self.certain])


def _probe(candidates: Floats, thinning: float) -> _Probes | None:
    """Optimal balls of seeds spread over the candidates; None when too few look like a curve's.

    ``thinning`` is the number of points for which a candidate stands.
    """
    dimension = candidates.shape[1]
    extent = math.sqrt(np.max(np.einsum("ij,ij->i", candidates, candidates)))
    # 2D points get z = 0.
    candidates = np.pad(candidates, ((0, 0), (0, 3 - dimension)))
    chosen = spread_subsample(candidates, SEEDS)
    seeds = candidates.take(chosen, axis=0)
    balls = optimal_balls(candidates, seeds, extent, flat=dimension == 2)
    trusted = _trusted(balls, seeds)
    if trusted.sum() < max(LEAST_BALLS, LEAST_SHARE * balls.found.sum()):
        trusted = balls.found
    if trusted.sum() < LEAST_BALLS:
        return None
    sigma = float(np.median(balls.sigma[trusted]))
    with np.errstate(invalid="ignore"):
        trusted &= balls.variance <= (LARGEST_OFFSET * sigma) ** 2 + CURVED * balls.radius**2
    near = _nearby(candidates, seeds, sigma)
    sparse = np.isfinite(near) & ~(near * DILUTED >= np.where(balls.found, balls.density, np.inf))
    density = np.where(sparse, near, balls.density)
    kept = np.flatnonzero(trusted | sparse)
    centre, direction = balls.centre[kept, :dimension], balls.direction[kept, :dimension]
    return _Probes(chosen[kept], centre, direction, density[kept] * thinning, sigma)


def _nearby(candidates: Floats, seeds: Floats, sigma: float) -> Floats:
    """Density of the nearest candidates where they line up through the seed; nan elsewhere."""
    count = min(NEARBY, len(candidates))
    tree = cKDTree(candidates, compact_nodes=False, balanced_tree=False)  # few queries: built fast
    farthest = np.asarray(tree.query(seeds, [count])[0])[:, 0]
    reach = np.maximum(farthest * (1 + 1e-9), WIDE * sigma)  # rounding must not leave the farthest out
    ordered = candidates.take(np.argsort(candidates[:, 0]), axis=0)
    first = np.searchsorted(ordered[:, 0], seeds[:, 0] - reach)
    last = np.searchsorted(ordered[:, 0], seeds[:, 0] + reach, side="right")
    inside, middle, moment = _moments(ordered, seeds, reach, first, last)
    values, ways = np.linalg.eigh(moment - np.einsum("ni,nj->nij", middle, middle))
    across = np.maximum(values[:, :-1].sum(axis=1), 0.0)
    along = np.einsum("ni,ni->n", middle, ways[:, :, -1])
    beside = np.einsum("ni,ni->n", middle, middle) - along**2
    lines_up = across < CURVED * reach**2 + NOISY * sigma**2
    lines_up &= beside <= LARGEST_OFFSET**2 * np.maximum(across, sigma**2)
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(np.where(lines_up & (reach > 0), inside / (2 * reach), np.nan))


@njit(cache=True)
def _moments(points, seeds, reach, first, last):  # type: ignore[no-untyped-def]
    """Count, mean (M, 3) and second moments (M, 3, 3), about each seed, of the points within its reach.

    Points are looked at from ``first`` to ``last`` only.
    """
    m = len(seeds)
    inside = np.zeros(m)
    middle = np.zeros((m, 3))
    moment = np.zeros((m, 3, 3))
    offset = np.empty(3)
    for s in range(m):
        limit = reach[s] * reach[s]
        for i in range(first[s], last[s]):
            square = 0.0
            for a in range(3):
                offset[a] = points[i, a] - seeds[s, a]
                square += offset[a] * offset[a]
            if square <= limit:
                inside[s] += 1.0
                for a in range(3):
                    middle[s, a] += offset[a]
                    for b in range(3):
                        moment[s, a, b] += offset[a] * offset[b]
        middle[s] /= max(inside[s], 1.0)
        moment[s] /= max(inside[s], 1.0)
    return inside, middle, moment


def _trusted(balls: Balls, seeds: Floats) -> NDArray[np.bool_]:
    """Which balls lie along a curve through their seeds."""
    shift = balls.centre - seeds
    along = np.einsum("ij,ij->i", shift, balls.direction)
    offset = np.linalg.norm(shift - along[:, None] * balls.direction, axis=1)
    with np.errstate(invalid="ignore"):
        linear = 3 * balls.variance < LINEAR * balls.radius**2
        central = np.abs(along) < LARGEST_SHIFT * balls.radius
        inside = offset <= LARGEST_OFFSET * np.sqrt(balls.variance)
    return np.asarray(balls.found & linear & central & inside)


def _shortest_hop(points: Floats, probes: _Probes, way: Normalisation) -> float:
    """Predict the least hop, in the units of the probes, that joins a sample of this density and noise."""
    density = np.sort(probes.density[probes.certain])
    thickness = probes.sigma / float(np.mean(1 / density))
    d = points.shape[1]
    flank = FLANK[d] * probes.sigma * thickness ** -DECAY[d] if thickness > 0 else 0.0
    scatter = _scatter_of_gaps(points, probes, way) if thickness < 1 else 1.0
    return max(_longest_gap(density, len(points), scatter), flank)


def _longest_gap(density: Floats, count: int, scatter: float) -> float:
    """Predict the longest gap: the hop that a single gap is expected to exceed.

    Each probe stands for an equal share of the gaps. One longer than e has the probability
    exp(-rho e) in an independent sample; ``scatter``, the squared coefficient of variation of
    the gaps, turns this into exp(-(rho e - 1 + scatter) / scatter), from independent (1) to regular (0).
    """
    low, high = 0.0, (math.log(count) + 1) * (1 + scatter) / float(density.min())
    for _ in range(60):
        hop = (low + high) / 2
        exponents = np.maximum((density * hop - 1 + scatter) / scatter, 0.0)
        if count * float(np.mean(np.exp(-exponents))) > 1:
            low = hop
        else:
            high = hop
    return high


def _scatter_of_gaps(points: Floats, probes: _Probes, way: Normalisation) -> float:
    """Squared coefficient of variation of the gaps along a curve: 1 when independent, 0 when regular."""
    spaced = np.unique(np.linspace(0, len(probes.density) - 1, 12).round().astype(np.int64))
    centres = way.restore(probes.centre[spaced])
    scatters = []
    for centre, direction, density in zip(
        centres, probes.direction[spaced], probes.density[spaced], strict=True
    ):
        reach = 20 / density * way.scale
        inside = np.ones(len(points), dtype=bool)
        for values, middle in zip(points.T, centre, strict=True):
            inside &= np.abs(values - middle) <= reach
        near = points[inside]
        gaps = np.diff(np.sort((near - centre) @ direction)) / reach
        gaps = gaps[gaps > 1e-9]
        if len(gaps) >= 8:
            scatters.append(float(np.var(gaps) / np.mean(gaps) ** 2))
    scatter = float(np.mean(scatters)) if scatters else 1.0
    # Independent samples are the rule: only a clear departure counts.
    return 1.0 if 0.6 < scatter < 1.5 else min(max(scatter, 0.02), 2.0)


def _hop_by_neighbours(candidates: Floats) -> float:
    """Hop to the neighbour number ln N, as nine points in ten have it: for what looks like no curve."""
    neighbour = min(least_component_size(len(candidates)), len(candidates) - 1)
    distances = cKDTree(candidates).query(candidates, k=[neighbour + 1])[0]
    return float(np.quantile(distances, 0.9))
