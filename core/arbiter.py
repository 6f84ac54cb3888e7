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

from core.candidates import Candidate, by_march, by_neighbours, by_tape, crossings_read
from core.cloud.points import LARGEST
from core.cloud.sampling import spread_subsample
from core.diagnosis.gaps import longest_gap
from core.parameters import ReconstructParameters
from core.prepared import Prepared
from core.refine.crossings import crossings
from core.refine.evidence import bending, description_length
from core.results import Evidence
from core.solved import Solved

__all__ = ["Weighed", "arbitrated", "overall", "weighed"]

Method = Literal["pca", "skeleton"]

JUDGED = 10_000  # samples by which candidates are compared
NAMES = {"pca": "the PCA march", "skeleton": "the skeleton"}
EVEN = 10.0  # nats that hardly tell one from the other


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


def arbitrated(one: Prepared, parameters: ReconstructParameters) -> Solved | None:
    """Reconstruct one component by the method that it calls for; None where nothing lines up.

    Parameters
    ----------
    one : Prepared
    parameters : ReconstructParameters
    """
    found = weighed(one, parameters)
    if not found:
        return None
    best = found[0]
    read = crossings_read(one, best.candidate, parameters.crossings)
    evidence = tuple(_evidence(one, each, found) for each in found)
    return replace(read.solved(one), method=best.method, evidence=evidence)


def weighed(one: Prepared, parameters: ReconstructParameters) -> list[Weighed]:
    """Run the methods that a component calls for, and weigh what they find; the better one first.

    Parameters
    ----------
    one : Prepared
    parameters : ReconstructParameters
    """
    found: list[tuple[Method, Candidate | None]] = []
    if parameters.method != "skeleton" or not one.frame.flat:
        found.append(("pca", by_march(one, parameters)))
    if parameters.method != "pca" and one.frame.flat:
        found.append(("skeleton", by_tape(one, parameters)))
    if all(each is None or each.leaves_too_many for _, each in found):
        found.append(("pca", by_neighbours(one)))
    judged = [_weighed(one, method, each) for method, each in found if each is not None]
    return sorted(judged, key=lambda each: each.nats)


def _weighed(one: Prepared, method: Method, candidate: Candidate) -> Weighed:
    refined = candidate.refined
    judged = one.sample.few[spread_subsample(one.sample.few, JUDGED)]
    nats = description_length(judged, refined.curves, refined.sigma, one.extent, one.frame.flat)
    if one.scale is not None:
        nats += bending(refined.curves, refined.sigma, one.scale.curvature)
    met = len(crossings(refined.curves)) if one.frame.flat else 0
    return Weighed(method, candidate, nats, met, _largest_gap(candidate))


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
        reason=_why(each, found),
        curves=closed + opened,
        closed=closed,
        crossings=met,
        sigma=min(refined.sigma * one.frame.scale, LARGEST),
        explained=each.candidate.explained,
        largest_gap=each.largest_gap,
        nats=each.nats - found[0].nats,
    )


def _why(each: Weighed, found: Sequence[Weighed]) -> str:
    """Say why a candidate was chosen, or was not."""
    best = found[0]
    if len(found) == 1:
        return f"Only {NAMES[each.method]} finds curves here."
    rival = found[1] if each is best else each
    ahead = f"{rival.nats - best.nats:.0f} nats"
    if rival.shape == best.shape:
        return (
            f"Both methods find {_told(best)}; {NAMES[best.method]} describes the samples better by {ahead}."
        )
    return (
        f"{NAMES[best.method].capitalize()} finds {_told(best)} and describes the samples better by {ahead} "
        f"than {NAMES[rival.method]}, which finds {_told(rival)}."
    )


def _told(each: Weighed) -> str:
    """Describe the shape of a result in words."""
    closed, opened, met = each.shape
    words = [f"{count} {kind}" for count, kind in ((closed, "closed"), (opened, "open")) if count]
    curves = "curve" if closed + opened == 1 else "curves"
    return f"{' and '.join(words)} {curves} with {met} crossing{'' if met == 1 else 's'}"


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
    told = f"{most.evidence[0].reason[:-1]} (component {most.component.label}, the largest"
    return method, f"{told}; {count} of {len(solved)} components are by {NAMES[method]})."
