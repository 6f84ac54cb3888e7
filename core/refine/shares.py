"""Which samples belong to which curve, and how much of each where two branches are close.

Near a crossing or in a narrow gap a sample may come from either branch: its nearest one takes it
with the probability that it came from there, and so does each other one. Samples given wholly to the
nearest branch would push branches apart and make the noise look smaller than it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from core.refine.branches import Branches
from core.refine.further_feet import Further, further_feet
from core.refine.local_noise import LocalNoise
from core.refine.noise import mass
from core.refine.project import Feet

__all__ = ["Share", "groups_of", "noise_at", "shares_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

AROUND = 25.0  # in sigma: density is that of so much course either side,
LEAST_AROUND = 30.0  # but of no fewer samples either side
ROUNDS = 2  # of dividing the samples and counting them


@dataclass(frozen=True, slots=True, eq=False)
class Share:
    """The samples of one curve, in arrays of length N; one with two feet on the curve is there twice.

    Attributes
    ----------
    index : (N,) array of int
        Which samples.
    station, distance : (N,) array
        Of their feet on the curve.
    weight : (N,) array or None
        How much of each sample is this curve's; None where all of them are.
    """

    index: Ints
    station: Floats
    distance: Floats
    weight: Floats | None

    @property
    def mass(self) -> float:
        """Number of samples, each as far as it is this curve's."""
        return mass(len(self.index), self.weight)

    def only(self, keep: NDArray[np.bool_]) -> Share:
        """Return the samples that a mask keeps."""
        weight = None if self.weight is None else self.weight[keep]
        return Share(self.index[keep], self.station[keep], self.distance[keep], weight)


def shares_of(
    points: Floats,
    feet: Feet,
    sigmas: Floats,
    cut: float,
    branches: Branches | None,
    ends: Floats,
    normals: int,
    local: Sequence[LocalNoise] | None = None,
) -> list[Share]:
    """Give every curve the samples within ``cut`` of its sigmas.

    Parameters
    ----------
    points : (N, 3) array
    feet : Feet
        Of the points, on all curves.
    sigmas : (C,) array
        Noise of each curve.
    cut : float
        In sigma.
    branches : Branches or None
        Where samples may have several feet.
    ends : (C, 2) array
        Stations where open curves begin and end: their polylines may be longer.
    normals : int
        Number of normal directions.
    local : sequence of LocalNoise, optional
        Noise along each curve, where it is not the same everywhere.
    """
    near = feet.distance < cut * noise_at(feet.curve, feet.station, sigmas, local)
    if branches is None:
        groups = groups_of(feet.curve, near, len(sigmas))
        return [Share(mine, feet.station[mine], feet.distance[mine], None) for mine in groups]
    further, counts = further_feet(points, feet.curve, feet.station, feet.distance, branches)
    first, more = _responsibilities(feet, further, counts, branches, ends, normals, local)
    weight = np.ones(len(points))
    weight[further.sample] = first
    near[further.sample] = first > 0.0
    groups = groups_of(feet.curve, near, len(sigmas))
    return [_with_further(mine, feet, weight, further, more, k) for k, mine in enumerate(groups)]


def _responsibilities(
    feet: Feet,
    further: Further,
    counts: Floats,
    branches: Branches,
    ends: Floats,
    normals: int,
    local: Sequence[LocalNoise] | None,
) -> tuple[Floats, Floats]:
    """Weights of the first and of the further feet; those of one sample sum to one."""
    i = further.sample
    own = _likelihood(feet.curve[i], feet.station[i], feet.distance[i], branches, ends, normals, local)
    other = further.branch * _likelihood(
        further.curve, further.station, further.distance, branches, ends, normals, local
    )
    first, more = np.ones(len(i)), np.zeros(len(other))
    for _ in range(ROUNDS):
        density = _density(_counted(counts, further, first, more), branches, ends)
        first, more = own * density[further.node], other * density[further.at]
        total = np.maximum(first + np.bincount(further.row, more, len(i)), 1e-300)
        first, more = first / total, more / total[further.row]
    return first, more


def _counted(counts: Floats, further: Further, first: Floats, more: Floats) -> Floats:
    """Samples next to each node, divided samples among all of theirs."""
    size = len(counts)
    taken, given = np.bincount(further.node, 1.0 - first, size), np.bincount(further.at, more, size)
    return np.asarray(counts - taken + given)


