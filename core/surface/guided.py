"""The contours of a slice from first guesses: moved to its samples, and judged by them.

Where it is known about where the contours run - between those of the neighbours, or where all scans
together have their inside - they need not be found, only fitted, in a hundredth of the time. Whether
it was so the samples tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.surface.axis import AxisFrame
from core.surface.contour_fit import fit_contour
from core.surface.draft import LEFT, STRAY, Draft, Found, draft_of, is_simple, judged
from core.surface.grazing import is_grazing
from core.surface.interpolated import steps_of
from core.surface.results import Slice

__all__ = ["GUIDED", "guided"]

Floats = NDArray[np.float64]

GUIDED = "guided"
"""The method of drafts that began with what all scans tell together."""

_NEAR = 6.0  # standard deviations within which samples count as a contour's own
_FAR = 20.0  # standard deviations beyond which samples are of contours that the guess has not
_REACH = 8.0  # times as far from the guess as half of the samples: of others for sure
_FEW = 12  # such samples are strays
_MOST = 0.3  # share of the samples that may be of other contours
_LEAST = 20  # samples


def guided(slice_: Slice, frame: AxisFrame, guess: Sequence[Floats], method: str = GUIDED) -> Draft | None:
    """Fit contours to a slice.

    Parameters
    ----------
    slice_ : Slice
    frame : AxisFrame
        Of the axis across the slices.
    guess : sequence of (M, 2) arrays
        About where its contours run, in the plane; closed, the first vertex not repeated.
    method : str
        What the draft shall say of how it was found.

    Returns
    -------
    Draft or None
        Complete or with gaps; None where the contours are others than those of the guess: samples lie far
        from them, or they cross.
    """
    if not guess or len(slice_.points) < _LEAST:
        return None
    points = frame.to_plane(slice_.points)
    vertices, bounds = np.concatenate(guess), np.cumsum([0, *map(len, guess)])
    away, nearest = cKDTree(vertices).query(points)
    nearest = np.asarray(nearest, np.int64)
    far = np.asarray(away > _REACH * np.median(away))
    own = np.where(far, -1, np.searchsorted(bounds, nearest, side="right") - 1)
    found = []
    for k, one in enumerate(guess):
        mine = own == k
        curve, far[mine] = _fitted(points[mine], one, nearest[mine] - bounds[k])
        found.append(curve)
    draft = _with_rest(judged(slice_.height, found, len(points), method), slice_, far, frame)
    if draft is None or draft.complete:
        return draft
    return draft if draft.left <= LEFT and is_simple([one.vertices for one in draft.loops]) else None


def _with_rest(draft: Draft, slice_: Slice, far: NDArray[np.bool_], frame: AxisFrame) -> Draft | None:
    """Add the contours of samples that lie far from those of the guess; None where many make none."""
    count, share = int(np.count_nonzero(far)), float(np.mean(far))
    if count <= _FEW:
        return draft
    known = share > _MOST or is_grazing(slice_)
    rest = Draft(0.0) if known else draft_of(Slice(slice_.height, slice_.points[far]), frame)
    loops = (*draft.loops, *rest.loops)
    if rest.complete and is_simple([one.vertices for one in loops]):
        return replace(draft, loops=loops, left=max(draft.left - share, 0.0))
    if share <= STRAY:
        return draft
    return replace(draft, complete=False) if share <= LEFT else None


def _fitted(points: Floats, guess: Floats, segments: NDArray[np.int64]) -> tuple[Found, NDArray[np.bool_]]:
    """Return a contour, and which samples are too far from it; the guess itself without samples."""
    fit = fit_contour(points, guess, segments)
    if fit is None:
        return Found(guess, True, float(steps_of(guess).sum()), np.zeros(0), 0.0), np.ones(
            len(points), np.bool_
        )
    near = fit.distance <= max(_NEAR * fit.sigma, 1e-9 * fit.length)
    rms = float(np.sqrt(np.mean(fit.distance[near] ** 2))) if near.any() else 0.0
    far = fit.distance > max(_FAR * fit.sigma, fit.length / len(points))
    return Found(fit.vertices, True, fit.length, np.sort(fit.station[near]), rms), far
