"""Where closed curves begin: at the foot of their outermost sample.

Regression bins start there; where a library begins the border of a tape must not matter.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample, spread_subsample
from core.refine.polyline import Polyline
from core.refine.principal_curve import Refined, refine_curves
from core.refine.project import project

__all__ = ["begun_outermost", "smoothed"]

SOME = 2000  # samples of which the outermost one is taken
REACH = 4.0  # in sigma


def begun_outermost(sample: Sample, curves: Sequence[Polyline], sigma: float) -> list[Polyline]:
    """Let every closed curve begin at the foot of its outermost sample.

    Parameters
    ----------
    sample : Sample
    curves : sequence of Polyline
    sigma : float
        Noise estimate.
    """
    if not any(line.closed for line in curves):
        return list(curves)
    some = sample.few[spread_subsample(sample.few, SOME)]
    feet = project(some, curves, max(REACH * sigma, 1e-9))
    away = some - some.mean(axis=0)
    far = np.einsum("ij,ij->i", away, away)
    out = []
    for k, line in enumerate(curves):
        mine = np.flatnonzero(feet.curve == k)
        known = line.closed and len(mine) > 0
        out.append(_rolled(line, float(feet.station[mine[np.argmax(far[mine])]])) if known else line)
    return out


def smoothed(judged: Sample, curves: Sequence[Polyline], sigma: float) -> Refined:
    """Refine planar curves briefly, to compare hypotheses.

    Parameters
    ----------
    judged : Sample
        A few samples.
    curves : sequence of Polyline
    sigma : float
        Noise estimate.
    """
    begun = begun_outermost(judged, curves, sigma)
    return refine_curves(judged, begun, sigma, True, passes=2, corners=False)


def _rolled(line: Polyline, start: float) -> Polyline:
    """A closed curve from another station on."""
    stations = line.stations[:-1]
    x: NDArray[np.float64] = np.concatenate(
        [line.at(np.array([start])), line.vertices[stations > start], line.vertices[stations < start]]
    )
    return Polyline(x[np.append(True, np.any(x[1:] != x[:-1], axis=1))], True)
