"""The PCA method on one component in working coordinates: march, prune, join, choose (§4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.cloud.sampling import Sample, spread_subsample
from core.march.fragments import Fragment, Pace, march_all
from core.march.join import join_fragments
from core.march.prune import prune_fragments, without_blobs
from core.march.strip import HALF_WIDTH
from core.refine.evidence import description_length
from core.refine.polyline import Polyline
from core.refine.principal_curve import refine_curves
from core.refine.project import project

__all__ = ["Marched", "solve_march"]

# Factors on the local radius: one set of strips may cut a corner that another follows.
RADIUS_SCALES = (1.0, 0.7, 1.4)
THOROUGH = 20000  # up to this many samples all of them are tried; beyond, only when the first leaves doubt
JUDGED = 5000  # samples by which hypotheses are compared, after a short refinement
CLEARLY = 10.0  # nats by which a later hypothesis must be better
THIN = 0.5  # of the density of the densest curve: thinner ones may be chance alignments of outliers
MOST_STRAYS = 10  # looked at
DOUBT = 0.03  # share of samples left over


@dataclass(frozen=True, slots=True, eq=False)
class Marched:
    """The chosen hypothesis: curves, the fragments they came from, and its description length."""

    curves: list[Polyline]
    fragments: list[Fragment]
    nats: float


def solve_march(sample: Sample, pace: Pace, factors: Sequence[float] | None = None) -> Marched:
    """March at several radii and keep the curves that explain the samples best.

    Parameters
    ----------
    sample : Sample
    pace : Pace
    factors : sequence of float, optional
        On the local radius, all of which are tried; by default those after the first of a large sample
        only in doubt.
    """
    best: Marched | None = None
    judged = Sample.of(sample.few[spread_subsample(sample.few, JUDGED)])
    wished = RADIUS_SCALES if factors is None else factors
    for factor in wished if not pace.radius else (1.0,):
        marched, left = _once(sample, judged, replace(pace, radius_scale=factor))
        if best is None or marched.nats < best.nats - CLEARLY:
            best = marched
        if factors is None and len(sample.points) > THOROUGH and left < DOUBT:
            break
    assert best is not None  # noqa: S101 - there is always a first factor
    return best


def _once(sample: Sample, judged: Sample, pace: Pace) -> tuple[Marched, float]:
    fragments, passed = march_all(sample.many, pace)
    fragments = prune_fragments(sample, fragments, pace.scale.sigma)
    fragments = without_blobs(sample, fragments, pace.scale.sigma, pace.flat)
    curves = join_fragments(sample, fragments)
    smooth: tuple[Polyline, ...] = ()
    if curves:
        smooth = refine_curves(judged, curves, pace.scale.sigma, pace.flat, passes=2, corners=False).curves
    kept, nats = _without_strays(judged, smooth, pace)
    return Marched([curves[k] for k in kept], fragments, nats), 1.0 - float(passed.mean())


def _without_strays(judged: Sample, smooth: Sequence[Polyline], pace: Pace) -> tuple[list[int], float]:
    """Drop thin curves that are told more briefly as outliers; which are left, and how briefly they tell."""
    points, sigma = judged.points, pace.scale.sigma

    def told(kept: list[int]) -> float:
        return description_length(points, [smooth[k] for k in kept], sigma, pace.extent, pace.flat)

    kept = list(range(len(smooth)))
    nats = told(kept)
    if len(smooth) < 2:
        return kept, nats
    feet = project(points, smooth, HALF_WIDTH * sigma)
    density = np.bincount(feet.curve[feet.curve >= 0], minlength=len(smooth)) / [x.length for x in smooth]
    thin = density < THIN * density.max()
    for k in np.argsort(density, kind="stable")[: min(int(thin.sum()), MOST_STRAYS)].tolist():
        rest = [i for i in kept if i != k]
        without = told(rest)
        if without < nats:
            kept, nats = rest, without
    return kept, nats
