"""The optimal local point set (§4.2.1): PCA of balls B(p, r) over all radii at once.

The residual of a line fit falls as a ball shrinks, so it must be normalised:
E(r) = lambda_2 / (n - 2) is the squared standard error of the fitted centre.
Noise makes it fall with r, curvature makes it rise; on a curve of curvature kappa
its minimum lies at r = 15^(1/4) sqrt(sigma / kappa), where lambda_2 = 4/3 sigma^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["Balls", "optimal_balls", "principal_direction"]

SHELL_RATIO = 1.1
SHELLS = 110  # radii over 1.1^110: four and a half decades below the extent
LEAST_SAMPLES = 10
LINEARITY = 0.35
HYSTERESIS = 1.25
SCATTER = 10.0  # small balls fluctuate: the hysteresis is wider by SCATTER / sqrt(n)
MINIMUM_RADIUS_FACTOR = 15.0**0.25
MINIMUM_VARIANCE_FACTOR = 4.0 / 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Balls:
    """One optimal ball a seed, in arrays of length M.

    ``radius`` is nan where no ball is linear; ``interior`` tells whether the error rose
    again beyond the radius (a true minimum, set by curvature) or the search met its end.
    """

    seed: NDArray[np.float64]
    centre: NDArray[np.float64]
    direction: NDArray[np.float64]
    radius: NDArray[np.float64]
    variance: NDArray[np.float64]
    samples: NDArray[np.int64]
    interior: NDArray[np.bool_]

    @property
    def shift(self) -> NDArray[np.float64]:
        """(M,) distance along the direction from seed to centre of gravity, in radii: large at ends."""
        return np.asarray(
            np.abs(np.einsum("ij,ij->i", self.seed - self.centre, self.direction)) / self.radius
        )

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which seeds have a ball."""
        return np.isfinite(self.radius)

    @property
    def sigma(self) -> NDArray[np.float64]:
        """(M,) noise estimates, the share of curvature taken out where there is any."""
        factor = np.where(self.interior, MINIMUM_VARIANCE_FACTOR, 1.0)
        return np.sqrt(self.variance / factor)

    @property
    def density(self) -> NDArray[np.float64]:
        """(M,) samples per unit length."""
        return self.samples / (2.0 * self.radius)


def optimal_balls(
    points: NDArray[np.float64], seeds: NDArray[np.float64], extent: float, flat: bool = True
) -> Balls:
    """Find for each seed the first local minimum of the normalised fitting error.

    Parameters
    ----------
    points : (N, 3) array
        Candidates; every seed reads all of them, so pass a subsample of a large set.
    seeds : (M, 3) array
    extent : float
        Largest radius of interest.
    flat : bool
        Whether the points lie in a plane: the normal variance has then one direction, else two.
    """
    out = _search(points, seeds, extent, 1.0 if flat else 2.0)
    return Balls(seeds, *out)


@njit(cache=True)
def _across_disc(ax, bx, cx, xy, xz, yz):  # type: ignore[no-untyped-def]
    """Compute a unit vector across the one direction that M - top I keeps when top is a double eigenvalue."""
    nx, ny, nz = ax, xy, xz
    if bx * bx > ax * ax and bx * bx >= cx * cx:
        nx, ny, nz = xy, bx, yz
    elif cx * cx > ax * ax:
        nx, ny, nz = xz, yz, cx
    if abs(nx) <= abs(ny):  # the cross product with the axis that is less aligned
        x, y, z = 0.0, nz, -ny
    else:
        x, y, z = -nz, 0.0, nx
    norm = np.sqrt(x * x + y * y + z * z)
    if norm == 0.0:
        return (1.0, 0.0, 0.0) if nx == 0.0 else (0.0, 1.0, 0.0)
    return x / norm, y / norm, z / norm


