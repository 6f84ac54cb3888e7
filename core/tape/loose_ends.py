"""Gaps of the tape: loose ends of its curves are joined as the march joins its own (§4.2.2, 5.1).

A tape narrow enough to keep branches apart tears where independent samples leave a wide gap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.march.fragments import Fragment
from core.march.join import join_fragments
from core.march.prune import prune_fragments
from core.march.strip import N_ALL, SIGMA
from core.march.walk import DENSITY, NODE_SIZE, RADIUS
from core.refine.polyline import Polyline
from core.refine.project import Feet

__all__ = ["joined"]

Floats = NDArray[np.float64]

STEP = 0.5  # of the radius, as the march's
MOST_RADIUS = 0.2  # of a curve's length
LEAST_STEPS = 8


def joined(
    sample: Sample, curves: Sequence[Polyline], feet: Feet, thinning: float, sigma: float, radius: float
) -> list[Polyline]:
    """Drop curves that run along others, and join ends where the samples allow it.

    Parameters
    ----------
    sample : Sample
    curves : sequence of Polyline
    feet : Feet
        Of some samples on the curves.
    thinning : float
        How many those are, as a share of ``sample.many``.
    sigma : float
        Noise estimate.
    radius : float
        Length over which the curves are nearly straight.
    """
    fragments = [
        _fragment(line, np.sort(feet.station[feet.curve == k]), thinning, sigma, radius)
        for k, line in enumerate(curves)
        if line.length > 0.0
    ]
    return join_fragments(sample, prune_fragments(sample, fragments, sigma))


def _fragment(line: Polyline, stations: Floats, thinning: float, sigma: float, radius: float) -> Fragment:
    """What a march along the curve would have noted."""
    length = line.length
    radius = min(radius, MOST_RADIUS * length)
    steps = max(int(np.ceil(length / (STEP * radius))), LEAST_STEPS)
    at = np.linspace(0.0, length, steps + 1)[: steps + (0 if line.closed else 1)]
    low, high = at - STEP * radius, at + STEP * radius
    if not line.closed:
        low, high = np.maximum(low, 0.0), np.minimum(high, length)
    direction = line.at(high) - line.at(low)
    direction /= np.maximum(np.linalg.norm(direction, axis=1), 1e-300)[:, None]
    seen = np.searchsorted(stations, at + radius) - np.searchsorted(stations, at - radius)
    covered = np.minimum(at + radius, length) - np.maximum(at - radius, 0.0)
    nodes = np.zeros((len(at), NODE_SIZE))
    nodes[:, :3], nodes[:, 3:6] = line.at(at), direction
    nodes[:, 6:9] = np.gradient(direction, at, axis=0)
    nodes[:, N_ALL], nodes[:, SIGMA], nodes[:, RADIUS] = seen, sigma, radius
    nodes[:, DENSITY] = np.maximum(seen, 2) / covered / thinning
    return Fragment(nodes, line.closed)
