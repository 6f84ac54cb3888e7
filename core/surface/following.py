"""The contours of a slice between two others whose contours are known: those, moved to its own samples.

Where neighbours have as many contours, what lies between them is near enough to the slice's own
contours that these need not be found, only refined; that takes a fraction of the time. Whether it was so
the samples tell: they must lie about the refined contours as they do about the neighbours'.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from core.cloud.sampling import Sample
from core.cloud.working_frame import WorkingFrame, working_frame
from core.errors import InvalidInput
from core.refine.polyline import Polyline
from core.refine.principal_curve import CUT, Refined, refine_curves
from core.refine.project import project
from core.surface.axis import AxisFrame
from core.surface.draft import METHODS, Draft, found_in, judged
from core.surface.interpolated import closest
from core.surface.results import Slice

__all__ = ["FOLLOWED", "followed"]

Floats = NDArray[np.float64]

FOLLOWED = "neighbours"
"""The method of drafts that were found so."""

_LEAST = 20  # samples
_LEFT = 0.02  # share of the samples that may be left over beyond what the neighbours leave
_NOISIER = 1.3  # times the neighbours' noise
_FINE = 0.05  # of the distance between samples: nearer to a contour they need not lie
_NORMAL = 1.4826  # standard deviations of normal noise in a median distance
_PASSES = 2
_ROUNDS = 4  # of refinement, each with the noise that the one before has left
_NEARER = 0.7  # of the noise before: less gain is none
_NUDGES = 3  # of a first guess
_FAR = 0.95  # quantile of distances that tells how far a first guess is off
_WINDOW = 12.0  # mean distances between samples, at least
_VERTICES = 4  # in a window
_TRACE = 1e-6  # of a sample: less counts as none
_REACH = 0.1  # of the extent: samples farther from the first guess have no say in it


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
    if not _agree(below, above) or len(slice_.points) < _LEAST:
        return None
    points = frame.to_plane(slice_.points)
    share = (slice_.height - below.height) / (above.height - below.height)
    work, way = working_frame(points, np.eye(3), flat=True)
    lines: Sequence[Polyline] = [Polyline(_in(way, one), True) for one in _between(below, above, share)]
    sample = Sample.of(work)
    best: Draft | None = None
    # The first guess is smoother than the samples can make it: it is moved to them only where it must be.
    for nudges in (0, _NUDGES):
        for _ in range(nudges):
            lines = _nudged(work, lines)
        for refined in _refinements(sample, lines):
            draft = judged(slice_.height, found_in(refined, way), len(points), FOLLOWED)
            best = draft if _holds(draft, below, above) else best
            if best is not None and draft.sigma <= _NOISIER * min(below.sigma, above.sigma):
                break
        if best is not None:
            break
    return best


def _refinements(sample: Sample, lines: Sequence[Polyline]) -> Iterator[Refined]:
    """Yield refinements of a first guess, each with the noise that the one before has left."""
    sigma = _first_sigma(sample.points, lines)
    for _ in range(_ROUNDS):
        try:
            refined = refine_curves(sample, lines, sigma, True, CUT, passes=_PASSES)
        except InvalidInput:
            return
        yield refined
        if not 0.0 < refined.sigma < _NEARER * sigma:
            return
        lines, sigma = refined.curves, refined.sigma


def _agree(below: Draft, above: Draft) -> bool:
    """Tell whether two neighbours have as many contours, found in noise."""
    found = all(one.method in (*METHODS, FOLLOWED) and one.complete for one in (below, above))
    return found and len(below.loops) == len(above.loops) and below.height < above.height


def _between(below: Draft, above: Draft, share: float) -> list[Floats]:
    """Return contours part of the way from the lower ones to the closest places of the upper ones."""
    near, far = (below, above) if share <= 0.5 else (above, below)
    part = share if near is below else 1.0 - share
    other = [one.vertices for one in far.loops]
    return [one.vertices + part * (closest(other, one.vertices)[0] - one.vertices) for one in near.loops]


def _in(way: WorkingFrame, loop: Floats) -> Floats:
    """Bring places of the plane to working coordinates."""
    return np.insert(way.way.apply(loop), 2, 0.0, axis=1)


def _nudged(work: Floats, lines: Sequence[Polyline]) -> Sequence[Polyline]:
    """Move first guesses by the mean offset of the samples nearby.

    Refinement sees samples within a few standard deviations only; where neighbours differ they lie farther.
    """
    reach = _REACH * float(np.ptp(work, axis=0).max())
    feet = project(work, lines, reach)
    known = feet.curve >= 0
    if not known.any():
        return lines
    window = max(float(np.quantile(feet.distance[known], _FAR)), _WINDOW * _spacing(work, lines))
    return [
        _moved(line, work[own], feet.station[own], window)
        for k, line in enumerate(lines)
        for own in [np.flatnonzero(feet.curve == k)]
    ]


def _moved(line: Polyline, samples: Floats, stations: Floats, window: float) -> Polyline:
    """Move a closed curve by the offsets of its samples, averaged along it over a window."""
    even = line.resampled(window / _VERTICES)
    count, length = len(even.vertices), line.length
    place = np.minimum((stations / length * count).astype(np.int64), count - 1)
    offset = samples - line.at(stations)
    sums = np.stack([np.bincount(place, values, count) for values in (*offset.T, np.ones(len(place)))])
    smooth = gaussian_filter1d(sums, _VERTICES / 2.0, axis=1, mode="wrap")
    moved: Floats = even.vertices + (smooth[:3] / np.maximum(smooth[3], _TRACE)).T
    return Polyline(moved, True)


def _spacing(work: Floats, lines: Sequence[Polyline]) -> float:
    """Return the mean distance between samples along curves."""
    return sum(line.length for line in lines) / len(work)


def _first_sigma(work: Floats, lines: Sequence[Polyline]) -> float:
    """Return how far samples lie from a first guess, in standard deviations of normal noise."""
    reach = _REACH * float(np.ptp(work, axis=0).max())
    return _NORMAL * float(np.median(np.minimum(project(work, lines, reach).distance, reach)))


def _holds(draft: Draft, below: Draft, above: Draft) -> bool:
    """Tell whether contours explain their samples as well as the neighbours' do theirs."""
    alike = draft.complete and len(draft.loops) == len(below.loops)
    quiet = draft.sigma <= max(_NOISIER * max(below.sigma, above.sigma), _FINE * draft.spacing)
    return alike and quiet and draft.left <= max(below.left, above.left) + _LEFT
