"""The sampling block: what the data say of themselves, in the user's units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.cloud.points import LARGEST
from core.diagnosis.branches import LEAST_GAP, branch_gaps
from core.refine.crossings import crossings
from core.results import Curve, Nyquist, Partition, Sampling, Violation
from core.solved import Solved

__all__ = ["sampling_of", "verdict_of"]


def sampling_of(curves: Sequence[Curve], solved: Sequence[Solved], parts: Partition) -> Sampling:
    samples = sum(c.samples for c in curves)
    length = sum(c.length for c in curves)
    weights = np.array([len(one.members) for one in solved], np.float64)
    sigmas = np.array([one.refined.sigma * one.frame.scale for one in solved])
    largest = max(float(sigmas.max()), float(np.finfo(np.float64).tiny))  # squares of huge ones overflow
    sigma = largest * float(np.sqrt(np.average((sigmas / largest) ** 2, weights=weights)))
    # Of coordinates near the smallest doubles there are more samples a unit than doubles can say.
    density = min(samples / length, LARGEST) if length > 0 else 0.0
    return Sampling(sigma, density, parts.epsilon, _nyquist(solved))


def _nyquist(solved: Sequence[Solved]) -> Nyquist:
    """The least distance between branches, and every place where it is too small."""
    violations: list[Violation] = []
    margin: float | None = None
    for one in solved:
        sigma = one.refined.sigma
        meetings = crossings(one.refined.curves) if one.frame.flat else []
        for place, gap in branch_gaps(one.refined.curves, sigma):
            if any(np.linalg.norm(m.place - place) < 12.0 * sigma + 2.0 * gap for m in meetings):
                continue
            sigmas = gap / sigma
            margin = sigmas if margin is None else min(margin, sigmas)
            if sigmas < LEAST_GAP:
                location = one.frame.restore(place[None])[0]
                reason = (
                    f"two branches only {sigmas:.1f} sigma apart: noise must stay below half of the detail"
                )
                violations.append(Violation(location, float(sigmas), reason))
    return Nyquist(not violations, margin, tuple(violations))


def verdict_of(sampling: Sampling) -> str:
    """Say in one sentence whether the samples are good enough.

    Parameters
    ----------
    sampling : Sampling
    """
    if sampling.nyquist.compliant:
        return "The samples are good enough: the noise stays below half of the smallest detail."
    return f"The samples are not good enough in {len(sampling.nyquist.violations)} places."