def _likelihood(
    curve: Ints,
    station: Floats,
    distance: Floats,
    branches: Branches,
    ends: Floats,
    normals: int,
    local: Sequence[LocalNoise] | None,
) -> Floats:
    """Of a sample at a distance from its foot; where an open curve ends, noise blurs the end."""
    sigma = noise_at(curve, station, branches.sigmas, local)
    beyond = np.minimum(station - ends[curve, 0], ends[curve, 1] - station) / sigma
    out = np.exp(-0.5 * (distance / sigma) ** 2) / sigma**normals * ndtr(beyond)
    return np.where(distance < branches.cut * sigma, out, 0.0)


def noise_at(curve: Ints, station: Floats, sigmas: Floats, local: Sequence[LocalNoise] | None) -> Floats:
    """Noise where feet are; zero where there is no curve.

    Parameters
    ----------
    curve : (N,) array of int
        Nearest curve; -1 for none.
    station : (N,) array
    sigmas : (C,) array
        Noise of each curve.
    local : sequence of LocalNoise, optional
        Noise along each curve, where it is not the same everywhere.
    """
    out = np.append(np.maximum(sigmas, 1e-12), 0.0)[curve]
    for k, noise in enumerate(local or ()):
        if noise.varies:
            here = curve == k
            out[here] = np.maximum(noise.at(station[here]), 1e-12)
    return np.asarray(out)


def _density(counts: Floats, branches: Branches, ends: Floats) -> Floats:
    """Samples per unit length about each node, averaged along its branch between the branch's ends."""
    out = np.empty(len(counts))
    spacing = float(np.sum(branches.step * np.diff(branches.first_node))) / max(float(counts.sum()), 1.0)
    for k, (low, high) in enumerate(zip(branches.first_node[:-1], branches.first_node[1:], strict=True)):
        step, closed = branches.step[k], bool(branches.closed[k])
        station = np.arange(high - low) * step
        inside = ((station >= ends[k, 0]) & (station <= ends[k, 1])).astype(np.float64)
        width = max(AROUND * branches.sigmas[k], LEAST_AROUND * spacing) / step
        over = _blurred(inside, width, closed)
        out[low:high] = _blurred(counts[low:high] * inside, width, closed) / np.maximum(over, 1e-12) / step
    return np.maximum(out, 1e-3 / spacing)


def _blurred(values: Floats, width: float, closed: bool) -> Floats:
    """Sums under a parabola of half-width ``width``, no wider than the whole."""
    size = len(values)
    reach = int(min(width, size // 2 - 1 if closed else size - 1))
    window = 1.0 - (np.arange(-reach, reach + 1) / (width + 1.0)) ** 2
    around = (
        np.take(values, np.arange(-reach, size + reach), mode="wrap") if closed else np.pad(values, reach)
    )
    return np.convolve(around, window, "valid")


def _with_further(mine: Ints, feet: Feet, weight: Floats, further: Further, more: Floats, k: int) -> Share:
    """A curve's nearest samples, and those that have a further foot on it."""
    those = np.flatnonzero((further.curve == k) & (more > 0.0))
    if not len(those) and np.all(weight[mine] == 1.0):
        return Share(mine, feet.station[mine], feet.distance[mine], None)
    return Share(
        np.concatenate([mine, further.sample[further.row[those]]]),
        _joined(feet.station, mine, further.station[those]),
        _joined(feet.distance, mine, further.distance[those]),
        _joined(weight, mine, more[those]),
    )


def _joined(values: Floats, mine: Ints, more: Floats) -> Floats:
    """Some of the values and some more, without a copy in between."""
    out = np.empty(len(mine) + len(more))
    np.take(values, mine, out=out[: len(mine)], mode="clip")
    out[len(mine) :] = more
    return out


def groups_of(curve: Ints, near: NDArray[np.bool_], count: int) -> list[Ints]:
    """Return the indices of the near samples of each curve."""
    if count == 1:
        return [np.flatnonzero(near)]
    order = np.argsort(curve, kind="stable")
    order = order[near[order]]
    bounds = np.searchsorted(curve[order], np.arange(count + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(count)]
