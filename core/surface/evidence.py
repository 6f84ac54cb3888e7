"""What a level that was not seen whole has seen: samples, curves, and loops seen all along (§5.1.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.results import Curve
from core.surface.contour_fit import fit_contour
from core.surface.draft import Draft, is_simple
from core.surface.interpolated import closest, resampled, steps_of

__all__ = ["NOISE", "SAME", "Evidence", "explained", "mean_step", "refined"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

NOISE = 6.0
"""Standard deviations beyond which a curve is not the one that a guide tells of."""

SAME = 0.5
"""Mean steps between vertices within which curves are the same."""

_GAP = 8.0  # mean distances between samples: a curve without samples that near was not seen
_THICK = 3.0  # standard deviations: what is thinner than that is noise about one curve
_NOISIER = 2.0  # times the neighbours' noise: the curve may run through the middle of two


@dataclass(frozen=True)
class Evidence:
    """What a level has seen.

    Attributes
    ----------
    draft : Draft
        What it says by itself.
    points : (N, 2) array
        Its samples, in the plane.
    noise : float
        Of its neighbours; 0 when it is not known.
    """

    draft: Draft
    points: Floats
    noise: float = 0.0

    @cached_property
    def limit(self) -> float:
        """How far samples may lie from the contour that they belong to, and from each other along it."""
        return max(NOISE * self.draft.sigma, _GAP * self.draft.spacing)

    @cached_property
    def samples(self) -> cKDTree:
        """The samples, to find those near by."""
        return cKDTree(self.points)

    @cached_property
    def curves(self) -> list[Floats]:
        """The level's own curves, those of loops first, with their first vertex repeated."""
        closed = [np.vstack((one.vertices, one.vertices[:1])) for one in self.draft.loops]
        return closed + [one.vertices for one in self.draft.loose if len(one.vertices) > 1]

    @cached_property
    def whole(self) -> list[bool]:
        """Tell for each curve whether it is a loop that was seen all along, and no noise about a line."""
        closed = [self._is_whole(one) for one in self.draft.loops]
        return closed + [False] * (len(self.curves) - len(closed))

    def _is_whole(self, loop: Curve) -> bool:
        step = self.limit / 4.0
        if self.noise > 0.0 and loop.rms_residual > _NOISIER * self.noise:
            return False
        thin = 2.0 * shapely.Polygon(loop.vertices).area < _THICK * self.draft.sigma * loop.length
        fine = resampled(loop.vertices, step, closed=True)
        return not thin and bool(np.all(self.samples.query(fine)[0] <= self.limit))

    def without(self, loops: Sequence[Floats]) -> float:
        """Return the share of the samples that lie near none of the loops."""
        if not len(self.points) or not loops:
            return float(len(self.points) > 0)
        distance = np.linalg.norm(self.points - closest(loops, self.points)[0], axis=1)
        return float(np.mean(distance > self.limit))


def explained(loops: Sequence[Floats], draft: Draft, points: Floats) -> float:
    """Return the share of a level's samples that lie near closed contours.

    Parameters
    ----------
    loops : sequence of (M, 2) arrays
    draft : Draft
        What the level says by itself.
    points : (N, 2) array
        Its samples, in the plane.
    """
    return 1.0 - Evidence(draft, points).without(loops)


def refined(loops: list[Floats], own: Evidence) -> list[Floats]:
    """Fit contours to the samples, which tell more than curves found without a guide; gaps stay.

    Parameters
    ----------
    loops : list of (M, 2) arrays
        Closed, without crossings.
    own : Evidence
        With samples and curves.
    """
    points = own.points[_followed(loops, own)]
    if not len(points):
        return loops
    bounds = np.cumsum([0, *map(len, loops)])
    nearest = np.asarray(cKDTree(np.concatenate(loops)).query(points)[1])
    which = np.searchsorted(bounds, nearest, side="right") - 1
    fitted = []
    for k, one in enumerate(loops):
        fit = fit_contour(points[which == k], one, nearest[which == k] - bounds[k])
        fitted.append(one if fit is None else fit.vertices)
    fitted = _restrained(fitted, loops, own)
    return fitted if is_simple(fitted) else loops


def _restrained(fitted: list[Floats], loops: Sequence[Floats], own: Evidence) -> list[Floats]:
    """Return fitted contours that stay what they were where they go off, or samples are no longer near."""
    reach = NOISE * own.draft.sigma
    before, after = (
        np.linalg.norm(own.points - closest(some, own.points)[0], axis=1) for some in (loops, fitted)
    )
    every = np.concatenate(fitted)
    off = every[np.linalg.norm(every - closest(loops, every)[0], axis=1) > reach]
    bad = np.concatenate((off, own.points[(after > reach) & (before <= reach)]))
    if not len(bad):
        return fitted
    shares = [np.clip(cKDTree(bad).query(one)[0] / own.limit - 1.0, 0.0, 1.0)[:, None] for one in loops]
    ways = [closest([new], one)[0] - one for one, new in zip(loops, fitted, strict=True)]
    return [one + share * way for one, share, way in zip(loops, shares, ways, strict=True)]


def _followed(loops: Sequence[Floats], own: Evidence) -> Bools:
    """Tell which samples belong to curves of the level that contours follow."""
    fine = np.concatenate([resampled(one, own.limit / 4.0, closed=False) for one in own.curves])
    distance, nearest = cKDTree(fine).query(own.points)
    follows = np.linalg.norm(fine - closest(loops, fine)[0], axis=1) <= SAME * mean_step(loops)
    return np.asarray(follows[nearest] & (distance <= own.limit))


def mean_step(loops: Sequence[Floats]) -> float:
    """Return the mean distance between vertices."""
    return float(np.concatenate([steps_of(one) for one in loops]).mean())
