"""The partition of a point set into extended neighbours (§3.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.cloud.epsilon import estimate_epsilon, least_component_size
from core.cloud.frame import principal_frames
from core.cloud.linkage import components
from core.cloud.points import as_points, centred
from core.parameters import PartitionParameters
from core.results import Component, Partition, Warn

__all__ = ["components", "partition"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# A larger share of outliers than this deserves a warning.
MANY_OUTLIERS = 0.3
# Distances that differ by less than this, relative to the extent, are ties.
TIE = 1e-9


def partition(points: ArrayLike, parameters: PartitionParameters | None = None) -> Partition:
    """Partition a point set into the classes of extended neighbours (§3.3).

    Two points belong together when a chain of points joins them with no hop longer than
    epsilon. Classes of fewer than ``min_component_size`` points are outliers.

    Parameters
    ----------
    points : array_like, (N, 2) or (N, 3)
    parameters : PartitionParameters, optional
        ``epsilon`` null: estimated, see :func:`core.cloud.epsilon.estimate_epsilon`;
        ``min_component_size`` null: ceil(ln N) + 1.

    Returns
    -------
    Partition
        Labels 0, 1, … by decreasing size, -1 for outliers. Of components of equal size, the
        one whose centre of gravity is nearer to that of all points comes first; then the one
        of less spread; then by their centres of gravity, coordinate by coordinate.

    Raises
    ------
    InvalidPoints
        See :func:`core.cloud.points.as_points`.

    Examples
    --------
    >>> import numpy as np
    >>> line = np.column_stack((np.arange(50.0), np.zeros(50)))
    >>> answer = partition(np.concatenate((line, line + [0, 30])), PartitionParameters(epsilon=1.0))
    >>> answer.count, answer.labels[[0, -1]].tolist()
    (2, [0, 1])
    """
    array = as_points(points)
    given = parameters or PartitionParameters()
    epsilon = given.epsilon or estimate_epsilon(array)
    least = given.min_component_size or least_component_size(len(array))
    labels = _numbered(array, components(array, epsilon), least)
    classes = _components(array, labels)
    return Partition(
        epsilon=epsilon,
        epsilon_source="given" if given.epsilon else "estimated",
        labels=labels,
        components=classes,
        warnings=_warnings(labels, len(classes), epsilon, least),
    )


def _numbered(points: Floats, raw: Ints, least: int) -> Ints:
    """Labels by decreasing size, -1 for components smaller than ``least``."""
    sizes = np.bincount(raw)
    kept = np.flatnonzero(sizes >= least)
    number = np.full(len(sizes), -1)
    number[kept[_order(points, raw, sizes, kept)]] = np.arange(len(kept))
    return number.take(raw)


def _order(points: Floats, raw: Ints, sizes: Ints, kept: Ints) -> Ints:
    """Order of the kept components: by size, then by what no frame of reference changes."""
    if len(np.unique(sizes[kept])) == len(kept):
        return np.argsort(-sizes[kept])
    unit, _ = centred(points)
    means = np.column_stack([np.bincount(raw, x) / sizes for x in unit.T])
    squares = np.bincount(raw, np.einsum("ij,ij->i", unit, unit)) / sizes
    distance = np.einsum("ij,ij->i", means, means)
    keys = [*means.T[::-1], squares - distance, distance]
    return np.lexsort([*(np.round(key[kept] / TIE) for key in keys), -sizes[kept]])


def _components(points: Floats, labels: Ints) -> tuple[Component, ...]:
    """Size, bounding box and frame of each component."""
    sizes = np.bincount(labels + 1)[1:]
    if len(sizes) == 0:
        return ()
    outliers = len(labels) - int(sizes.sum())
    grouped = points if sizes[0] == len(points) else points.take(np.argsort(labels)[outliers:], axis=0)
    starts = np.concatenate(([0], np.cumsum(sizes)))
    low = np.column_stack([np.minimum.reduceat(x, starts[:-1]) for x in grouped.T])
    high = np.column_stack([np.maximum.reduceat(x, starts[:-1]) for x in grouped.T])
    return tuple(
        Component(c, size, np.stack((low[c], high[c])), frame)
        for c, (size, frame) in enumerate(zip(sizes.tolist(), principal_frames(grouped, starts), strict=True))
    )


def _warnings(labels: Ints, count: int, epsilon: float, least: int) -> tuple[Warn, ...]:
    """Say what the caller should know of the partition."""
    if count == 0:
        return (
            Warn(
                "no-component",
                f"No chain with hops of at most {epsilon:.6g} joins {least} points or more: all points are "
                "outliers. Give a larger epsilon or a smaller min_component_size.",
            ),
        )
    outliers = int(np.count_nonzero(labels < 0))
    if outliers > MANY_OUTLIERS * len(labels):
        return (
            Warn(
                "many-outliers",
                f"{outliers} of {len(labels)} points lie in components of fewer than {least} points with "
                f"hops of at most {epsilon:.6g}. Where they belong to a curve, give a larger epsilon.",
            ),
        )
    return ()
