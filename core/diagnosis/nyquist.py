"""The paper's Nyquist condition (§1), checked on what was reconstructed.

A set is compliant when its noise is below half of its smallest detail, with a margin for the method:
branches at least 4.5 sigma apart, no turn that the curve passes by, and no stretch of curve without
samples that independent ones would not leave. Crossings, junctions and corners are no such details.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.diagnosis.across import Across
from core.diagnosis.branches import LEAST_GAP, branch_gaps
from core.diagnosis.gaps import Gap, widest_gap
from core.diagnosis.hidden import hidden_branches
from core.diagnosis.junctions import Junctions
from core.diagnosis.meetings import doubtful_meetings
from core.diagnosis.thin import thinnest
from core.diagnosis.turns import sharp_turns
from core.diagnosis.wording import Wording
from core.results import Violation
from core.solved import Solved

__all__ = ["Findings", "findings_of"]

Floats = NDArray[np.float64]

LEAST_NOISE = 0.05  # in mean distances between samples
LEAST_LENGTH = 1.0  # in sigma: noise fills shorter gaps, and only a grid leaves them empty


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """What was found about one component, in the user's frame and units.

    Attributes
    ----------
    violations : tuple of Violation
    margin : float or None
        Least distance between branches, in sigma.
    margin_location : (d,) array or None
    gap : (int, Gap) or None
        The widest gap between samples, in working units, and its curve.
    """

    violations: tuple[Violation, ...]
    margin: float | None = None
    margin_location: Floats | None = None
    gap: tuple[int, Gap] | None = None


def findings_of(one: Solved, samples: Sequence[Across], total: int) -> Findings:
    """Check one component.

    Parameters
    ----------
    one : Solved
    samples : sequence of Across
        Of each of its curves.
    total : int
        Number of samples of all components.
    """
    sigma = one.refined.sigma
    told = Wording(one.frame, sigma)
    violations: list[Violation] = []
    margin: float | None = None
    margin_place: Floats | None = None
    junctions = Junctions.of(one.refined.curves, sigma, one.frame.flat)
    for place, gap in branch_gaps(one.refined.curves, sigma):
        if junctions.explain(place, gap):
            continue
        if margin is None:
            margin, margin_place = gap / sigma, told.place(place)
        if gap < LEAST_GAP * sigma:
            violations.append(told.near(place, gap))
    coarse = any(across.coarse for across in samples)
    shows = _shows_noise(one, samples) and not coarse
    if shows:
        doubts = doubtful_meetings(one.points, one.refined.curves, sigma) if one.frame.flat else []
        violations += [told.crossed(doubt) for doubt in doubts]
        for across in samples:
            found = hidden_branches(across, len(across.stations) / max(total, 1))
            violations += [told.hidden(across, each) for each in found]
            violations += [told.turn(across, turn) for turn in sharp_turns(across)]
    widest: tuple[int, Gap] | None = None
    for k, across in enumerate(samples):
        gap_there = widest_gap(across.line, across.stations, total)
        if gap_there is None:
            continue
        if widest is None or gap_there.spacings > widest[1].spacings:
            widest = k, gap_there
        place = across.line.at(np.array([gap_there.middle]))[0]
        long = gap_there.spacings > gap_there.expected and not coarse
        long &= gap_there.length > LEAST_LENGTH * across.sigma
        if long and not junctions.is_near(place, 0.5 * gap_there.length):
            violations.append(told.bridged(across, gap_there))
            continue
        thin = thinnest(across, len(across.stations) / max(total, 1)) if shows else None
        if thin is not None:
            violations.append(told.thin(across, *thin))
    return Findings(tuple(violations), margin, margin_place, widest)


def _shows_noise(one: Solved, samples: Sequence[Across]) -> bool:
    """Whether residuals are noise rather than what a fit of samples without noise leaves."""
    count, length = sum(len(each.stations) for each in samples), sum(each.line.length for each in samples)
    return one.refined.sigma * count > LEAST_NOISE * length
