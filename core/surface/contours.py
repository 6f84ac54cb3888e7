"""Slices to contours, level by level, then made consistent along the axis (§5.1.1, step iii).

The first part (:func:`core.surface.drafts.drafts_of`) looks at a few consecutive slices alone, so that many
can be worked on at once; the second one (:func:`consistent`) lets levels whose contours differ from
both neighbours' in number or noise ask another method, and completes levels that were not seen whole,
or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.progress import Progress, tell
from core.results import Curve, Warn
from core.surface.axis import AxisFrame, axis_frame
from core.surface.completion import completed_loops
from core.surface.draft import CLEAN, METHODS, STRAY, Draft, attempt
from core.surface.evidence import explained
from core.surface.interpolated import steps_of
from core.surface.parameters import ContourParameters
from core.surface.results import ContourLevel, Slice
from core.surface.specks import without_specks

__all__ = ["consistent"]

Floats = NDArray[np.float64]

_NOISIER = 1.5  # times the noise of both neighbours: the contours may be wrong
_NEAR = 6.0  # standard deviations within which samples count as a contour's own
_MISSING = 3  # levels without samples in a row; more of them are empty space
_BESIDE = 2  # complete levels on each side that a level is completed from
_SOURCES = ("its neighbours", "what all scans show")


def consistent(
    slices: Sequence[Slice],
    drafts: Sequence[Draft],
    parameters: ContourParameters | None = None,
    *,
    shown: Sequence[Sequence[Floats] | None] | None = None,
    progress: Progress | None = None,
) -> tuple[ContourLevel, ...]:
    """Make contours that were found slice by slice consistent with each other.

    Parameters
    ----------
    slices : sequence of Slice
    drafts : sequence of Draft
        What each slice says by itself, in the same order.
    parameters : ContourParameters, optional
    shown : sequence of sequences of (M, 2) arrays, optional
        For each slice closed first guesses of its contours, in the plane, or None. Levels that were not
        seen whole are completed by them where neighbours do not tell enough: in runs of more than
        three such levels, at the ends of the stack, and where the neighbours' contours differ in number.
    progress : Progress, optional
        Told how far it has come.

    Returns
    -------
    tuple of ContourLevel
        By height; curves lie in place, with (M, 3) vertices. What is left open or was completed is told
        in each level's ``warnings``.
    """
    parameters = parameters or ContourParameters()
    frame = axis_frame(parameters.axis)
    order = sorted(range(len(slices)), key=lambda k: slices[k].height)
    stack, told = [slices[k] for k in order], [drafts[k] for k in order]
    told = [_reconsidered(k, stack, told, frame) for k in range(len(told))]
    guesses = [shown[k] if shown else None for k in order]
    levels = dict.fromkeys(range(len(stack)), ContourLevel(0.0, ()))
    for done, k in enumerate(_inside_out(told)):
        tell(progress, done / len(stack), "completing levels")
        levels[k], told[k] = _level(stack[k], k, told, frame, parameters.complete, guesses[k])
    tell(progress, 1.0, "done")
    return without_specks(list(levels.values()), frame)


def _inside_out(drafts: Sequence[Draft]) -> list[int]:
    """Return the order in which levels are completed: from complete ones outward at both ends."""
    whole = [k for k, one in enumerate(drafts) if one.complete]
    first, last = (whole[0], whole[-1]) if whole else (0, len(drafts) - 1)
    return [*range(first, last + 1), *range(first - 1, -1, -1), *range(last + 1, len(drafts))]


def _reconsidered(k: int, slices: Sequence[Slice], drafts: Sequence[Draft], frame: AxisFrame) -> Draft:
    """Let a level that differs from both neighbours, which agree, ask another method."""
    one = drafts[k]
    if not 0 < k < len(drafts) - 1 or not one.complete or one.method == CLEAN:
        return one  # of an incomplete level every method has been asked
    below, above = drafts[k - 1], drafts[k + 1]
    if not (below.complete and above.complete) or len(below.loops) != len(above.loops):
        return one
    wanted, sigma = len(below.loops), max(below.sigma, above.sigma)
    if len(one.loops) == wanted and one.sigma <= _NOISIER * sigma:
        return one
    tried = [attempt(slices[k], frame, method) for method in METHODS if method != one.method]
    others = [other for other in tried if other is not None and other.complete]
    return min(
        [one, *others], key=lambda each: (not each.complete, abs(len(each.loops) - wanted), each.sigma)
    )


def _level(
    slice_: Slice,
    k: int,
    drafts: Sequence[Draft],
    frame: AxisFrame,
    complete: bool,
    shown: Sequence[Floats] | None,
) -> tuple[ContourLevel, Draft]:
    """Return the contours of a level, completed where they have to be and can be, and what others may use."""
    draft, points = drafts[k], frame.to_plane(slice_.points)
    shown = shown if draft.samples or _is_within(k, drafts) else None
    if draft.complete or not (draft.samples or shown or _is_missing(k, drafts)):
        return ContourLevel(
            draft.height, tuple(_placed(one, draft.height, frame) for one in draft.loops)
        ), draft
    loops, source = _completed(k, drafts, points, shown) if complete else ([], "")
    if not loops:
        return _incomplete(draft, frame), draft
    curves = _curves(loops, points, max(draft.sigma, draft.spacing))
    message = f"The level at height {draft.height:.6g} was completed from {source}: {_lack(draft)}."
    placed = tuple(_placed(one, draft.height, frame) for one in curves)
    level = ContourLevel(draft.height, placed, True, (Warn("completed-level", message),))
    inside = _nearest(drafts, k, -1) and _nearest(drafts, k, 1)
    return level, draft if inside else replace(draft, loops=tuple(curves), loose=(), complete=True)


def _completed(
    k: int, drafts: Sequence[Draft], points: Floats, shown: Sequence[Floats] | None
) -> tuple[list[Floats], str]:
    """Return the completed contours of a level, and in words what completed them.

    Near neighbours on both sides with as many contours know best; elsewhere what is shown does, if anything
    is. The other guide is asked where that leaves samples over, and taken where it leaves fewer.
    """
    one = drafts[k]
    ways = [_by_neighbours, _by_shown] if _is_bridged(k, drafts) else [_by_shown, _by_neighbours]
    best, source, least = list[Floats](), "", np.inf
    for way in ways if shown else [_by_neighbours]:
        loops = way(k, drafts, points, shown or ())
        left = 1.0 - explained(loops, one, points) if loops else np.inf
        if left < least - STRAY:
            best, source, least = loops, _SOURCES[way is _by_shown], left
        if least <= STRAY:
            break
    return best, source


def _by_neighbours(k: int, drafts: Sequence[Draft], points: Floats, _shown: Sequence[Floats]) -> list[Floats]:
    """Complete a level by the nearest complete ones; by one alone only if that is the next."""
    below, above = _nearest(drafts, k, -1), _nearest(drafts, k, 1)
    beside = any(drafts[place].complete for place in (k - 1, k + 1) if 0 <= place < len(drafts))
    return completed_loops(drafts[k], points, below, above) if beside or (below and above) else []


def _by_shown(k: int, drafts: Sequence[Draft], points: Floats, shown: Sequence[Floats]) -> list[Floats]:
    """Complete a level by what is shown; near neighbours may know of more."""
    below, above = (_nearest(drafts, k, step, _MISSING) for step in (-1, 1))
    return completed_loops(drafts[k], points, below, above, shown)


def _is_bridged(k: int, drafts: Sequence[Draft]) -> bool:
    """Tell whether complete levels with as many contours lie near a level on both sides."""
    below, above = _nearest(drafts, k, -1), _nearest(drafts, k, 1)
    alike = below and above and len(below[0].loops) == len(above[0].loops)
    return bool(alike and _run(k, drafts) <= _MISSING)


def _is_within(k: int, drafts: Sequence[Draft]) -> bool:
    """Tell whether levels on both sides have samples."""
    return any(one.samples for one in drafts[:k]) and any(one.samples for one in drafts[k + 1 :])


def _run(k: int, drafts: Sequence[Draft]) -> int:
    """Return how many levels in a row are not complete, of which a level is one."""
    low, high = k, k
    while low > 0 and not drafts[low - 1].complete:
        low -= 1
    while high < len(drafts) - 1 and not drafts[high + 1].complete:
        high += 1
    return high - low + 1


def _is_missing(k: int, drafts: Sequence[Draft]) -> bool:
    """Tell whether a level without samples lies in a short run of such between levels that have some."""
    low, high = k, k
    while low >= 0 and not drafts[low].samples and k - low <= _MISSING:
        low -= 1
    while high < len(drafts) and not drafts[high].samples and high - k <= _MISSING:
        high += 1
    return low >= 0 and high < len(drafts) and high - low - 1 <= _MISSING


def _nearest(drafts: Sequence[Draft], k: int, step: int, reach: int | None = None) -> list[Draft]:
    """Return the nearest complete levels on one side, the first of them at most so many levels off."""
    side = drafts[k + 1 :] if step > 0 else drafts[:k][::-1]
    whole = [place for place, one in enumerate(side) if one.complete][:_BESIDE]
    far = not whole or (reach is not None and whole[0] >= reach)
    return [] if far else [side[place] for place in whole]


def _incomplete(draft: Draft, frame: AxisFrame) -> ContourLevel:
    """Return a level as it is, with a warning."""
    curves = tuple(_placed(one, draft.height, frame) for one in (*draft.loops, *draft.loose))
    message = f"The level at height {draft.height:.6g} is incomplete: {_lack(draft)}."
    return ContourLevel(draft.height, curves, False, (Warn("incomplete-level", message),))


def _lack(draft: Draft) -> str:
    """Return in words what a level lacks."""
    if not draft.samples:
        return "it has no samples"
    if draft.loose or not draft.loops:
        return "its samples do not close"
    return f"a stretch of {draft.gap:.0f} mean distances between samples has none, or samples are left over"


def _curves(loops: Sequence[Floats], points: Floats, unit: float) -> list[Curve]:
    """Return closed curves with what is known of their samples."""
    distance = np.array([cKDTree(one).query(points)[0] for one in loops]).reshape(len(loops), len(points))
    nearest = distance.argmin(axis=0)
    curves = []
    for k, one in enumerate(loops):
        own = distance[k][(nearest == k) & (distance[k] <= _NEAR * unit)]
        length = float(steps_of(one).sum())
        rms = float(np.sqrt(np.mean(own**2))) if len(own) else 0.0
        curves.append(Curve(one, True, k, length, len(own), rms))
    return curves


def _placed(curve: Curve, height: float, frame: AxisFrame) -> Curve:
    """Return a curve of the plane in space."""
    return Curve(
        frame.lift(curve.vertices, height),
        curve.closed,
        curve.component,
        curve.length,
        curve.samples,
        curve.rms_residual,
        curve.standard_errors,
    )
