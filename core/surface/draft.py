"""The contours of one slice by itself (§5.1.1, step iii): curves of the method, judged as contours.

Contours of a solid are closed and do not cross. Each method of reconstruction is asked in turn, the
quickest first, until one finds such curves and leaves no samples over; otherwise the best one is kept,
and the level counts as incomplete.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.cloud.working_frame import WorkingFrame
from core.componentwise import Componentwise
from core.errors import InvalidInput
from core.methods import PCA, SKELETON
from core.parameters import CommonParameters, PcaParameters, SkeletonParameters
from core.refine.principal_curve import Refined
from core.results import Curve, Partition
from core.solved import Solved
from core.surface.axis import AxisFrame
from core.surface.interpolated import steps_of
from core.surface.results import Slice

__all__ = [
    "CLEAN",
    "GAP",
    "LEFT",
    "METHODS",
    "STRAY",
    "Draft",
    "Found",
    "attempt",
    "draft_of",
    "found_in",
    "is_clean",
    "is_simple",
    "judged",
]

Floats = NDArray[np.float64]

METHODS = ("skeleton", "pca")
"""The methods that are asked, in this order: contours keep apart where they come near, as skeletons do."""

CLEAN = "polylines"
"""The method of drafts of slices whose closed polylines are their contours already."""

STRAY = 0.03
"""Share of the samples up to which what lies beside closed contours says nothing."""

LEFT = 0.15
"""Share of the samples that no curve needs to explain: scans lie beside each other."""

_NEAR = 6.0  # standard deviations within which samples count as a contour's own
GAP = 8.0
"""Beyond ln N, in mean distances between samples: independent samples leave no such gap."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """What one slice says by itself, in the coordinates of its plane.

    Attributes
    ----------
    height : float
    loops : tuple of Curve
        Closed, without crossings.
    loose : tuple of Curve
        Open curves that stand for samples of contours that were not seen whole.
    sigma : float
        Noise of the samples about the curves; 0 when it is not known.
    spacing : float
        Mean distance between samples along the curves.
    gap : float
        The longest stretch of a loop without samples, in units of ``spacing``.
    left : float
        Share of the samples that no curve explains.
    complete : bool
        Whether the loops are all there is: nothing loose, no gap, few samples left over.
    samples : int
    method : str
        What found it; empty when nothing did, `CLEAN` when nothing had to.
    """

    height: float
    loops: tuple[Curve, ...] = ()
    loose: tuple[Curve, ...] = ()
    sigma: float = 0.0
    spacing: float = 0.0
    gap: float = 0.0
    left: float = 0.0
    complete: bool = False
    samples: int = 0
    method: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A curve that some method found, in the plane, and its samples.

    Attributes
    ----------
    vertices : (M, 2) array
    closed : bool
    length : float
    stations : (n,) array
        Arc lengths of the feet of its samples, ascending.
    sigma : float
        RMS distance of those samples.
    """

    vertices: Floats
    closed: bool
    length: float
    stations: Floats
    sigma: float

    @property
    def gap(self) -> float:
        """The longest stretch of a closed curve without samples."""
        if not len(self.stations):
            return self.length
        return float(np.max(np.diff(np.append(self.stations, self.stations[0] + self.length))))

    def curve(self, component: int) -> Curve:
        """Return the curve as results have it."""
        return Curve(self.vertices, self.closed, component, self.length, len(self.stations), self.sigma)


def draft_of(slice_: Slice, frame: AxisFrame) -> Draft:
    """Reconstruct the contours of one slice, without a look at its neighbours.

    Polylines that are all closed and do not cross, as closed meshes give them, are the contours already.

    Parameters
    ----------
    slice_ : Slice
    frame : AxisFrame
        Of the axis across the slices.
    """
    clean = _clean(slice_, frame)
    if clean is not None:
        return clean
    best = Draft(slice_.height, samples=len(slice_.points))
    for one in _attempts(slice_, frame):
        if _is_better(one, best):
            best = one
        if best.complete:
            break
    return best


def _attempts(slice_: Slice, frame: AxisFrame) -> Iterator[Draft]:
    """Yield what each method makes of a slice; methods that find no curve are passed over."""
    for method in METHODS:
        one = attempt(slice_, frame, method)
        if one is not None:
            yield one


