"""Stacks of slices, whose contours are sought group by group: here and at once, or in parts anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.division import Part, balanced
from core.progress import Progress, tell, within
from core.surface.axis import AxisFrame, axis_frame
from core.surface.contours import consistent
from core.surface.draft import Draft, is_clean
from core.surface.drafts import GROUP, drafts_of
from core.surface.guided import guided
from core.surface.parameters import ContourParameters
from core.surface.results import ContourLevel, Slice

__all__ = ["Drafts", "Levels", "Shown", "contour_levels", "parts_of", "solve"]

Floats = NDArray[np.float64]

Drafts = tuple[tuple[int, Draft], ...]
"""Contours of some levels, each with its place in the stack."""

Shown = tuple[tuple[Floats, ...], ...]
"""About where the contours of each level run, as (M, 2) arrays."""

BASE = 3000.0  # samples that take as long as what every level takes
CLEAN = 50.0  # what a level of closed polylines takes, or one that is guided, in samples
PROBED = 8  # guided levels that tell how many of them are not borne out
DRAFTED = 0.9  # fraction of the work after which every level has been looked at alone


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Consecutive slices whose contours are sought together.

    Attributes
    ----------
    first : int
        The place of the first one.
    slices : tuple of Slice
    shown : tuple of tuples of (M, 2) arrays, or None
        About where contours run, for each slice.
    """

    first: int
    slices: tuple[Slice, ...]
    shown: Shown | None

    def work(self, alone: float) -> float:
        """What it costs, in samples, when a share ``alone`` of the slices must be looked at alone."""
        return sum(_work(one, alone) for one in self.slices)


@dataclass(frozen=True, slots=True, eq=False)
class Levels(Part):
    """Groups of slices of a stack of ``count``."""

    axis: tuple[float, float, float]
    groups: tuple[Group, ...]
    count: int


def contour_levels(
    slices: Sequence[Slice],
    parameters: ContourParameters,
    shown: Shown | None = None,
    progress: Progress | None = None,
    drafts: Sequence[Drafts] | None = None,
) -> tuple[ContourLevel, ...]:
    """Return the contours of slices, consistent with each other.

    Parameters
    ----------
    slices : sequence of Slice
        By height.
    parameters : ContourParameters
    progress : Progress, optional
    drafts : sequence of Drafts, optional
        What has been found elsewhere, each level once, in any order; sought here by default.
    """
    start = 0.0
    if drafts is None:
        start = DRAFTED
        told = within(progress, 0.0, start)
        drafts = [tuple(_drafted(_groups(slices, shown), len(slices), parameters, told))]
    together = sorted((one for part in drafts for one in part), key=lambda one: one[0])
    found = [draft for _, draft in together]
    return consistent(slices, found, parameters, shown=shown, progress=within(progress, start, 1.0))


def parts_of(
    slices: Sequence[Slice], parameters: ContourParameters, shown: Shown | None = None
) -> tuple[Levels, ...]:
    """Gather levels into parts that take about as long as one another; none where it is not worth it."""
    groups = _groups(slices, shown)
    alone = _alone(slices, shown, axis_frame(parameters.axis))
    work = [one.work(alone) for one in groups]
    return tuple(
        Levels(
            name=_named([groups[k] for k in part], len(slices)),
            work=sum(work[k] for k in part),
            axis=parameters.axis,
            groups=tuple(groups[k] for k in part),
            count=len(slices),
        )
        for part in balanced(work)
    )


def solve(part: Levels, progress: Progress | None) -> Drafts:
    """Find the contours of some levels, group by group."""
    solved = tuple(_drafted(part.groups, part.count, ContourParameters(axis=part.axis), progress))
    tell(progress, 1.0, "done")
    return solved


def _groups(slices: Sequence[Slice], shown: Shown | None) -> list[Group]:
    """Cut a stack into groups, which are the same whoever solves them."""
    spans = [slice(first, first + GROUP) for first in range(0, len(slices), GROUP)]
    return [Group(one.start, tuple(slices[one]), shown and shown[one]) for one in spans]


def _alone(slices: Sequence[Slice], shown: Shown | None, frame: AxisFrame) -> float:
    """Return the share of slices that must be looked at alone, as a few of them tell."""
    if shown is None:
        return 1.0
    some = range(0, len(slices), max(len(slices) // PROBED, 1))
    return sum(guided(slices[k], frame, shown[k]) is None for k in some) / len(some)


def _drafted(
    groups: Sequence[Group], count: int, parameters: ContourParameters, progress: Progress | None
) -> Iterator[tuple[int, Draft]]:
    """Find the contours of groups one after the other."""
    frame = axis_frame(parameters.axis)
    shares = np.cumsum([0.0, *(one.work(1.0) for one in groups)]).tolist()
    for k, one in enumerate(groups):
        own = within(progress, shares[k] / shares[-1], shares[k + 1] / shares[-1])
        yield from enumerate(
            drafts_of(one.slices, frame, one.shown, progress=_worded(own, one, count)), one.first
        )


def _worded(progress: Progress | None, group: Group, count: int) -> Progress | None:
    """Tell which slice of the stack is worked on, by the fraction of a group that is done."""
    if progress is None:
        return None

    def told(fraction: float, _: str) -> None:
        done = min(round(fraction * len(group.slices)), len(group.slices) - 1)
        progress(fraction, f"slice {group.first + done + 1} of {count}")

    return told


def _work(one: Slice, alone: float) -> float:
    """What finding the contours of a slice costs, in samples."""
    clean = not len(one.points) or is_clean(one)
    return CLEAN if clean else CLEAN + alone * (BASE + len(one.points))


def _named(groups: Sequence[Group], count: int) -> str:
    spans = [f"{one.first + 1} to {one.first + len(one.slices)}" for one in groups]
    return f"slices {' and '.join(spans)} of {count}"
