"""The contours of a slice between two others whose contours are known: those, moved to its own samples.

Where neighbours have as many contours, what lies between them is near enough to the slice's own
contours that these need not be found, only refined; that takes a fraction of the time. Whether it was so
the samples tell: they must lie about the refined contours as they do about the neighbours'.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.surface.axis import AxisFrame
from core.surface.draft import METHODS, Draft
from core.surface.guided import GUIDED, guided
from core.surface.interpolated import closest
from core.surface.results import Slice

__all__ = ["FOLLOWED", "followed"]

Floats = NDArray[np.float64]

FOLLOWED = "neighbours"
"""The method of drafts that were found so."""

_LEFT = 0.02  # share of the samples that may be left over beyond what the neighbours leave
_NOISIER = 1.3  # times the neighbours' noise
_FINE = 0.05  # of the distance between samples: nearer to a contour they need not lie


def followed(slice_: Slice, frame: AxisFrame, below: Draft, above: Draft) -> Draft | None:
    """Return the contours of a slice as its neighbours tell them, refined with its own samples.

    Parameters
    ----------
    slice_ : Slice
    frame : AxisFrame
        Of the axis across the slices.
    below, above : Draft
        Of slices on both sides.

    Returns
    -------
    Draft or None
        None where the neighbours differ, were not seen whole, or do not explain the samples.
    """
    if not _agree(below, above):
        return None
    share = (slice_.height - below.height) / (above.height - below.height)
    draft = guided(slice_, frame, _between(below, above, share), FOLLOWED)
    return draft if draft is not None and _holds(draft, below, above) else None


def _agree(below: Draft, above: Draft) -> bool:
    """Tell whether two neighbours have as many contours, found in noise."""
    found = all(one.method in (*METHODS, FOLLOWED, GUIDED) and one.complete for one in (below, above))
    return found and len(below.loops) == len(above.loops) and below.height < above.height


def _between(below: Draft, above: Draft, share: float) -> list[Floats]:
    """Return contours part of the way from the lower ones to the closest places of the upper ones."""
    near, far = (below, above) if share <= 0.5 else (above, below)
    part = share if near is below else 1.0 - share
    other = [one.vertices for one in far.loops]
    return [one.vertices + part * (closest(other, one.vertices)[0] - one.vertices) for one in near.loops]


def _holds(draft: Draft, below: Draft, above: Draft) -> bool:
    """Tell whether contours explain their samples as well as the neighbours' do theirs."""
    alike = draft.complete and len(draft.loops) == len(below.loops)
    quiet = draft.sigma <= max(_NOISIER * max(below.sigma, above.sigma), _FINE * draft.spacing)
    return alike and quiet and draft.left <= max(below.left, above.left) + _LEFT
