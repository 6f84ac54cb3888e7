"""The best of a contestant's answers, chosen with knowledge of the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.graphs import curves_of_graph, smoothed
from benchmarks.peers.told import Answer
from core.truth import PointSet, Score, score
from core.truth.metrics import distances, resample, rms

__all__ = ["LIMITS", "TOLERANCES", "best_score", "readings_of"]

Floats = NDArray[np.float64]
Polyline = tuple[Floats, bool]

LIMITS = (4.0, 10.0, 25.0)  # sigma: shorter spurs, bridges and gaps of a graph are none
TOLERANCES = (0.1, 0.3, 0.6)  # sigma: how far vertices may move to make a curve smooth
FINALISTS = 3  # whose whole score is computed; the rest is sifted by a coarse one
_SIFTED = 400  # places on either side for that


def readings_of(answer: Answer, sigma: float) -> Iterator[list[Polyline]]:
    """Yield what a peer's answer can be read as: every limit of spurs, as it is and smooth."""
    for curves in _raw(answer, sigma):
        yield curves
        yield from (smoothed(curves, tolerance * sigma) for tolerance in TOLERANCES)


def _raw(answer: Answer, sigma: float) -> Iterator[list[Polyline]]:
    if answer.curves is not None:
        yield answer.curves
    elif answer.vertices is not None and answer.edges is not None:
        for limit in LIMITS:
            yield curves_of_graph(answer.vertices, answer.edges, limit * sigma)


def best_score(candidates: Sequence[list[Polyline]], truth: PointSet) -> tuple[int, Score] | None:
    """Return the number and the score of the best candidate: right topology first, then the least error."""
    usable = [
        k for k, one in enumerate(candidates) if one and all(np.isfinite(line).all() for line, _ in one)
    ]
    if not usable:
        return None
    if len(usable) > 1:
        wanted = sorted(one.closed for one in truth.curves)
        sifted = sorted(usable, key=lambda k: _coarse(candidates[k], truth, wanted))
        usable = sifted[:FINALISTS]
    scores = [(k, score(candidates[k], truth)) for k in usable]
    return min(scores, key=lambda one: _rank(one[1]))


def _coarse(curves: list[Polyline], truth: PointSet, wanted: list[bool]) -> tuple[bool, float]:
    true = [(one.vertices, one.closed) for one in truth.curves]
    there = distances(np.concatenate(resample(true, _SIFTED)), curves, _SIFTED)
    back = distances(np.concatenate(resample(curves, _SIFTED)), true, _SIFTED)
    return sorted(closed for _, closed in curves) != wanted, max(rms(there), rms(back))


def _rank(got: Score) -> tuple[bool, bool, float]:
    return not got.topology_right, not got.flags_right, max(got.rms, got.rms_back)
