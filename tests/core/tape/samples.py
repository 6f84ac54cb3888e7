"""Noisy samples with what they say of themselves, for the tests of the tape."""

import numpy as np

from core.cloud.sampling import CANDIDATES, Sample, estimate_scale
from tests.core.shapes import in_space


def measured(points):
    """Sample, scale and extent of a planar point set, (N, 2)."""
    sample = Sample.of(in_space(points))
    extent = float(np.linalg.norm(sample.points, axis=1).max())
    return sample, estimate_scale(sample, extent, True), extent


def thinning(points):
    """Share of the samples that balls are found with."""
    return min(CANDIDATES / len(points), 1.0)


def along(curve, n, sigma, seed=0):
    """Independent noisy samples, (N, 2), uniform along a polyline."""
    rng = np.random.default_rng(seed)
    places = curve.at(rng.uniform(0.0, curve.length, n))[:, :2]
    return places + sigma * rng.normal(size=(n, 2))
