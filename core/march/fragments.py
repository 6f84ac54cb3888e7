"""Start and restart the march until every stretch of curve is passed (§4.2.2).

A fragment is one march, both ways from its start. Left-over samples start new ones as
long as they look like curves themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.cloud.balls import Balls, optimal_balls
from core.cloud.grid import Grid, build_grid
from core.cloud.line import fit_line
from core.cloud.sampling import Scale, spread_subsample
from core.march.strip import HALF_WIDTH, N_ALL, SIGMA, Books, fit_strip, own_strip, passed_share
from core.march.walk import DENSITY, MET, NODE_SIZE, RADIUS, march
from core.refine.polyline import Polyline

__all__ = ["Fragment", "Pace", "march_all"]

MOST_NODES = 20000
MOST_RADIUS = 0.25  # of the extent
BACKWARD = 1 << 30  # numbers of the nodes marched against the start's direction
ROUNDS = 12
RESTARTS = 160
MOST_PASSED = 0.4  # share of a start's samples that marches have passed before
LEAST_DENSITY = 0.15  # of the typical density: thinner samples make no curve of their own


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """How the march is to go: scale of the data, and what an expert has fixed (0: free)."""

    scale: Scale
    extent: float
    flat: bool
    radius_scale: float = 1.0
    radius: float = 0.0
    step: float = 0.0
    max_uses: int = 0
    estimator: Literal["pca", "least_squares"] = "pca"
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Fragment:
    """One march.

    Attributes
    ----------
    nodes : (K, NODE_SIZE) array
        Fits in order along the curve, all directions pointing forward.
    closed : bool
        Whether the march came back to its start.
    """

    nodes: NDArray[np.float64]
    closed: bool

    @property
    def centres(self) -> NDArray[np.float64]:
        """(K, 3) the vertices of the march."""
        return self.nodes[:, :3]

    @property
    def polyline(self) -> Polyline:
        """The march as a PL curve."""
        return Polyline(self.centres, self.closed)

    @property
    def length(self) -> float:
        """Length of the marched polyline, without a closing edge."""
        return float(np.linalg.norm(np.diff(self.centres, axis=0), axis=1).sum())


def march_all(points: NDArray[np.float64], pace: Pace) -> tuple[list[Fragment], NDArray[np.bool_]]:
    """March along every curve of a component.

    Parameters
    ----------
    points : (N, 3) array
        Centred points; z = 0 where the component is flat.
    pace : Pace

    Returns
    -------
    fragments : list of Fragment
    passed : (N,) array of bool
        Which samples some fragment has passed.
    """
    grid = build_grid(points, max(pace.scale.radius / 3.0, HALF_WIDTH * pace.scale.sigma))
    books = Books.empty(len(points))
    fragments: list[Fragment] = []
    _march_seeds(grid, books, pace, pace.scale.balls, fragments)
    for _ in range(ROUNDS):
        before = len(fragments)
        balls = _left_over(grid, books, pace)
        if balls is None:
            break
        _march_seeds(grid, books, pace, balls, fragments)
        if len(fragments) == before:
            break
    passed = np.empty(len(points), np.bool_)
    passed[grid.order] = books.owner >= 0
    return fragments, passed


def _left_over(grid: Grid, books: Books, pace: Pace) -> Balls | None:
    """Balls over the samples that no march has passed, where they are as dense as a curve is."""
    rest = grid.points[books.owner < 0]
    if len(rest) < 10:
        return None
    few = rest[spread_subsample(rest, 20 * RESTARTS)]
    seeds = few[spread_subsample(few, RESTARTS)]
    balls = optimal_balls(few, seeds, 2.0 * pace.extent, pace.flat)
    thin = balls.density * (len(rest) / len(few)) < LEAST_DENSITY * pace.scale.density
    balls.radius[thin] = np.nan
    return balls


def _march_seeds(grid: Grid, books: Books, pace: Pace, balls: Balls, fragments: list[Fragment]) -> None:
    """March from the clearest seeds first, until none lies on a stretch not yet passed."""
    found = np.flatnonzero(balls.found)
    sigma = pace.scale.sigma
    unusual = np.abs(np.log((balls.sigma[found] + 1e-300) / (sigma + 1e-300)))
    linear = np.sqrt(balls.variance[found]) / balls.radius[found]
    for s in found[np.argsort(linear + 0.2 * unusual)]:
        start = _start(grid, books, pace, balls, int(s), len(fragments))
        if start is None:
            continue
        fragment = _both_ways(grid, books, pace, start, len(fragments))
        if fragment is not None:
            fragments.append(fragment)
        else:  # a false start leaves no trace
            books.owner[books.owner == len(fragments)] = -1


def _start(grid: Grid, books: Books, pace: Pace, balls: Balls, s: int, me: int) -> NDArray[np.float64] | None:
    """The first node: a ball's line, turned into a strip's quadratic; None where passed before."""
    sigma = max(pace.scale.sigma, 0.25 * float(balls.sigma[s]))
    radius = pace.radius or max(min(float(balls.radius[s]), MOST_RADIUS * pace.extent), 3.0 * sigma)
    node = np.zeros(NODE_SIZE)
    at = np.concatenate([balls.centre[s], balls.direction[s], np.zeros(3)])
    limits = np.array([me, 0, pace.max_uses, 1 if pace.flat else 2])
    # A short strip tells most passed stretches at a fraction of the cost.
    if passed_share(grid, books, at, 0.2 * radius, sigma) > 0.8:
        return None
    at[3:6] = _direction(grid, pace, balls, s)
    for widen in (2.0, 1.3, 1.0):
        half = max(HALF_WIDTH * sigma * widen, 0.05 * radius)
        if passed_share(grid, books, at, radius, half) > MOST_PASSED:
            return None
        if not fit_strip(grid, books, limits, at, radius, half, node):
            return None
        at = node[:9].copy()
    node[RADIUS] = radius
    node[SIGMA] = min(max(node[SIGMA], 0.5 * sigma), 1.5 * sigma)
    node[DENSITY] = node[N_ALL] / (2.0 * radius)
    if node[DENSITY] < LEAST_DENSITY * pace.scale.density:
        return None
    return node


def _direction(grid: Grid, pace: Pace, balls: Balls, s: int) -> NDArray[np.float64]:
    """Direction of the first ball's line, pointing away from the centre of gravity.

    An eigenvector's sign is arbitrary; this one turns with the point set.
    """
    offset = grid.points - balls.seed[s]
    inside = np.einsum("ij,ij->i", offset, offset) <= balls.radius[s] ** 2
    direction = fit_line(grid.points[inside], pace.estimator, np.random.default_rng(pace.seed))[1]
    return np.asarray(-direction if direction @ balls.centre[s] < 0.0 else direction)


def _both_ways(grid: Grid, books: Books, pace: Pace, start: NDArray[np.float64], me: int) -> Fragment | None:
    """March forward, and backward unless the curve closed."""
    radius, half = start[RADIUS], max(HALF_WIDTH * start[SIGMA], 0.02 * start[RADIUS])
    own_strip(grid, books, me, 0, start, 0.5 * radius, radius, half)
    ahead, status, other, other_node = _one_way(grid, books, pace, start, me, 0)
    closed = status == MET and other == me and other_node <= 2 and _comes_round(ahead, start)
    behind = ahead[:0]
    if not closed:
        back = start.copy()
        back[3:6] *= -1.0
        behind, status, other, other_node = _one_way(grid, books, pace, back, me, BACKWARD)
        closed = status == MET and other == me and len(ahead) - 3 <= other_node <= len(ahead)
        closed = closed and _comes_round(behind, ahead[-1] if len(ahead) else start)
    behind = behind[::-1].copy()
    behind[:, 3:6] *= -1.0
    nodes = np.concatenate([behind, start[None], ahead])
    return Fragment(nodes, closed) if len(nodes) >= 3 else None


def _comes_round(nodes: NDArray[np.float64], goal: NDArray[np.float64]) -> bool:
    """Whether a walk of several steps ends within two radii of the node that it met."""
    if len(nodes) < 5:
        return False
    return bool(np.linalg.norm(nodes[-1, :3] - goal[:3]) < 2.0 * max(nodes[-1, RADIUS], goal[RADIUS]))


def _one_way(
    grid: Grid, books: Books, pace: Pace, start: NDArray[np.float64], me: int, first: int
) -> tuple[NDArray[np.float64], int, int, int]:
    scale = pace.scale
    nodes = np.empty((MOST_NODES, NODE_SIZE))
    limits = np.array([me, 0, pace.max_uses, 1 if pace.flat else 2])
    empty = np.log(max(len(grid.points), 2)) + 3.0
    lengths = np.array(
        [
            scale.sigma,
            scale.density,
            pace.radius,
            pace.step,
            MOST_RADIUS * pace.extent,
            empty,
            pace.radius_scale,
        ]
    )
    count, status, other, other_node = march(grid, books, limits, lengths, start, first, nodes)
    return nodes[:count].copy(), int(status), int(other), int(other_node)
