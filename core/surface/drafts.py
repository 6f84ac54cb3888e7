"""The contours of consecutive slices: a few found, those between them followed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from core.progress import Progress, tell
from core.surface.axis import AxisFrame
from core.surface.draft import METHODS, Draft, draft_of
from core.surface.following import followed
from core.surface.results import Slice

__all__ = ["GROUP", "drafts_of"]

GROUP = 17
"""Consecutive slices that are best worked on together."""

_STRIDE = 8  # slices from one that is found to the next; what lies between is halved again and again


def drafts_of(slices: Sequence[Slice], frame: AxisFrame, *, progress: Progress | None = None) -> list[Draft]:
    """Reconstruct the contours of consecutive slices.

    Every eighth one is reconstructed by itself, and the last one; each
    one between is followed from those nearest to it on both sides that were seen whole, or where these
    do not tell reconstructed as well. What was reconstructed is then followed too, where it can be.

    Parameters
    ----------
    slices : sequence of Slice
        By height.
    frame : AxisFrame
        Of the axis across them.
    progress : Progress, optional
        Told how far it has come.
    """
    known: dict[int, Draft] = {}
    for k in _order(len(slices)):
        tell(progress, len(known) / len(slices), "")
        whole = [place for place, one in known.items() if one.complete]
        below = max((place for place in whole if place < k), default=None)
        above = min((place for place in whole if place > k), default=None)
        draft = None
        if below is not None and above is not None:
            draft = followed(slices[k], frame, known[below], known[above])
        known[k] = draft or draft_of(slices[k], frame)
    for k in range(1, len(slices) - 1):
        if known[k].complete and known[k].method in METHODS:  # its neighbours make a smoother first guess
            known[k] = followed(slices[k], frame, known[k - 1], known[k + 1]) or known[k]
    return [known[k] for k in range(len(slices))]


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
