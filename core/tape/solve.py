"""The skeleton method on one component in working coordinates: tape, axis, graph, curves (§4.4, 4.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import CANDIDATES, Sample, Scale, spread_subsample
from core.refine.evidence import bending, description_length
from core.refine.polyline import Polyline
from core.refine.project import project
from core.tape.graph import Graph
from core.tape.junction import merged
from core.tape.loose_ends import joined
from core.tape.outermost import begun_outermost, smoothed
from core.tape.reconnection import reconnected
from core.tape.skeleton import Skeleton, skeleton_of
from core.tape.small_triangles import CLEAN, Smallness
from core.tape.tape import Tape, approximate_tape
from core.tape.trace import straight_through

__all__ = ["CLEARLY", "Choices", "Taped", "has_no_width", "solve_tape"]

Floats = NDArray[np.float64]

JUDGED = 5000  # samples for first refinements and for comparing hypotheses
PRUNE = 2.0  # reach of a true leaf beyond its fork's disc, in its radii
LEVELS = (1.0, 0.6, 0.3)  # factors on the tape's scale: a wide tape may hide branches; narrower ones in doubt
SURE = 0.6  # share of balls that met curvature
DOUBT = 0.03  # share of samples left over
HOPELESS = 0.2  # nats a sample by which a tape is too bad to be worth reconnecting
CLEARLY = 10.0  # nats by which a later tape must be better
NEAR = 3.0  # in sigma: samples of an edge
CLEAN_CHORD = 0.25  # of the noise that makes no difference to a tape: none to a chord between samples
SPECK = 40  # samples from which on a curve is no chance alignment of outliers
MOST_SPECKS = 30  # looked at
LEAST_LENGTH = 3.0  # in sigma: shorter curves are specks


@dataclass(frozen=True, slots=True)
class Choices:
    """What an expert has fixed, lengths in working units; None follows from the data."""

    smallness: Smallness = field(default_factory=Smallness)
    resample: float | None = None
    prune: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Taped:
    """A tape, its skeleton, and the curves read from it.

    Attributes
    ----------
    tape : Tape
    skeleton : Skeleton
    graph : Graph
        The skeleton's, with one node for each crossing.
    curves : list of Polyline
        Straight through crossings, before refinement.
    sigma : float
        Noise about them.
    nats : float
        Their description length.
    explained : float
        Share of the samples near them.
    doubts : (K, 3) array
        Places where the samples do not tell whether branches cross or touch.
    """

    tape: Tape
    skeleton: Skeleton
    graph: Graph
    curves: list[Polyline]
    sigma: float
    nats: float
    explained: float
    doubts: Floats


def solve_tape(
    sample: Sample, scale: Scale, extent: float, choices: Choices, levels: Sequence[float] | None = None
) -> Taped | None:
    """Build tapes at several scales and keep the one whose curves explain the samples best.

    Parameters
    ----------
    sample : Sample
        In the plane z = 0.
    scale : Scale
    extent : float
        Radius of the samples.
    choices : Choices
    levels : sequence of float, optional
        Factors on the tape's scale, all of which are tried; by default those after the first only in doubt.

    Returns
    -------
    Taped or None
        None when the points are collinear, or when no tape has a skeleton.
    """
    best: Taped | None = None
    judged = Sample.of(sample.few[spread_subsample(sample.few, JUDGED)])
    # Most optimal balls meet curvature; where they do not they may span several branches.
    sure = bool(np.mean(scale.balls.interior[scale.balls.found]) > SURE) or choices.smallness.f_l is not None
    for level in LEVELS if levels is None else levels:
        scaled = replace(choices, smallness=replace(choices.smallness, level=level))
        hopeless = np.inf if best is None else best.nats + HOPELESS * len(judged.points)
        one = _once(sample, judged, scale, extent, scaled, hopeless)
        if one is not None and (best is None or one.nats < best.nats - CLEARLY):
            best = one
        if levels is None and (
            has_no_width(scale) or (sure and one is not None and one.explained > 1.0 - DOUBT)
        ):
            break
    return best


def has_no_width(scale: Scale) -> bool:
    """Whether the noise is so small beside the distance of samples that a tape is hardly one.

    Parameters
    ----------
    scale : Scale
    """
    return scale.sigma * scale.density < CLEAN


def _once(
    sample: Sample, judged: Sample, scale: Scale, extent: float, choices: Choices, hopeless: float = np.inf
) -> Taped | None:
    """One scale; None where there are no curves, or such that reconnections will not make good."""
    typical = max(scale.sigma, CLEAN / scale.density)
    sigma = typical * choices.smallness.level
    # Sorted: lines and rings then begin at the same places whatever the order of the samples.
    points = sample.many[np.lexsort((sample.many[:, 1], sample.many[:, 0])), :2]
    thinning = min(CANDIDATES / len(points), 1.0)
    tape = approximate_tape(points, scale.balls, thinning, typical, extent, choices.smallness)
    if tape is None or tape.polygon.is_empty:
        return None
    prune = PRUNE if choices.prune is None else choices.prune
    skeleton = skeleton_of(tape.polygon, prune, choices.resample)
    samples = _samples_along(sample, skeleton.graph, NEAR * sigma)
    curves = straight_through(skeleton.graph, samples)
    curves = [line for line in curves if line.length > LEAST_LENGTH * sigma]
    if not curves:
        return None
    radius = scale.radius * float(np.sqrt(choices.smallness.level))
    curves = _rejoined(sample, judged, curves, sigma, scale, radius)
    if description_length(judged.points, curves, sigma, extent, flat=True) > hopeless:
        return None
    curves, doubts = reconnected(sample, curves, sigma, scale, extent)
    if any(not line.closed for line in curves):  # crossings that come right may bring ends together
        curves = _rejoined(sample, judged, curves, sigma, scale, radius)
    curves = _without_specks(judged, curves, sigma, extent)
    smooth = smoothed(judged, curves, sigma)
    nats = description_length(judged.points, smooth.curves, smooth.sigma, extent, flat=True)
    return Taped(
        tape=tape,
        skeleton=skeleton,
        graph=merged(skeleton.graph, samples),
        curves=begun_outermost(judged, curves, sigma),
        sigma=smooth.sigma,
        nats=nats + bending(smooth.curves, smooth.sigma, scale.curvature),
        explained=float(np.mean(smooth.feet.curve >= 0)),
        doubts=doubts,
    )


def _without_specks(
    judged: Sample, curves: Sequence[Polyline], sigma: float, extent: float
) -> list[Polyline]:
    """Drop curves of a few samples that are told more briefly as outliers."""
    feet = project(judged.points, curves, NEAR * sigma)
    samples = np.bincount(feet.curve[feet.curve >= 0], minlength=len(curves))
    kept = list(range(len(curves)))
    nats = description_length(judged.points, curves, sigma, extent, flat=True)
    for k in np.argsort(samples, kind="stable")[:MOST_SPECKS].tolist():
        rest = [curves[i] for i in kept if i != k]
        if samples[k] >= SPECK or not rest:
            break
        without = description_length(judged.points, rest, sigma, extent, flat=True)
        if without < nats:
            kept.remove(k)
            nats = without
    return [curves[k] for k in kept]


def _rejoined(
    sample: Sample, judged: Sample, curves: Sequence[Polyline], sigma: float, scale: Scale, radius: float
) -> list[Polyline]:
    """Join loose ends, after a short refinement."""
    smooth = smoothed(judged, curves, sigma)
    share = len(judged.points) / len(sample.many)
    noise = max(smooth.sigma, CLEAN_CHORD * CLEAN / scale.density)
    return joined(sample, smooth.curves, smooth.feet, share, noise, radius)


def _samples_along(sample: Sample, graph: Graph, reach: float) -> Floats:
    """How many samples each edge of the graph has."""
    lines = [edge.line for edge in graph.edges]
    if not lines:
        return np.zeros(0)
    feet = project(sample.few, lines, reach)
    return np.bincount(feet.curve[feet.curve >= 0], minlength=len(lines)) / sample.thinning