def attempt(slice_: Slice, frame: AxisFrame, method: str) -> Draft | None:
    """Return what one method makes of a slice; None when it finds no curve."""
    points = frame.to_plane(slice_.points)
    solver, parameters = _SOLVERS[method]
    try:
        found = solver(points, parameters)
    except InvalidInput:
        return None
    return judged(slice_.height, found, len(points), method)


def _answer(_points: Floats, _parts: Partition, solved: Sequence[Solved]) -> list[Found]:
    """Return the curves alone: contours need no report on their sampling."""
    return [curve for one in solved for curve in found_in(one.refined, one.frame)]


def found_in(refined: Refined, frame: WorkingFrame) -> list[Found]:
    """Return refined curves in the plane, with their samples.

    Parameters
    ----------
    refined : Refined
    frame : WorkingFrame
        In which they were refined.
    """
    feet, result = refined.feet, []
    for k, (line, sigma) in enumerate(zip(refined.curves, refined.sigmas, strict=True)):
        own = (feet.curve == k) & (feet.distance <= max(_NEAR * float(sigma), 1e-9 * line.length))
        rms = float(np.sqrt(np.mean(feet.distance[own] ** 2))) if own.any() else 0.0
        stations = np.sort(feet.station[own]) * frame.scale
        vertices = frame.restore(line.vertices)
        result.append(Found(vertices, line.closed, line.length * frame.scale, stations, rms * frame.scale))
    return result


_SOLVERS: dict[str, tuple[Componentwise[list[Found]], CommonParameters]] = {
    "skeleton": (
        Componentwise(SkeletonParameters, SKELETON.method, _answer),
        SkeletonParameters(crossings="waist"),
    ),
    "pca": (Componentwise(PcaParameters, PCA.method, _answer), PcaParameters()),
}


def _clean(slice_: Slice, frame: AxisFrame) -> Draft | None:
    """Return the polylines of a slice when they are its contours already."""
    if not is_clean(slice_):
        return None
    lines = [frame.to_plane(line) for line in slice_.polylines]
    if not is_simple(lines):
        return None
    lengths = [float(steps_of(line).sum()) for line in lines]
    loops = [Curve(line, True, k, lengths[k], len(line), 0.0) for k, line in enumerate(lines)]
    return Draft(slice_.height, tuple(loops), complete=True, samples=len(slice_.points), method=CLEAN)


def is_clean(slice_: Slice) -> bool:
    """Tell whether all polylines of a slice are closed, so that they may be its contours already."""
    return bool(slice_.polylines) and all(slice_.closed)


def judged(height: float, found: Sequence[Found], samples: int, method: str) -> Draft:
    """Sort curves into contours, loose ends and strays, and tell whether the contours are all there is.

    Parameters
    ----------
    height : float
    found : sequence of Found
    samples : int
        How many there are in all.
    method : str
        What found the curves.
    """
    loops = [one for one in found if one.closed]
    loose = [one for one in found if not one.closed and (not loops or len(one.stations) > STRAY * samples)]
    own = [*loops, *loose]
    explained = sum(len(one.stations) for one in own)
    spacing = sum(one.length for one in own) / max(explained, 1)
    sigma = float(np.sqrt(sum(one.sigma**2 * len(one.stations) for one in own) / max(explained, 1)))
    gap = max((one.gap for one in loops), default=0.0) / spacing if spacing > 0.0 else 0.0
    left = 1.0 - explained / max(samples, 1)
    whole = bool(loops and not loose and gap <= np.log(samples) + GAP and left <= LEFT)
    return Draft(
        height,
        tuple(one.curve(k) for k, one in enumerate(loops)),
        tuple(one.curve(len(loops) + k) for k, one in enumerate(loose)),
        sigma,
        spacing,
        gap,
        left,
        whole and is_simple([one.vertices for one in loops]),
        samples,
        method,
    )


def is_simple(loops: Sequence[Floats]) -> bool:
    """Tell whether closed curves cross neither themselves nor each other."""
    return bool(shapely.MultiLineString([np.vstack((one, one[:1])) for one in loops]).is_simple)


def _is_better(one: Draft, other: Draft) -> bool:
    """Tell which of two drafts leaves fewer samples without a closed contour, or without any curve."""
    if one.complete != other.complete:
        return one.complete
    return _explained(one) > _explained(other)


def _explained(one: Draft) -> tuple[int, int]:
    """Return the number of samples of closed contours, and of loose ones."""
    return sum(loop.samples for loop in one.loops), sum(curve.samples for curve in one.loose)
