"""Open ends that face each other over a gap in the samples: a curve that may go on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.gaps import expected_gap
from core.refine.polyline import Polyline

__all__ = ["Facing", "facing_ends"]

Floats = NDArray[np.float64]

AIM = np.cos(np.radians(30.0))  # how well ends point at each other
FAR = 4.0  # times the longest gap of independent samples: ends farther apart are ends
ARM = 10.0  # in sigma, or
ARM_SPACINGS = 12.0  # in distances between samples: over which an end's direction is taken
KNOWN = 1e9  # spacings: the density is that of whole curves


@dataclass(frozen=True, slots=True, eq=False)
class Facing:
    """Two ends that face each other: the middle between them, their distance, and that in mean spacings."""

    place: Floats
    gap: float
    spacings: float
    expected: float


def facing_ends(lines: Sequence[Polyline], counts: Sequence[int], sigma: float, total: int) -> list[Facing]:
    """Find pairs of open ends over a gap longer than independent samples leave, and not much longer.

    Parameters
    ----------
    lines : sequence of Polyline
    counts : sequence of int
        Samples of each.
    sigma : float
        Noise standard deviation.
    total : int
        Number of samples of all curves.
    """
    expected = expected_gap(total, KNOWN)
    ends = []
    for line, count in zip(lines, counts, strict=True):
        length = line.length
        if line.closed or count < 2.0 * ARM_SPACINGS or not length > 0.0:
            continue
        spacing = length / count
        arm = min(max(ARM * sigma, ARM_SPACINGS * spacing), 0.5 * length)
        for tip, back in (line.at(np.array([0.0, arm])), line.at(np.array([length, length - arm]))):
            ends.append((tip, (tip - back) / max(float(np.linalg.norm(tip - back)), 1e-300), spacing))
    out = []
    for i, (a, u, p) in enumerate(ends):
        for b, w, q in ends[i + 1 :]:
            gap, spacing = float(np.linalg.norm(b - a)), max(p, q)
            if not expected < gap / spacing < FAR * expected:
                continue
            if min(u @ (b - a), w @ (a - b)) > AIM * gap:
                out.append(Facing(0.5 * (a + b), gap, gap / spacing, expected))
    return out
