"""Which method's curves a component gets: the one that explains its samples better.

Marches and tapes fail in different places: a march keeps branches apart that share one tape, and
needs fewer samples; a tape passes corners, crossings and uneven density. Both are run and refined
alike, and weighed on the same samples: description length (how far the samples lie, what stretches
of curve lack samples, what curves and ends cost) and bending.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.candidates import Candidate, by_march, by_neighbours, by_tape, crossings_read, hairpins_cut
from core.cloud.points import LARGEST
from core.cloud.sampling import spread_subsample
from core.diagnosis.gaps import longest_gap
from core.parameters import ReconstructParameters
from core.prepared import Prepared
from core.progress import Progress, tell, within
from core.refine.crossings import crossings
from core.refine.evidence import bending, description_length, typical_curvature
from core.results import Evidence
from core.solved import Solved

__all__ = ["Weighed", "arbitrated", "overall", "weighed"]

Method = Literal["pca", "skeleton"]
Floats = NDArray[np.float64]

JUDGED = 10_000  # samples by which candidates are compared
NAMES = {"pca": "the PCA march", "skeleton": "the skeleton"}
COST_OF_CURVE = 0.5  # in units of ln N
COST_OF_END = 1.5  # two of them cost more than the largest gap of N independent samples, about ln N + 5
BENDING = 4.0  # on its nats: wiggles and tangles follow single samples
GENTLE = 0.5  # of what a circle about the samples has: nothing is taken for straighter
NOISY = 1.3  # times the noise in local balls: branches may have come out as one
EXPLAINED = 0.95  # share of the samples
ALIKE = 5.0  # nats that make no difference
SAFE = 9.0  # added to ln N: gaps of as many mean distances are no chance
FACTORS = (0.6, 0.85)  # on the march's radii, in doubt
FIRST, AGAIN = 0.45, 0.9  # fractions of the work after which first candidates, and more of them, are there
MARCHED = 0.4  # fraction of it that is the march's
LEVELS = (0.8, 0.6, 0.45)  # of the tape's scale, in doubt


@dataclass(frozen=True, slots=True, eq=False)
class Weighed:
    """A candidate with its evidence.

    Attributes
    ----------
    method : {"pca", "skeleton"}
    candidate : Candidate
    nats : float
        Length of the description of the samples by its curves; less is better.
    crossings : int
    largest_gap : float
        Longest stretch of curve without a sample, in mean distances between samples.
    """

    method: Method
    candidate: Candidate
    nats: float
    crossings: int
    largest_gap: float

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of closed curves, of open ones, and of crossings."""
        closed = sum(line.closed for line in self.candidate.refined.curves)
        return closed, len(self.candidate.refined.curves) - closed, self.crossings


def arbitrated(
    one: Prepared, parameters: ReconstructParameters, progress: Progress | None = None
) -> Solved | None:
    """Reconstruct one component by the method that it calls for; None where nothing lines up.

    Parameters
    ----------
    one : Prepared
    parameters : ReconstructParameters
    progress : Progress, optional
    """
    found = weighed(one, parameters, progress)
    if not found:
        return None
    best = found[0]
    read = crossings_read(one, best.candidate, parameters.crossings)
    evidence = tuple(_evidence(one, each, found) for each in found)
    return replace(read.solved(one), method=best.method, evidence=evidence)


def weighed(
    one: Prepared, parameters: ReconstructParameters, progress: Progress | None = None
) -> list[Weighed]:
    """Run the methods that a component calls for, and weigh what they find; the better one first.

    Where the methods find curves of different shape, or what they find alike is doubtful, both are tried
    at more scales: a right answer is mostly among them, and the samples show it.

    Parameters
    ----------
    one : Prepared
    parameters : ReconstructParameters
    progress : Progress, optional
    """
    found = _run(one, parameters, None, None, within(progress, 0.0, FIRST))
    tell(progress, FIRST, "weighing the candidates")
    weighed = _weighed(one, found)
    if _is_doubtful(one, weighed):
        found += _run(one, parameters, FACTORS, LEVELS, within(progress, FIRST, AGAIN, "in doubt, "))
        tell(progress, AGAIN, "weighing more candidates")
        weighed = _weighed(one, found)
    cut = [_found(one, each.method, other) for each in weighed for other in hairpins_cut(one, each.candidate)]
    if cut:
        found += cut
        weighed = _weighed(one, found)
    if all(each.candidate.leaves_too_many for each in weighed):
        linked = by_neighbours(one)
        if linked is not None:
            weighed = _weighed(one, [*found, _found(one, "pca", linked)])
    best = {each.method: each for each in reversed(weighed)}
    return sorted(best.values(), key=lambda each: each.nats)


def _run(
    one: Prepared,
    parameters: ReconstructParameters,
    factors: Sequence[float] | None,
    levels: Sequence[float] | None,
    progress: Progress | None,
) -> list[Weighed]:
    """Each method's curves, where it finds any, yet to be weighed."""
    found: list[tuple[Method, Candidate | None]] = []
    if parameters.method != "skeleton" or not one.frame.flat:
        found.append(("pca", by_march(one, parameters, factors, within(progress, 0.0, MARCHED))))
    if parameters.method != "pca" and one.frame.flat:
        found.append(("skeleton", by_tape(one, parameters, levels, within(progress, MARCHED, 1.0))))
    return [_found(one, method, each) for method, each in found if each is not None]


def _found(one: Prepared, method: Method, candidate: Candidate) -> Weighed:
    """What a candidate shows by itself; its nats depend on the others too."""
    met = len(crossings(candidate.refined.curves)) if one.frame.flat else 0
    return Weighed(method, candidate, np.inf, met, _largest_gap(candidate))


