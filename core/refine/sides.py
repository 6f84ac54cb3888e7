"""Sides of corners: parabolic strokes that meet in corners, of the greatest likelihood of the samples around.

A sample comes from some place on a stroke, displaced by isotropic noise; its density is the integral of a
Gaussian along the strokes. Distances to the nearest stroke would not do: at an acute corner the noise of one
side reaches beyond the other one, and would push both apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.refine.polyline import Polyline

__all__ = [
    "STEP",
    "Nodes",
    "Strokes",
    "evidence",
    "fit_strokes",
    "line_nodes",
    "straight_enough",
    "strokes_along",
]

Floats = NDArray[np.float64]

STEP = 0.4  # in sigma: between the nodes that stand for the strokes
LEAST_NODES = 12  # a stroke
REACH = 4.5  # in sigma: what lies farther adds nothing
BACKGROUND = 0.01  # in sigma: density of outliers, as a length of curve at no distance
SLIDE = 0.02  # stiffness against sliding along the strokes, in units of that across them
STIFF = 100.0  # the same for what is held
STRAIGHT = 3.0  # standard errors below which a bend is none
ITERATIONS = 30
SETTLED = 0.03  # in sigma: steps below which a fit has settled
GAIN = 0.02  # nats below which the next step is not worth it
ROUNDING = 1e-10  # nats a sample: such a loss is none, and must not decide
BLOCK = 8  # nodes
BEND = np.array([-0.5, 1.0, -0.5])  # of a stroke, from its knots and control point


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Places (M, 3) along a course, and the length (M,) that each stands for."""

    place: Floats
    weight: Floats

    @classmethod
    def none(cls) -> Nodes:
        """No course at all."""
        return cls(np.zeros((0, 3)), np.zeros(0))

    def joined(self, other: Nodes) -> Nodes:
        """Both together."""
        place = np.concatenate([self.place, other.place])
        return Nodes(place, np.concatenate([self.weight, other.weight]))

    def only(self, keep: NDArray[np.bool_]) -> Nodes:
        """Some of them."""
        return Nodes(self.place[keep], self.weight[keep])


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """Parabolas, each from a knot over a control point to the next knot.

    Attributes
    ----------
    control : (K, 3) array
        Knots at even places, control points between them; a ring does not repeat its first knot.
    basis, slope : (M, K) arrays
        Nodes are ``basis @ control``; each stands for the stretch ``slope @ control``.
    fraction : (M,) array
        Of each node: number of its stroke, and how far along it.
    ring : bool
    bent : (S,) array of bool
        Which strokes may bend; the others are straight.
    covariance : (K, 3, K, 3) array
        Of the control points; zero before a fit.
    """

    control: Floats
    basis: Floats
    slope: Floats
    fraction: Floats
    ring: bool
    bent: NDArray[np.bool_]
    covariance: Floats

    @classmethod
    def of(cls, control: Floats, counts: list[int], ring: bool) -> Strokes:
        """Strokes over given control points, with so many nodes each."""
        size = len(control)
        basis, slope = np.zeros((sum(counts), size)), np.zeros((sum(counts), size))
        first = 0
        for k, count in enumerate(counts):
            t = (np.arange(count) + 0.5) / count
            for column, b, d in zip(_rows(k, size), _bernstein(t).T, _derived(t).T, strict=True):
                basis[first : first + count, column] += b
                slope[first : first + count, column] += d / count
            first += count
        fraction = np.concatenate([k + (np.arange(n) + 0.5) / n for k, n in enumerate(counts)])
        bent = np.ones(len(counts), np.bool_)
        return cls(control, basis, slope, fraction, ring, bent, np.zeros((size, 3, size, 3)))

    @property
    def count(self) -> int:
        """Number of strokes."""
        return len(self.control) // 2

    def rows(self, k: int) -> list[int]:
        """Rows of stroke ``k`` among the control points."""
        return _rows(k, len(self.control))

    def at(self, k: int, t: Floats) -> Floats:
        """Places (T, 3) at the fractions ``t`` of stroke ``k``."""
        return np.asarray(_bernstein(t) @ self.control[self.rows(k)])

    def length(self, k: int) -> float:
        """Length of stroke ``k``."""
        x = self.at(k, np.linspace(0.0, 1.0, 17))
        return float(np.sum(np.linalg.norm(np.diff(x, axis=0), axis=1)))

    def error_at(self, k: int, t: Floats, flat: bool) -> Floats:
        """Standard errors (T,) across stroke ``k`` at the fractions ``t``, per normal direction."""
        rows, b = self.rows(k), _bernstein(t)
        covariance = np.einsum("tk,kilj,tl->tij", b, self.covariance[rows][:, :, rows], b)
        d = _derived(t) @ self.control[rows]
        d /= np.maximum(np.linalg.norm(d, axis=1), 1e-300)[:, None]
        along = np.einsum("ti,tij,tj->t", d, covariance, d)
        axes = 2 if flat else 3
        total = np.einsum("tii->t", covariance[:, :axes, :axes])
        return np.asarray(np.sqrt(np.maximum(total - along, 0.0) / (axes - 1)))

    def nodes(self) -> Nodes:
        """Nodes along all strokes."""
        return Nodes(self.basis @ self.control, np.linalg.norm(self.slope @ self.control, axis=1))

    def rounded(self, before: float, after: float, step: float) -> Strokes:
        """Two strokes with an arc in place of the corner between them.

        Parameters
        ----------
        before, after : float
            Fractions of the first and of the second stroke between which the arc runs.
        step : float
            Between nodes.
        """
        size = len(self.control)
        first, last = np.zeros((3, size)), np.zeros((3, size))
        first[[0, 1, 2], [0, 1, 2]] = last[[0, 1, 2], [2, 3, 4]] = 1.0
        arc = np.stack(
            [_bernstein(np.array([before]))[0] @ first, first[2], _bernstein(np.array([after]))[0] @ last]
        )
        parts = []
        for k, (rows, low, high) in enumerate(((first, 0.0, before), (arc, 0.0, 1.0), (last, after, 1.0))):
            span = float(np.sum(np.linalg.norm(np.diff(rows @ self.control, axis=0), axis=1))) * (high - low)
            count = max(_steps(span, step), LEAST_NODES)
            t = low + (high - low) * (np.arange(count) + 0.5) / count
            slope = _derived(t) @ rows * ((high - low) / count)
            parts.append((_bernstein(t) @ rows, slope, np.full(count, 0.5 * k)))
        basis, slope, fraction = (np.concatenate(column) for column in zip(*parts, strict=True))
        return replace(self, basis=basis, slope=slope, fraction=fraction)


