"""The contours of consecutive slices: a few found, those between them followed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from core.progress import Progress, tell
from core.surface.axis import AxisFrame
from core.surface.draft import METHODS, Draft, draft_of, is_clean
from core.surface.following import followed
from core.surface.grazing import is_grazing
from core.surface.guided import guided
from core.surface.results import Slice

__all__ = ["GROUP", "drafts_of"]

Floats = NDArray[np.float64]

GROUP = 17
"""Consecutive slices that are best worked on together."""

_CORNERS = 32  # of a first guess, at least
_STRIDE = 8  # slices from one that is found to the next; what lies between is halved again and again


def drafts_of(
    slices: Sequence[Slice],
    frame: AxisFrame,
    shown: Sequence[Sequence[Floats]] | None = None,
    *,
    progress: Progress | None = None,
) -> list[Draft]:
    """Reconstruct the contours of consecutive slices.

    Where all scans together show about where contours run, these are fitted to the slice's samples. Of
    the others every eighth one is reconstructed by itself, and the last one; each
    one between is followed from those nearest to it on both sides that were seen whole, or where these
    do not tell reconstructed as well, unless the plane runs along a face. What was reconstructed is then
    followed too, where it can be.

    Parameters
    ----------
    slices : sequence of Slice
        By height.
    frame : AxisFrame
        Of the axis across them.
    shown : sequence of sequences of (M, 2) arrays, optional
        First guesses of the contours of each slice, in the plane.
    progress : Progress, optional
        Told how far it has come.
    """
    known = _guided(slices, frame, shown) if shown is not None else {}
    for k in _order(len(slices)):
        tell(progress, len(known) / len(slices), "")
        known[k] = known.get(k) or _found(k, slices, known, frame)
    for k in range(1, len(slices) - 1):
        if known[k].complete and known[k].method in METHODS:  # its neighbours make a smoother first guess
            known[k] = followed(slices[k], frame, known[k - 1], known[k + 1]) or known[k]
    return [known[k] for k in range(len(slices))]


def _guided(slices: Sequence[Slice], frame: AxisFrame, shown: Sequence[Sequence[Floats]]) -> dict[int, Draft]:
    """Return drafts of those slices whose samples bear out what is shown; closed polylines need none."""
    drafts = [
        None if is_clean(one) else guided(one, frame, guess) if guess else _tip(one, frame)
        for one, guess in zip(slices, shown, strict=True)
    ]
    return {k: draft for k, draft in enumerate(drafts) if draft is not None}


def _tip(one: Slice, frame: AxisFrame) -> Draft | None:
    """Return the contour of a slice where nothing is shown: of a tip, which is mostly convex."""
    hull = shapely.convex_hull(shapely.MultiPoint(frame.to_plane(one.points)))
    if hull.geom_type != "Polygon" or is_grazing(one):
        return None
    ring = shapely.get_coordinates(shapely.segmentize(hull.exterior, hull.length / _CORNERS))[:-1]
    draft = guided(one, frame, [ring])
    return draft if draft is not None and draft.complete else None


def _found(k: int, slices: Sequence[Slice], known: Mapping[int, Draft], frame: AxisFrame) -> Draft:
    """Return the contours of a slice as the nearest known ones tell them, or as it tells them alone."""
    whole = [place for place, one in known.items() if one.complete]
    below = max((place for place in whole if place < k), default=None)
    above = min((place for place in whole if place > k), default=None)
    draft = None
    if below is not None and above is not None:
        draft = followed(slices[k], frame, known[below], known[above])
    if draft is None and is_grazing(slices[k]):
        return Draft(slices[k].height, samples=len(slices[k].points))
    return draft or draft_of(slices[k], frame)


def _order(count: int) -> list[int]:
    """Return the order of the slices: every eighth and the last one, then always the middle between two."""
    order = sorted({*range(0, count, _STRIDE), count - 1}) if count else []
    spans = list(pairwise(order))
    while spans:
        low, high = spans.pop(0)
        middle = (low + high) // 2
        if low < middle < high:
            order.append(middle)
            spans += [(low, middle), (middle, high)]
    return order
