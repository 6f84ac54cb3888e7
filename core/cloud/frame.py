"""Frames and planes of point sets: PCA, projection, rigid transform to XY and back (§3.1, §4.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.cloud.points import centred
from core.cloud.sampling import Sample, estimate_scale
from core.results import Frame

__all__ = ["Plane", "is_quasi_planar", "principal_frame", "principal_frames"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# A skewness below this is rounding: the distribution along the axis is symmetric.
SYMMETRIC = 1e-9
# What the rounding of a sum of millions of terms leaves of zero.
ROUNDING = 1e-12
# Coordinates beyond this are divided by four, or their differences might overflow.
HUGE = 1e307
# An out-of-plane spread of at most this many noise standard deviations is the noise's own:
# it is one of them for isotropic noise, and the estimate of the noise is good to some 30 %.
NOISE_FACTOR = 2.0
# What is flatter than this, relative to its extent in the plane, is planar for every purpose.
FLAT = 1e-3


def principal_frame(points: Floats, component: int = 0) -> Frame:
    """Frame [X_p Y_p Z_p O_p] of one point set by principal component analysis (§3.1).

    Parameters
    ----------
    points : (N, 2) or (N, 3) array
        Finite, at least one row. The z of 2D points is 0.
    component : int
        Label that the frame carries.

    Returns
    -------
    Frame
        Right-handed, axes by decreasing variance. X_p and Y_p point to where the points
        reach farther (positive skewness), so that a rotated point set has the rotated
        frame; for 2D points Z_p = (0, 0, 1). Collinear points are planar.

    Examples
    --------
    >>> import numpy as np
    >>> principal_frame(np.array([[0.0, 1.0], [0.0, 2.0], [0.0, 6.0]])).axes
    array([[ 0.,  1.,  0.],
           [-1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    (only,) = principal_frames(points, np.array([0, len(points)]))
    return Frame(component, only.origin, only.axes, only.planarity)


def principal_frames(points: Floats, starts: Ints) -> tuple[Frame, ...]:
    """Frames of consecutive groups of points, all in one pass (see :func:`principal_frame`).

    Parameters
    ----------
    points : (N, d) array, d = 2 or 3
        Group c is ``points[starts[c]:starts[c + 1]]``.
    starts : (C + 1,) array of int
        Strictly increasing, from 0 to N.

    Returns
    -------
    tuple of Frame
        Numbered from 0.
    """
    if len(starts) < 2:
        return ()
    largest = float(np.abs(points).max())
    unit = 0.25 if largest > HUGE else 1.0
    anchor, extent, mean, covariance = _moments(points, starts, unit)
    axes = np.linalg.eigh(covariance).eigenvectors[:, :, ::-1].transpose(0, 2, 1)
    # Summed anew along the axes: the covariance matrix knows sigma_z only to 1e-8 sigma_x.
    second, third = _moments_along(points, starts, unit, anchor, extent, mean, np.ascontiguousarray(axes))
    spread = np.sqrt(second)
    skewness = third / np.maximum(spread, 1e-100) ** 3
    oriented = _right_handed(axes * _signs(axes, skewness)[..., None])
    resolution = math.ulp(largest * unit) / extent + np.finfo(np.float64).eps
    origins = _in_space((anchor + extent[:, None] * mean) / unit)
    planarity = _planarity(spread, resolution).tolist()
    return tuple(Frame(c, origins[c], oriented[c], planarity[c]) for c in range(len(origins)))


@njit(cache=True)
def _moments(points, starts, unit):  # type: ignore[no-untyped-def]
    """Per group: first point, extent about it, and mean and covariance of (p unit - anchor) / extent.

    Differences from a point of the group come before anything is summed or squared, so
    that no offset costs digits; unit keeps them finite.
    """
    count, d = len(starts) - 1, points.shape[1]
    anchor, extent, mean = np.empty((count, d)), np.zeros(count), np.zeros((count, d))
    covariance = np.zeros((count, d, d))
    offset = np.empty(d)
    for c in range(count):
        for a in range(d):
            anchor[c, a] = points[starts[c], a] * unit
            for i in range(starts[c], starts[c + 1]):
                extent[c] = max(extent[c], abs(points[i, a] * unit - anchor[c, a]))
        if extent[c] == 0.0:
            extent[c] = 1.0
        size = starts[c + 1] - starts[c]
        for i in range(starts[c], starts[c + 1]):
            for a in range(d):
                mean[c, a] += (points[i, a] * unit - anchor[c, a]) / extent[c]
        mean[c] /= size
        for i in range(starts[c], starts[c + 1]):
            for a in range(d):
                offset[a] = (points[i, a] * unit - anchor[c, a]) / extent[c] - mean[c, a]
                for b in range(a + 1):
                    covariance[c, a, b] += offset[a] * offset[b]
        for a in range(d):
            for b in range(a + 1):
                covariance[c, a, b] /= size
                covariance[c, b, a] = covariance[c, a, b]
    return anchor, extent, mean, covariance


@njit(cache=True)
def _moments_along(points, starts, unit, anchor, extent, mean, axes):  # type: ignore[no-untyped-def]
    """Second and third central moments (C, d) of each group's normalised points along its axes."""
    count, d = len(starts) - 1, points.shape[1]
    second, third = np.zeros((count, d)), np.zeros((count, d))
    offset = np.empty(d)
    for c in range(count):
        size = starts[c + 1] - starts[c]
        for i in range(starts[c], starts[c + 1]):
            for a in range(d):
                offset[a] = (points[i, a] * unit - anchor[c, a]) / extent[c] - mean[c, a]
            for k in range(d):
                along = 0.0
                for a in range(d):
                    along += axes[c, k, a] * offset[a]
                second[c, k] += along * along
                third[c, k] += along * along * along
        second[c] /= size
        third[c] /= size
    return second, third


def _signs(axes: Floats, skewness: Floats) -> Floats:
    """(C, d) signs: towards the longer tail, or along the axis' largest entry where there is none."""
    largest = np.take_along_axis(axes, np.abs(axes).argmax(axis=2)[..., None], axis=2)[..., 0]
    return np.where(np.where(np.abs(skewness) > SYMMETRIC, skewness, largest) < 0, -1.0, 1.0)


def _right_handed(axes: Floats) -> Floats:
    """(C, 3, 3) right-handed axes from oriented ones; X_p alone decides in 2D, X_p and Y_p in 3D."""
    if axes.shape[1] == 3:
        return np.stack((axes[:, 0], axes[:, 1], np.cross(axes[:, 0], axes[:, 1])), axis=1)
    x = _in_space(axes[:, 0])
    z = np.broadcast_to([0.0, 0.0, 1.0], x.shape)
    return np.stack((x, np.cross(z, x), z), axis=1)


def _in_space(points: Floats) -> Floats:
    """(C, 3) points; 2D ones get z = 0."""
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def _planarity(spread: Floats, resolution: Floats) -> Floats:
    """(C,) 1 - sigma_z / sigma_y, and 1 for what is collinear to the rounding of its coordinates."""
    if spread.shape[1] == 2:
        return np.ones(len(spread))
    linear = spread[:, 1] <= 4 * resolution + ROUNDING
    return np.where(linear, 1.0, np.clip(1 - spread[:, 2] / np.where(linear, 1.0, spread[:, 1]), 0.0, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """A plane with a frame in it: the rigid transform of its points to XY, and the way back (§4.1 iv, v).

    Attributes
    ----------
    origin : (d,) array
    axes : (2, d) array
        Orthonormal rows. In 2D the plane is all of the space, and the transform a motion.
    normal : (d,) array
        Zero in 2D.
    """

    origin: Floats
    axes: Floats
    normal: Floats

    @classmethod
    def of(cls, points: Floats) -> Plane:
        """Best plane of an (N, d) point set by total least squares (§3.1): that of its frame."""
        best = principal_frame(points)
        d = points.shape[1]
        normal = best.axes[2] if d == 3 else np.zeros(2)
        return cls(best.origin[:d], best.axes[:2, :d], normal)

    def project(self, points: Floats) -> Floats:
        """(M, 2) coordinates in the plane of the orthogonal projections of (M, d) points."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def lift(self, coordinates: Floats) -> Floats:
        """(M, d) points of the plane with the given (M, 2) coordinates: the inverse of :meth:`project`."""
        return np.asarray(self.origin + coordinates @ self.axes)

    def distances(self, points: Floats) -> Floats:
        """(M,) signed distances of (M, d) points from the plane; 0 in 2D."""
        return np.asarray((points - self.origin) @ self.normal)


def is_quasi_planar(points: Floats, sigma: float | None = None) -> bool:
    """Judge whether the noise alone explains how far a point set leaves its best plane (§1, §4.1).

    A tilted noisy circle does not leave its plane by more than the noise that it has
    along its other normal; a helix or a knot does, by far.

    Parameters
    ----------
    points : (N, 2) or (N, 3) array
        One component, outliers removed.
    sigma : float, optional
        Noise standard deviation normal to the curve, in the units of the points.
        By default the local noise, from optimal balls (§4.2.1) in space.

    Returns
    -------
    bool
        True for every 2D set.
    """
    if points.shape[1] == 2:
        return True
    unit, way = centred(points)
    out_of_plane = float(np.sqrt(np.mean(Plane.of(unit).distances(unit) ** 2)))
    # The normalised coordinates have mean square 1, hence the points sqrt(3).
    if out_of_plane <= FLAT * np.sqrt(3):
        return True
    if sigma is None:
        extent = float(np.sqrt(np.max(np.sum(unit**2, axis=1))))
        scale = estimate_scale(Sample.of(unit), extent, flat=False)
        return scale is not None and out_of_plane <= NOISE_FACTOR * scale.sigma
    return out_of_plane <= NOISE_FACTOR * sigma / way.scale