def _rows(k: int, size: int) -> list[int]:
    return [2 * k, 2 * k + 1, (2 * k + 2) % size]


def _bernstein(t: Floats) -> Floats:
    return np.stack([(1.0 - t) ** 2, 2.0 * t * (1.0 - t), t * t], axis=1)


def _derived(t: Floats) -> Floats:
    return np.stack([2.0 * t - 2.0, 2.0 - 4.0 * t, 2.0 * t], axis=1)


def _steps(length: float, step: float) -> int:
    """How many steps cover a length; rounding must not add one."""
    return int(np.ceil(length / step - 1e-6))


def line_nodes(line: Polyline, low: float, high: float, sigma: float) -> Nodes:
    """Nodes of a polyline between two stations."""
    count = max(_steps(high - low, STEP * sigma), 1)
    station = low + (np.arange(count) + 0.5) * ((high - low) / count)
    if not line.closed:
        station = station[(station >= 0.0) & (station <= line.length)]
    return Nodes(line.at(station), np.full(len(station), (high - low) / count))


def strokes_along(line: Polyline, knots: Floats, ring: bool, sigma: float) -> Strokes:
    """Straight strokes between places of a polyline; of a ring the last knot is the first.

    Parameters
    ----------
    line : Polyline
    knots : (S + 1,) array
        Stations, ascending; they may run past the seam of a closed line.
    ring : bool
    sigma : float
    """
    size = 2 * len(knots) - 2 + (0 if ring else 1)
    control = np.empty((size, 3))
    places = line.at(knots)
    control[::2] = places[: (size + 1) // 2]
    control[1::2] = 0.5 * (places[1:] + places[:-1])
    counts = [max(_steps(float(gap), STEP * sigma), LEAST_NODES) for gap in np.diff(knots)]
    return Strokes.of(control, counts, ring)


def evidence(samples: Floats, nodes: Nodes, sigma: float) -> float:
    """Logarithm of the likelihood of samples from a course, but for what all courses share."""
    return _level(_blurred(samples, nodes.place, nodes.weight, sigma)[0], nodes)


def _level(level: Floats, nodes: Nodes) -> float:
    return float(level.sum()) - len(level) * float(np.log(nodes.weight.sum()))


def fit_strokes(
    samples: Floats, strokes: Strokes, beyond: Nodes, sigma: float, fixed: tuple[bool, bool] = (False, False)
) -> tuple[Strokes, float]:
    """Move strokes to where the samples are most likely.

    Parameters
    ----------
    samples : (N, 3) array
    strokes : Strokes
        Where to start.
    beyond : Nodes
        The course beyond the strokes, which stays.
    sigma : float
    fixed : tuple of bool
        Whether the first and the last knot stay; otherwise they do not slide along their strokes.

    Returns
    -------
    Strokes
    float
        Logarithm of the likelihood, but for what all courses share.
    """
    now = _straightened(strokes)
    size = len(now.control)
    held = _held(now, fixed)
    level, mass, pull = _judged(samples, now, beyond, sigma)
    covariance = np.zeros((3 * size, 3 * size))
    for _ in range(ITERATIONS):
        gradient, hessian = _normal(now.basis, now.slope, now.control, mass, pull)
        total = max(float(mass.sum()), 1.0)
        hessian += held * total
        hessian[np.diag_indices(3 * size)] += 1e-6 * total
        covariance = np.linalg.inv(hessian)
        step = (covariance @ gradient.ravel()).reshape(size, 3)
        gain = -np.inf
        for _ in range(5):
            trial = replace(now, control=now.control + step)
            reached = _judged(samples, trial, beyond, sigma)
            gain = reached[0] - level
            if gain > -ROUNDING * len(samples):
                now, (level, mass, pull) = trial, reached
                break
            step *= 0.4
        if gain < GAIN or float(np.linalg.norm(step, axis=1).max()) < SETTLED * sigma:
            break
    return replace(now, covariance=sigma**2 * covariance.reshape(size, 3, size, 3)), level


def straight_enough(strokes: Strokes) -> Strokes:
    """Strokes of which those that the error of their bend explains may bend no more."""
    bent = [bool(strokes.bent[k]) and _is_bent(strokes, k) for k in range(strokes.count)]
    return _straightened(replace(strokes, bent=np.array(bent)))


def _is_bent(strokes: Strokes, k: int) -> bool:
    """Whether a stroke is bent beyond the error of its bend."""
    rows = strokes.rows(k)
    bend = BEND @ strokes.control[rows]
    square = float(bend @ bend)
    if square <= 0.0:
        return False
    covariance = np.einsum("k,kilj,l->ij", BEND, strokes.covariance[rows][:, :, rows], BEND)
    return square**2 > STRAIGHT**2 * float(bend @ covariance @ bend)


def _straightened(strokes: Strokes) -> Strokes:
    control = strokes.control.copy()
    for k in np.flatnonzero(~strokes.bent):
        a, m, b = strokes.rows(int(k))
        control[m] = 0.5 * (control[a] + control[b])
    return replace(strokes, control=control)


def _held(strokes: Strokes, fixed: tuple[bool, bool]) -> Floats:
    """Stiffness (3K, 3K): control points stay abreast of the middle of their knots, ends in their place."""
    size = len(strokes.control)
    out = np.zeros((size, 3, size, 3))
    for k in range(strokes.count):
        rows = strokes.rows(k)
        chord = strokes.control[rows[2]] - strokes.control[rows[0]]
        along = np.outer(chord, chord) / max(float(chord @ chord), 1e-300)
        tie = along if strokes.bent[k] else np.eye(3)
        out[np.ix_(rows, range(3), rows, range(3))] += STIFF * np.einsum("k,ij,l->kilj", BEND, tie, BEND)
        for at_end, end, stays in ((k == 0, rows[0], fixed[0]), (k == strokes.count - 1, rows[2], fixed[1])):
            if at_end and not strokes.ring:
                out[end, :, end, :] += STIFF * (np.eye(3) if stays else along)
    return out.reshape(3 * size, 3 * size)


def _judged(samples: Floats, strokes: Strokes, beyond: Nodes, sigma: float) -> tuple[float, Floats, Floats]:
    """Log-likelihood, and of each node of the strokes the mass of its samples and their sum."""
    nodes = strokes.nodes().joined(beyond)
    level, mass, pull = _blurred(samples, nodes.place, nodes.weight, sigma)
    own = len(strokes.basis)
    return _level(level, nodes), mass[:own], pull[:own]


@njit(cache=True)
def _blurred(samples, place, weight, sigma):  # type: ignore[no-untyped-def]
    """Log-densities of the samples, and each node's share of them; far nodes are passed over in blocks."""
    n, count = samples.shape[0], place.shape[0]
    level, mass, pull = np.empty(n), np.zeros(count), np.zeros((count, 3))
    blocks = (count + BLOCK - 1) // BLOCK
    middle, reach = np.zeros((blocks, 3)), np.zeros(blocks)
    for b in range(blocks):
        first, last = b * BLOCK, min((b + 1) * BLOCK, count)
        for m in range(first, last):
            for c in range(3):
                middle[b, c] += place[m, c] / (last - first)
        for m in range(first, last):
            square = 0.0
            for c in range(3):
                square += (place[m, c] - middle[b, c]) ** 2
            reach[b] = max(reach[b], square)
        reach[b] = (np.sqrt(reach[b]) + REACH * sigma) ** 2
    share = np.empty(count)
    near = np.empty(count, np.int64)
    far, half = (REACH * sigma) ** 2, 0.5 / sigma**2
    for i in range(n):
        x, y, z = samples[i, 0], samples[i, 1], samples[i, 2]
        total, used = BACKGROUND * sigma, 0
        for b in range(blocks):
            dx, dy, dz = x - middle[b, 0], y - middle[b, 1], z - middle[b, 2]
            if dx * dx + dy * dy + dz * dz > reach[b]:
                continue
            for m in range(b * BLOCK, min((b + 1) * BLOCK, count)):
                dx, dy, dz = x - place[m, 0], y - place[m, 1], z - place[m, 2]
                square = dx * dx + dy * dy + dz * dz
                if square < far:
                    near[used] = m
                    share[used] = weight[m] * np.exp(-half * square)
                    total += share[used]
                    used += 1
        level[i] = np.log(total)
        for k in range(used):
            m, r = near[k], share[k] / total
            mass[m] += r
            pull[m, 0] += r * x
            pull[m, 1] += r * y
            pull[m, 2] += r * z
    return level, mass, pull


@njit(cache=True)
def _normal(basis, slope, control, mass, pull):  # type: ignore[no-untyped-def]
    """Gradient (K, 3) and stiffness (3K, 3K) of the sum of squares, without the noise's variance."""
    count, size = basis.shape
    gradient, hessian = np.zeros((size, 3)), np.zeros((3 * size, 3 * size))
    rows = np.empty(size, np.int64)
    for m in range(count):
        used = 0
        place, along = np.zeros(3), np.zeros(3)
        for k in range(size):
            if basis[m, k] != 0.0 or slope[m, k] != 0.0:
                rows[used] = k
                used += 1
                for c in range(3):
                    place[c] += basis[m, k] * control[k, c]
                    along[c] += slope[m, k] * control[k, c]
        square = along[0] ** 2 + along[1] ** 2 + along[2] ** 2
        for a in range(used):
            p = rows[a]
            for c in range(3):
                gradient[p, c] += basis[m, p] * (pull[m, c] - mass[m] * place[c])
            for b in range(used):
                q = rows[b]
                w = mass[m] * basis[m, p] * basis[m, q]
                for c in range(3):
                    for d in range(3):
                        across = (1.0 if c == d else 0.0) - (1.0 - SLIDE) * along[c] * along[d] / max(
                            square, 1e-300
                        )
                        hessian[3 * p + c, 3 * q + d] += w * across
    return gradient, hessian
