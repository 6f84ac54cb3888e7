"""Stacks of slices, whose contours are sought group by group: here and at once, or in parts anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from core.division import Part, balanced
from core.progress import Progress, tell, within
from core.surface.axis import axis_frame
from core.surface.contours import consistent
from core.surface.draft import Draft
from core.surface.drafts import GROUP, drafts_of
from core.surface.parameters import ContourParameters
from core.surface.results import ContourLevel, Slice

__all__ = ["Drafts", "Levels", "contour_levels", "parts_of", "solve"]

Drafts = tuple[tuple[int, Draft], ...]
"""Contours of some levels, each with its place in the stack."""

BASE = 3000.0  # samples that take as long as what every level takes
CLEAN = 100.0  # what a level of closed polylines takes, in samples
DRAFTED = 0.9  # fraction of the work after which every level has been looked at alone


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Consecutive slices whose contours are sought together; ``first`` is the place of the first one."""

    first: int
    slices: tuple[Slice, ...]

    @property
    def work(self) -> float:
        """What it costs, in samples."""
        return sum(_work(one) for one in self.slices)


@dataclass(frozen=True, slots=True, eq=False)
class Levels(Part):
    """Groups of slices of a stack of ``count``."""

    axis: tuple[float, float, float]
    groups: tuple[Group, ...]
    count: int


def contour_levels(
    slices: Sequence[Slice],
    parameters: ContourParameters,
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
        drafts = [tuple(_drafted(_groups(slices), len(slices), parameters, told))]
    together = sorted((one for part in drafts for one in part), key=lambda one: one[0])
    return consistent(
        slices, [draft for _, draft in together], parameters, progress=within(progress, start, 1.0)
    )


def parts_of(slices: Sequence[Slice], parameters: ContourParameters) -> tuple[Levels, ...]:
    """Gather levels into parts that take about as long as one another; none where it is not worth it."""
    groups = _groups(slices)
    work = [one.work for one in groups]
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


def _groups(slices: Sequence[Slice]) -> list[Group]:
    """Cut a stack into groups, which are the same whoever solves them."""
    return [Group(first, tuple(slices[first : first + GROUP])) for first in range(0, len(slices), GROUP)]


def _drafted(
    groups: Sequence[Group], count: int, parameters: ContourParameters, progress: Progress | None
) -> Iterator[tuple[int, Draft]]:
    """Find the contours of groups one after the other."""
    frame = axis_frame(parameters.axis)
    shares = np.cumsum([0.0, *(one.work for one in groups)]).tolist()
    for k, one in enumerate(groups):
        own = within(progress, shares[k] / shares[-1], shares[k + 1] / shares[-1])
        yield from enumerate(drafts_of(one.slices, frame, progress=_worded(own, one, count)), one.first)


def _worded(progress: Progress | None, group: Group, count: int) -> Progress | None:
    """Tell which slice of the stack is worked on, by the fraction of a group that is done."""
    if progress is None:
        return None

    def told(fraction: float, _: str) -> None:
        done = min(round(fraction * len(group.slices)), len(group.slices) - 1)
        progress(fraction, f"slice {group.first + done + 1} of {count}")

    return told


def _work(one: Slice) -> float:
    """What finding the contours of a slice costs, in samples."""
    clean = not len(one.points) or (one.polylines and all(one.closed))
    return CLEAN if clean else BASE + len(one.points)


def _named(groups: Sequence[Group], count: int) -> str:
    spans = [f"{one.first + 1} to {one.first + len(one.slices)}" for one in groups]
    return f"slices {' and '.join(spans)} of {count}"
