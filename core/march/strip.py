"""The local fit of the march: a quadratic in an oriented strip (§4.2.1, improved).

A plain ball's centroid is drawn inward by curvature and sideways by neighbouring
branches. A strip that follows the predicted curve, half-length r and half-width three
sigma, with tapered weights and a quadratic fit has neither fault, and passes straight
through crossings.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.cloud.grid import cell_range

__all__ = ["FIT_SIZE", "HALF_WIDTH", "Books", "fit_strip", "gather_strip", "own_strip", "passed_share"]

HALF_WIDTH = 3.0  # half-width of the strip, in sigma
LEAST_SAMPLES = 6
ALIGNED = 0.85  # |cosine| above which two passes over a sample count as the same pass
# Variance of a Gaussian under the weight 1 - (o / 3 sigma)^2, summed over one or two normal directions.
WEIGHTED_VARIANCE_FLAT = 0.75
WEIGHTED_VARIANCE_SPACE = 10.0 / 7.0

# Layout of a fit: centre (0-2), direction (3-5), curvature vector (6-8), then scalars.
FIT_SIZE = 16
N_ALL, N_AHEAD, N_OWNED, SIGMA, OWNER, OWNER_NODE, OFFSET = 9, 10, 11, 12, 13, 14, 15


class Books(NamedTuple):
    """Which march passed each sample, where, in which direction and how often: the march's only state.

    Attributes
    ----------
    owner, node : (N,) array of int
        Fragment that passed the sample last (-1: none), and its node there.
    way : (N, 3) array
        Direction of that pass.
    uses : (N,) array of int
        In how many balls the sample has been.
    found : (N,) array of int, local : (N, 4) array
        Room for a strip's samples: indices, and places along it with offsets from its axis.
    """

    owner: NDArray[np.int64]
    node: NDArray[np.int64]
    way: NDArray[np.float32]
    uses: NDArray[np.int64]
    found: NDArray[np.int64]
    local: NDArray[np.float64]

    @classmethod
    def empty(cls, count: int) -> Books:
        """Open the books on ``count`` samples that nothing has passed."""
        return cls(
            np.full(count, -1, np.int64),
            np.zeros(count, np.int64),
            np.zeros((count, 3), np.float32),
            np.zeros(count, np.int64),
            np.empty(count, np.int64),
            np.empty((count, 4)),
        )


@njit(cache=True)
def gather_strip(grid, at, r, half, found, local):  # type: ignore[no-untyped-def]
    """Collect the samples of the bent strip around ``at``.

    Parameters
    ----------
    grid : Grid
    at : (>= 9,) array
        Centre, unit direction, curvature vector.
    r, half : float
        Half-length and half-width.
    found : (N,) array of int
        Receives the indices of the samples.
    local : (N, 4) array
        Receives their place along the strip and their offset from its axis.

    Returns
    -------
    int
        Number of samples.
    """
    points, starts, origin, cell, shape = grid.points, grid.starts, grid.origin, grid.cell, grid.shape
    cx, cy, cz, vx, vy, vz, kx, ky, kz = at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7], at[8]
    bend = 0.5 * r * r
    hx = r * abs(vx) + half + bend * abs(kx)
    hy = r * abs(vy) + half + bend * abs(ky)
    hz = r * abs(vz) + half + bend * abs(kz)
    x0, x1 = cell_range(cx - hx, cx + hx, origin[0], cell, shape[0])
    y0, y1 = cell_range(cy - hy, cy + hy, origin[1], cell, shape[1])
    z0, z1 = cell_range(cz - hz, cz + hz, origin[2], cell, shape[2])
    count = 0
    if z1 < z0:
        return count
    for ix in range(x0, x1 + 1):
        for iy in range(y0, y1 + 1):
            row = (ix * shape[1] + iy) * shape[2]
            for i in range(starts[row + z0], starts[row + z1 + 1]):
                dx, dy, dz = points[i, 0] - cx, points[i, 1] - cy, points[i, 2] - cz
                t = dx * vx + dy * vy + dz * vz
                if abs(t) >= r:
                    continue
                h = 0.5 * t * t
                ox, oy, oz = dx - t * vx - h * kx, dy - t * vy - h * ky, dz - t * vz - h * kz
                if ox * ox + oy * oy + oz * oz < half * half:
                    found[count] = i
                    local[count, 0], local[count, 1], local[count, 2], local[count, 3] = t, ox, oy, oz
                    count += 1
    return count


@njit(cache=True)
def _count_ahead(count, books, me, trail, at, out):  # type: ignore[no-untyped-def]
    """Count the samples ahead, and those of them that a march in this direction has passed before."""
    owner, owner_node, owner_way, found, local = books.owner, books.node, books.way, books.found, books.local
    ahead, owned = 0, 0
    nearest = np.inf
    out[OWNER], out[OWNER_NODE] = -1.0, 0.0
    for j in range(count):
        if local[j, 0] <= 0.0:
            continue
        ahead += 1
        i = found[j]
        if owner[i] < 0 or (owner[i] == me and owner_node[i] >= trail):
            continue
        # The strip's direction where the sample lies: it turns with the curvature.
        wx, wy, wz = at[3] + local[j, 0] * at[6], at[4] + local[j, 0] * at[7], at[5] + local[j, 0] * at[8]
        along = owner_way[i, 0] * wx + owner_way[i, 1] * wy + owner_way[i, 2] * wz
        if abs(along) > ALIGNED * np.sqrt(wx * wx + wy * wy + wz * wz):
            owned += 1
            if local[j, 0] < nearest:
                nearest = local[j, 0]
                out[OWNER], out[OWNER_NODE] = owner[i], owner_node[i]
    out[N_ALL], out[N_AHEAD], out[N_OWNED] = count, ahead, owned


@njit(cache=True)
def _drop_used_up(count, books, most_uses):  # type: ignore[no-untyped-def]
    """Leave out samples that have been in as many balls as allowed (§4.2.2)."""
    kept = 0
    for j in range(count):
        if books.uses[books.found[j]] < most_uses:
            books.found[kept] = books.found[j]
            books.local[kept] = books.local[j]
            kept += 1
    return kept


@njit(cache=True)
def _moments(count, local, r, half, m, target):  # type: ignore[no-untyped-def]
    """Weighted moments of u = t / r up to the fourth power, and of the offsets times 1, u, u^2."""
    m[:] = 0.0
    target[:] = 0.0
    square = 0.0
    for j in range(count):
        u = local[j, 0] / r
        ox, oy, oz = local[j, 1], local[j, 2], local[j, 3]
        o2 = ox * ox + oy * oy + oz * oz
        taper = 1.0 - u * u
        w = taper * taper * (1.0 - o2 / (half * half))
        square += w * o2
        for power in range(3):
            m[power] += w
            target[power, 0] += w * ox
            target[power, 1] += w * oy
            target[power, 2] += w * oz
            w *= u
        m[3] += w
        m[4] += w * u
    return square


@njit(cache=True)
def fit_strip(grid, books, limits, at, r, half, out):  # type: ignore[no-untyped-def]
    """Fit centre, direction and curvature to the samples of the strip around ``at``.

    Parameters
    ----------
    grid : Grid
    books : Books
    limits : (4,) array of int
        Own fragment's number, first node that counts as trail, largest number of uses
        (0: no limit), number of normal directions (1 flat, 2 in space).
    at, r, half
        As for :func:`gather_strip`.
    out : (>= FIT_SIZE,) array
        Receives the fit.

    Returns
    -------
    bool
        Whether the samples suffice for a fit.
    """
    count = gather_strip(grid, at, r, half, books.found, books.local)
    if limits[2] > 0:
        count = _drop_used_up(count, books, limits[2])
    _count_ahead(count, books, limits[0], limits[1], at, out)
    if count < LEAST_SAMPLES:
        return False
    s = np.empty(5)
    target = np.empty((3, 3))
    square = _moments(count, books.local, r, half, s, target)
    # Normal equations of o = a + b u + g u^2, solved by cofactors (symmetric 3 x 3).
    m00, m01, m02 = s[2] * s[4] - s[3] * s[3], s[2] * s[3] - s[1] * s[4], s[1] * s[3] - s[2] * s[2]
    m11, m12, m22 = s[0] * s[4] - s[2] * s[2], s[1] * s[2] - s[0] * s[3], s[0] * s[2] - s[1] * s[1]
    det = s[0] * m00 + s[1] * m01 + s[2] * m02
    if s[0] <= 0.0 or not det > 1e-9 * s[0] ** 3:
        return False
    explained, drift, norm, along = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        t0, t1, t2 = target[0, k], target[1, k], target[2, k]
        place = (m00 * t0 + m01 * t1 + m02 * t2) / det
        slope = (m01 * t0 + m11 * t1 + m12 * t2) / det
        bow = (m02 * t0 + m12 * t1 + m22 * t2) / det
        explained += place * t0 + slope * t1 + bow * t2
        drift += place * place
        out[k] = at[k] + place
        out[3 + k] = at[3 + k] + slope / r
        out[6 + k] = at[6 + k] + 2.0 * bow / (r * r)
        norm += out[3 + k] * out[3 + k]
    norm = 1.0 / np.sqrt(norm)
    for k in range(3):
        out[3 + k] *= norm
        along += out[3 + k] * out[6 + k]
    for k in range(3):
        out[6 + k] -= along * out[3 + k]
    spare = max(count - 3.6, 1.0) / count  # the tapered weights make the fit cost a little more than 3
    constant = WEIGHTED_VARIANCE_FLAT if limits[3] == 1 else WEIGHTED_VARIANCE_SPACE
    out[SIGMA] = np.sqrt(max(square - explained, 0.0) / (s[0] * spare * constant))
    out[OFFSET] = np.sqrt(drift)
    return True


@njit(cache=True)
def own_strip(grid, books, me, node, at, reach, r, half):  # type: ignore[no-untyped-def]
    """Mark the samples within ``reach`` along the strip as passed, and count a use of all of it.

    Returns
    -------
    float
        Mean number of uses of the strip's samples.
    """
    owner_way = books.way
    count = gather_strip(grid, at, r, half, books.found, books.local)
    total = 0
    for j in range(count):
        i = books.found[j]
        books.uses[i] += 1
        total += books.uses[i]
        t = books.local[j, 0]
        if abs(t) <= reach:
            books.owner[i] = me
            books.node[i] = node
            wx, wy, wz = at[3] + t * at[6], at[4] + t * at[7], at[5] + t * at[8]
            norm = 1.0 / np.sqrt(wx * wx + wy * wy + wz * wz)
            owner_way[i, 0], owner_way[i, 1], owner_way[i, 2] = wx * norm, wy * norm, wz * norm
    return total / max(count, 1)


@njit(cache=True)
def passed_share(grid, books, at, r, half):  # type: ignore[no-untyped-def]
    """Share of the strip's samples that any march has passed; 0 for an empty strip."""
    count = gather_strip(grid, at, r, half, books.found, books.local)
    passed = 0
    for j in range(count):
        if books.owner[books.found[j]] >= 0:
            passed += 1
    return passed / count if count > 0 else 0.0
