"""The march (§4.2.2): from one local fit to the next along the curve, both ways.

``next = centre + d v + d^2 kappa / 2``, corrected by a fit there; directions keep
v_i . v_{i+1} > 0. Samples are owned with the direction of the pass, so that a crossing
may be passed twice but no stretch of a curve is followed twice.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from core.march.strip import (
    FIT_SIZE,
    HALF_WIDTH,
    N_AHEAD,
    N_ALL,
    N_OWNED,
    OFFSET,
    OWNER,
    OWNER_NODE,
    SIGMA,
    fit_strip,
    own_strip,
)

__all__ = ["DENSITY", "ENDED", "MET", "NODE_SIZE", "RADIUS", "march"]

# A node is a fit followed by its radius and its running density.
NODE_SIZE = FIT_SIZE + 2
RADIUS, DENSITY = FIT_SIZE, FIT_SIZE + 1

ENDED, MET = 0, 1  # how a walk stopped: no samples ahead; a stretch that was passed before

RADIUS_FACTOR = 2.2  # r = 2.2 sqrt(sigma / kappa): what is best for a quadratic, with margin
STEP_FACTOR = 0.5
MOST_TURN = 0.7  # radians from a strip's middle to its end
SHARPEST = 0.77  # least v_i . v_{i+1} of one step
MOST_USES = 30.0  # a sample is in about four strips a pass: more passes than crossings are a loop without end
RETRIES = np.array([1.0, 0.6, 0.36, 0.22, 0.13, 1.35, 1.9])


@njit(cache=True)
def is_empty(count, expected, confidence):  # type: ignore[no-untyped-def]
    """Whether ``count`` samples where ``expected`` were due is a gap, by the Poisson likelihood ratio."""
    if count >= 0.5 * expected:
        return False
    ratio = count * np.log(count / expected) if count > 0 else 0.0
    return expected - count + ratio > confidence


@njit(cache=True)
def _least_radius(sigma, density):  # type: ignore[no-untyped-def]
    """Shortest strip that still shows a direction: three sigma, or six samples either side."""
    return max(3.0 * sigma, 6.0 / density)


@njit(cache=True)
def _local_radius(node, bend, lengths):  # type: ignore[no-untyped-def]
    """Radius for the next step from the local noise and curvature."""
    if lengths[2] > 0.0:
        return lengths[2]
    wished = lengths[6] * RADIUS_FACTOR * np.sqrt(node[SIGMA] / max(bend, 1e-12))
    # A parabola follows a circle no farther than about 40 degrees.
    wished = min(wished, MOST_TURN / max(bend, 1e-12))
    wished = min(max(wished, 0.7 * node[RADIUS]), 1.3 * node[RADIUS])
    return min(max(wished, _least_radius(node[SIGMA], node[DENSITY])), lengths[4])


@njit(cache=True)
def _predict(node, d, at):  # type: ignore[no-untyped-def]
    """Where the curve should be after the distance ``d``."""
    norm = 0.0
    for k in range(3):
        at[k] = node[k] + d * node[3 + k] + 0.5 * d * d * node[6 + k]
        at[3 + k] = node[3 + k] + d * node[6 + k]
        at[6 + k] = node[6 + k]
        norm += at[3 + k] * at[3 + k]
    norm = 1.0 / np.sqrt(norm)
    for k in range(3):
        at[3 + k] *= norm


@njit(cache=True)
def _limit_curvature(fit, r):  # type: ignore[no-untyped-def]
    """A strip cannot show a bend sharper than its own length."""
    norm = np.sqrt(fit[6] ** 2 + fit[7] ** 2 + fit[8] ** 2)
    if norm > 1.0 / r:
        for k in range(6, 9):
            fit[k] /= norm * r


@njit(cache=True)
def _advance(grid, books, limits, lengths, node, bend, fit):  # type: ignore[no-untyped-def]
    """One step with its retries; returns how it went: ENDED, MET, or 2 for a new fit in ``fit``."""
    at = np.empty(9)
    sigma, density = node[SIGMA], node[DENSITY]
    wished = _local_radius(node, bend, lengths)
    floor = 0.95 * _least_radius(sigma, density)
    for factor in RETRIES:
        r = wished * factor
        if r < floor:
            continue
        half = max(HALF_WIDTH * sigma, 0.02 * r)
        d = lengths[3] if lengths[3] > 0.0 else STEP_FACTOR * r
        _predict(node, d, at)
        good = fit_strip(grid, books, limits, at, r, half, fit)
        if fit[N_AHEAD] > 0 and fit[N_OWNED] > 0.7 * fit[N_AHEAD] and fit[N_AHEAD] >= 3:
            return MET
        if not good or fit[N_AHEAD] < 2 or is_empty(fit[N_AHEAD], density * r, lengths[5]):
            continue
        drift = fit[OFFSET]
        _limit_curvature(fit, r)
        at[:9] = fit[:9]
        if not fit_strip(grid, books, limits, at, r, half, fit):
            continue
        _limit_curvature(fit, r)
        turn = fit[3] * node[3] + fit[4] * node[4] + fit[5] * node[5]
        ahead = (fit[0] - node[0]) * node[3] + (fit[1] - node[1]) * node[4] + (fit[2] - node[2]) * node[5]
        if (
            turn < SHARPEST
            or ahead < 0.3 * d
            or drift > 2.0 * sigma + 0.25 * r
            or fit[SIGMA] > 2.0 * sigma + 0.02 * r
        ):
            continue
        fit[RADIUS] = r
        return 2
    return ENDED


@njit(cache=True)
def march(grid, books, limits, lengths, start, first, nodes):  # type: ignore[no-untyped-def]
    """Walk from ``start`` until nothing is ahead or a passed stretch is met.

    Parameters
    ----------
    grid : Grid
    books : Books
    limits : (4,) array of int
        As for :func:`core.march.strip.fit_strip`.
    lengths : (7,) array
        Typical sigma, typical density, given radius (0: local), given step (0: local),
        largest radius, the log-likelihood ratio above which a stretch counts as empty, and a
        factor on the local radius.
    start : (NODE_SIZE,) array
        The first node.
    first : int
        The nodes are numbered ``first + 1, first + 2, ...`` in the samples' books.
    nodes : (K, NODE_SIZE) array
        Receives the nodes after ``start``.

    Returns
    -------
    count : int
        Number of nodes.
    status : int
        ENDED or MET.
    other, other_node : int
        The fragment and node that were met.
    """
    node = start.copy()
    fit = np.empty(NODE_SIZE)
    bend = np.sqrt(node[6] ** 2 + node[7] ** 2 + node[8] ** 2)
    own = limits.copy()
    for count in range(nodes.shape[0]):
        # Nodes within about two radii behind are the trail, not a stretch met again.
        own[1] = first + count - 5
        status = _advance(grid, books, own, lengths, node, bend, fit)
        if status != 2:
            return count, status, int(fit[OWNER]), int(fit[OWNER_NODE])
        r = fit[RADIUS]
        bow = np.sqrt(fit[6] ** 2 + fit[7] ** 2 + fit[8] ** 2)
        bend = max(0.7 * bend + 0.3 * bow, 0.1 * bow)
        seen = fit[N_ALL] / (2.0 * r)
        fit[DENSITY] = 0.75 * node[DENSITY] + 0.25 * seen
        fit[SIGMA] = min(max(0.8 * node[SIGMA] + 0.2 * fit[SIGMA], 0.4 * lengths[0]), 2.5 * lengths[0])
        nodes[count, :] = fit
        half = max(HALF_WIDTH * fit[SIGMA], 0.02 * r)
        worn = own_strip(grid, books, own[0], first + count + 1, fit, STEP_FACTOR * r, r, half)
        if worn > MOST_USES:
            return count + 1, ENDED, -1, 0
        node[:] = fit
    return nodes.shape[0], ENDED, -1, 0