@njit(cache=True)
def principal_direction(xx, xy, xz, yy, yz, zz):  # type: ignore[no-untyped-def]
    """Largest eigenvalue and its unit eigenvector of a symmetric 3 x 3 matrix, in closed form."""
    q = (xx + yy + zz) / 3.0
    off = xy * xy + xz * xz + yz * yz
    p2 = (xx - q) ** 2 + (yy - q) ** 2 + (zz - q) ** 2 + 2.0 * off
    if p2 <= 1e-300:  # a sixth of the smallest doubles is none
        return q, 1.0, 0.0, 0.0
    p = np.sqrt(p2 / 6.0)
    a, b, c = (xx - q) / p, (yy - q) / p, (zz - q) / p
    d, e, f = xy / p, xz / p, yz / p
    half = 0.5 * (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e))
    top = q + 2.0 * p * np.cos(np.arccos(min(1.0, max(-1.0, half))) / 3.0)
    # The eigenvector is the longest cross product of two rows of M - top I.
    ax, bx, cx = xx - top, yy - top, zz - top
    best = -1.0
    vx, vy, vz = 1.0, 0.0, 0.0
    for k in range(3):
        if k == 0:
            x, y, z = xy * yz - xz * bx, xz * xy - ax * yz, ax * bx - xy * xy
        elif k == 1:
            x, y, z = xy * cx - xz * yz, xz * xz - ax * cx, ax * yz - xy * xz
        else:
            x, y, z = bx * cx - yz * yz, yz * xz - xy * cx, xy * yz - bx * xz
        norm = x * x + y * y + z * z
        if norm > best:
            best, vx, vy, vz = norm, x, y, z
    if best <= 1e-24 * p2 * p2:
        return top, *_across_disc(ax, bx, cx, xy, xz, yz)
    norm = 1.0 / np.sqrt(best)
    return top, vx * norm, vy * norm, vz * norm


@njit(cache=True)
def _shell_moments(points, seed, extent, shells):  # type: ignore[no-untyped-def]
    """Moments (1, x, y, z, xx, xy, xz, yy, yz, zz) about the seed, per shell of geometric radii."""
    shells[:] = 0.0
    scale = 0.5 / np.log(SHELL_RATIO)
    top = 2.0 * np.log(extent)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - seed[0], points[i, 1] - seed[1], points[i, 2] - seed[2]
        d2 = x * x + y * y + z * z
        if d2 > extent * extent:
            continue
        depth = (top - np.log(d2)) * scale if d2 > 0.0 else float(SHELLS)
        m = shells[max(SHELLS - 1 - int(depth), 0)]
        m[0] += 1.0
        m[1] += x
        m[2] += y
        m[3] += z
        m[4] += x * x
        m[5] += x * y
        m[6] += x * z
        m[7] += y * y
        m[8] += y * z
        m[9] += z * z


@njit(cache=True)
def _search(points, seeds, extent, normals):  # type: ignore[no-untyped-def]
    """Scan the radii of every seed upward and stop at the first minimum of E(r)."""
    count = seeds.shape[0]
    centre = np.zeros((count, 3))
    direction = np.zeros((count, 3))
    radius = np.full(count, np.nan)
    variance = np.full(count, np.nan)
    samples = np.zeros(count, np.int64)
    interior = np.zeros(count, np.bool_)
    shells = np.zeros((SHELLS, 10))
    total = np.zeros(10)
    for s in range(count):
        _shell_moments(points, seeds[s], extent, shells)
        total[:] = 0.0
        best = np.inf
        for k in range(SHELLS):
            if shells[k, 0] == 0.0:
                continue
            total += shells[k]
            n = total[0]
            if n < LEAST_SAMPLES:
                continue
            mx, my, mz = total[1] / n, total[2] / n, total[3] / n
            xx, xy, xz = total[4] / n - mx * mx, total[5] / n - mx * my, total[6] / n - mx * mz
            yy, yz, zz = total[7] / n - my * my, total[8] / n - my * mz, total[9] / n - mz * mz
            top, vx, vy, vz = principal_direction(xx, xy, xz, yy, yz, zz)
            across = max(xx + yy + zz - top, 0.0) / normals
            if not across < LINEARITY * top:
                if best < np.inf and across > (HYSTERESIS + SCATTER / np.sqrt(n)) * LINEARITY * top:
                    interior[s] = True
                    break
                continue
            error = across / (n - 2.0)
            if error < best:
                best = error
                centre[s, 0], centre[s, 1], centre[s, 2] = (
                    seeds[s, 0] + mx,
                    seeds[s, 1] + my,
                    seeds[s, 2] + mz,
                )
                direction[s, 0], direction[s, 1], direction[s, 2] = vx, vy, vz
                radius[s] = extent * SHELL_RATIO ** (k - SHELLS + 1)
                variance[s] = across * n / (n - 2.0)
                samples[s] = int(n)
            elif error > (HYSTERESIS + SCATTER / np.sqrt(n)) * best:
                interior[s] = True
                break
    return centre, direction, radius, variance, samples, interior
