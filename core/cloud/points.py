"""A point set as the core takes it: validated, centred and scaled (§4.1, step i)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.errors import InvalidPoints

__all__ = [
    "LARGEST",
    "Normalisation",
    "as_points",
    "bounds",
    "centred",
    "distinct",
    "inverse_power_of_two",
    "scaled_offset",
]

Floats = NDArray[np.float64]

# Odd multipliers of 64 bits, arbitrary.
HASH = np.array([0x1E3779B97F4A7C15, 0x2545F4914F6CDD1D, 0x369DEA0F31A53F85], dtype=np.int64)
# A point set with a larger share of repeated points than this is freed of them.
REPEATED = 0.002

LARGEST = float(np.finfo(np.float64).max)


def as_points(points: ArrayLike) -> Floats:
    """Validate a point set.

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
        Integers or floats, at least one row; copied only where needed.

    Returns
    -------
    (N, d) array of float64, C-contiguous
        The input itself when it is such an array already.

    Raises
    ------
    InvalidPoints
        With ``loc`` the path to the first bad value: ``("points", row, column)``.
    """
    array = _numeric(points)
    if array.ndim != 2 or array.shape[1] not in {2, 3}:
        raise InvalidPoints(
            f"Points must be rows of 2 or 3 numbers, shape (N, 2) or (N, 3); the shape is {array.shape}.",
            ("points",),
            "wrong-shape",
        )
    if len(array) == 0:
        raise InvalidPoints("The point set is empty: give at least one point.", ("points",), "too-few-points")
    # Integers and extended precision may exceed the range of doubles: that is not finite either.
    with np.errstate(over="ignore"):
        floats = np.ascontiguousarray(array, dtype=np.float64)
    _require_finite(floats)
    return floats


def _numeric(points: ArrayLike) -> NDArray[np.generic]:
    """Make the points an array of real numbers of any type."""
    try:
        array = np.asarray(points)
    except (ValueError, TypeError, OverflowError) as error:
        raise InvalidPoints(
            "Points must be rows of equal length, 2 or 3.", ("points",), "wrong-shape"
        ) from error
    # An empty list has the type float, and is refused later for its shape.
    if array.dtype.kind not in "iuf":
        raise InvalidPoints(
            f"Points must be real numbers; the array's type is {array.dtype}.", ("points",), "wrong-type"
        )
    return array


def _require_finite(points: Floats) -> None:
    finite = np.isfinite(points)
    if finite.all():
        return
    row, column = divmod(int(np.argmin(finite)), points.shape[1])
    raise InvalidPoints(
        f"Coordinate {column} of point {row} is not a finite number.", ("points", row, column), "not-finite"
    )


def bounds(points: Floats) -> Floats:
    """Lower and upper corner, (2, d), of the bounding box of an (N, d) point set."""
    # Axis by axis: numpy reduces a long narrow array some ten times slower.
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


@dataclass(frozen=True, slots=True, eq=False)
class Normalisation:
    """The similarity that centres a point set on its centre of gravity and gives it unit spread.

    Attributes
    ----------
    centre : (d,) array
        Centre of gravity of the points.
    scale : float
        Root mean square of the coordinates about the centre, positive: the same in every
        rotated frame. 1 for coincident points.
    """

    centre: Floats
    scale: float

    def apply(self, points: Floats) -> Floats:
        """Bring (M, d) points from input space to the normalised space."""
        unit = inverse_power_of_two(self.scale)
        return scaled_offset(points, self.centre, unit) / (self.scale * unit)

    def restore(self, points: Floats) -> Floats:
        """Bring (M, d) points from the normalised space back to input space."""
        # As in scaled_offset: the sum of large numbers must not overflow on the way.
        down = min(inverse_power_of_two(self.scale), 1.0)
        sums = points * (self.scale * down) + self.centre * down
        # The largest doubles may be rounded upward, out of range.
        return np.asarray(np.clip(sums, -LARGEST * down, LARGEST * down) / down)


def scaled_offset(points: Floats, origin: Floats, unit: float) -> Floats:
    """Compute (points - origin) * unit for a power of two, which is scaled down by first or up by last.

    So neither overflows where the result does not, and the only rounding is that of the difference.
    """
    down, up = min(unit, 1.0), max(unit, 1.0)
    return np.asarray((points * down - origin * down) * up)


def inverse_power_of_two(scale: float) -> float:
    """Inverse of the power of two next to a length, as far as doubles have it: multiplying by it is exact."""
    return math.ldexp(1.0, min(1023, -math.frexp(scale)[1]))


def centred(points: Floats) -> tuple[Floats, Normalisation]:
    """Centre and scale a point set, whatever its offset and its size.

    Differences are taken before anything is squared, and a power of two is divided
    out first: an offset of 10^7 extents costs nothing but the rounding that the input
    itself has, and coordinates near the limits of doubles neither over- nor underflow.

    Parameters
    ----------
    points : (N, d) array
        Finite, at least one row (see :func:`as_points`).

    Returns
    -------
    (N, d) array
        Coordinates with mean 0 and mean square 1 (0 for coincident points).
    Normalisation
        The way back.

    Examples
    --------
    >>> import numpy as np
    >>> unit, way = centred(np.array([[1e9, 4.0], [1e9 + 2, 6.0]]))
    >>> unit
    array([[-1., -1.],
           [ 1.,  1.]])
    >>> (way.restore(unit) - 1e9)[:, 0]
    array([0., 2.])
    """
    low, high = bounds(points)
    middle = low / 2 + high / 2
    unit = inverse_power_of_two(float(np.max(high / 2 - low / 2)))
    offset = scaled_offset(points, middle, unit)
    mean = offset.mean(axis=0)
    offset -= mean
    spread = math.sqrt(np.einsum("ij,ij->", offset, offset) / offset.size)
    down = min(unit, 1.0)
    centre = (middle * down + mean / unit * down) / down
    way = Normalisation(centre, spread / unit if spread / unit > 0 else 1.0)
    return way.apply(points), way


def distinct(points: Floats) -> Floats:
    """Keep one of each set of equal points, unless next to none are equal.

    Sorted by a hash of their bits, equal points follow one another, whatever their order
    was; a collision of hashes can at worst keep a repetition.

    Parameters
    ----------
    points : (N, d) array

    Returns
    -------
    (M, d) array
        The input itself when next to none are equal.
    """
    bits = (points + 0.0).view(np.int64)  # -0 + 0 is 0
    hashed = bits[:, 0] * HASH[0]
    for axis in range(1, points.shape[1]):
        hashed ^= (hashed >> 29) + bits[:, axis] * HASH[axis]
    ordered = np.sort(hashed)
    if np.count_nonzero(ordered[1:] == ordered[:-1]) <= REPEATED * len(points):
        return points
    rows = points.take(np.argsort(hashed), axis=0)
    return rows[np.concatenate(([True], (rows[1:] != rows[:-1]).any(axis=1)))]