def _is_doubtful(one: Prepared, found: Sequence[Weighed]) -> bool:
    """Whether methods disagree, or the better one leaves more noise than local balls do, or a gap."""
    if one.scale is None or not found:
        return False
    best = found[0]
    return (
        len({each.shape for each in found}) > 1
        or best.candidate.refined.sigma > NOISY * one.scale.sigma
        or best.candidate.explained < EXPLAINED
        or best.largest_gap > float(np.log(len(one.sample.points))) + SAFE
    )


def _weighed(one: Prepared, found: Sequence[Weighed]) -> list[Weighed]:
    """Weigh candidates on the same samples, those of clumps of outliers left out; the best one first."""
    few = one.sample.few
    judged = few[spread_subsample(few, JUDGED)]
    for clump in (clump for each in found for clump in each.candidate.clumps):
        judged = judged[np.linalg.norm(judged - clump.centre, axis=1) > clump.radius]
    curvature = _typical_curvature(one, [each.candidate for each in found])
    weighed = [replace(each, nats=_nats(one, each.candidate, judged, curvature)) for each in found]
    return sorted(weighed, key=lambda each: each.nats)


def _typical_curvature(one: Prepared, candidates: Sequence[Candidate]) -> float:
    """Curvature of the smoothest candidate; local balls that meet a second branch have it too large."""
    found = [typical_curvature(each.refined.curves, each.refined.sigma) for each in candidates]
    smoothest = max(min(found, default=0.0), GENTLE / max(one.extent, 1e-300))
    return smoothest if one.scale is None else min(smoothest, one.scale.curvature)


def _nats(one: Prepared, candidate: Candidate, judged: Floats, curvature: float) -> float:
    """Length of the description of the judged samples by a candidate's curves."""
    refined = candidate.refined
    lines = refined.curves
    nats = description_length(
        judged, lines, refined.sigma, one.extent, one.frame.flat, whole=True, uneven=True
    )
    ends = sum(2 for line in lines if not line.closed)
    nats += (COST_OF_CURVE * len(lines) + COST_OF_END * ends) * float(np.log(len(judged) + 1.0))
    return nats + BENDING * bending(lines, refined.sigma, curvature)


def _largest_gap(candidate: Candidate) -> float:
    """Longest stretch of curve without a sample, in mean distances between samples."""
    feet, lines = candidate.refined.feet, candidate.refined.curves
    spacings = [0.0]
    for k, line in enumerate(lines):
        station = feet.station[feet.curve == k]
        spacings.append(longest_gap(line, station)[1] * len(station) / max(line.length, 1e-300))
    return max(spacings)


def _evidence(one: Prepared, each: Weighed, found: Sequence[Weighed]) -> Evidence:
    closed, opened, met = each.shape
    refined = each.candidate.refined
    return Evidence(
        component=one.component.label,
        method=each.method,
        reason=_why(one, each, found),
        curves=closed + opened,
        closed=closed,
        crossings=met,
        sigma=min(refined.sigma * one.frame.scale, LARGEST),
        explained=each.candidate.explained,
        largest_gap=each.largest_gap,
        nats=each.nats - found[0].nats,
    )


def _why(one: Prepared, each: Weighed, found: Sequence[Weighed]) -> str:
    """Say why a candidate was chosen, or was not."""
    best = found[0]
    if len(found) == 1:
        return _only(one, each.method)
    rival = found[1] if each is best else each
    ahead = f"{rival.nats - best.nats:.0f} nats"
    if rival.shape == best.shape and rival.nats - best.nats < ALIKE:
        return (
            f"Both methods find {_told(best)} and describe the samples alike; those of {NAMES[best.method]} "
            "are given."
        )
    if rival.shape == best.shape:
        return (
            f"Both methods find {_told(best)}; {NAMES[best.method]} describes the samples better by {ahead}."
        )
    return (
        f"{_begun(NAMES[best.method])} finds {_told(best)} and describes the samples better by {ahead} "
        f"than {NAMES[rival.method]}, which finds {_told(rival)}."
    )


def _only(one: Prepared, method: Method) -> str:
    """Say why there is but one candidate."""
    asked = getattr(one.parameters, "method", "auto")
    if asked == method:
        return f"{_begun(NAMES[method])} was asked for."
    if not one.frame.flat:
        return "The samples are worked on in space, where only the PCA march works."
    return f"Only {NAMES[method]} finds curves here."


def _begun(words: str) -> str:
    """Words at the beginning of a sentence."""
    return words[0].upper() + words[1:]


def _lowered(sentence: str) -> str:
    """A sentence to go on with after a colon; names in capitals stay."""
    return sentence[0].lower() + sentence[1:]


def _told(each: Weighed) -> str:
    """Describe the shape of a result in words."""
    closed, opened, met = each.shape
    words = [f"{count} {kind}" for count, kind in ((closed, "closed"), (opened, "open")) if count]
    curves = "curve" if closed + opened == 1 else "curves"
    crossed = f"with {met} crossing{'' if met == 1 else 's'}" if met else "without crossings"
    return f"{' and '.join(words)} {curves} {crossed}"


def overall(solved: Sequence[Solved]) -> tuple[Method, str]:
    """Name the method of most samples, and say in one sentence why.

    Parameters
    ----------
    solved : sequence of Solved
    """
    most = max(solved, key=lambda one: len(one.members))
    method: Method = most.method or "pca"
    if len(solved) == 1:
        return method, most.evidence[0].reason
    count = sum(one.method == method for one in solved)
    number = f"all {count}" if count == len(solved) else f"{count} of {len(solved)}"
    told = f"{number} components are by {NAMES[method]}"
    return method, f"In the largest of the components: {_lowered(most.evidence[0].reason[:-1])}; {told}."
