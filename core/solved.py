"""A component with its curves, between the methods and the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Scale
from core.cloud.working_frame import WorkingFrame
from core.march.solve import Marched
from core.refine.principal_curve import Refined
from core.results import Component, Evidence
from core.tape.solve import Taped

__all__ = ["Solved"]


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A component with its curves in working coordinates.

    Attributes
    ----------
    component : Component
    members : (n,) array
        Indices of its samples in the input.
    points : (n, 3) array
        The samples in working coordinates.
    frame : WorkingFrame
    refined : Refined
    outliers : {"auto", "keep", "reject"}
    bent : {"projected", "marched in 3D"} or None
        What was done with a component that is not quasi-planar; None for one that is, and when 3D
        was asked for.
    scale : Scale or None
    march : Marched or None
        How the PCA method found the curves.
    tape : Taped or None
        How the skeleton method found them.
    method : {"pca", "skeleton"} or None
        Whose curves they are, where there was a choice.
    evidence : tuple of Evidence
        Of the chosen curves, then of the others, where there was a choice.
    """

    component: Component
    members: NDArray[np.int64]
    points: NDArray[np.float64]
    frame: WorkingFrame
    refined: Refined
    outliers: Literal["auto", "keep", "reject"]
    bent: Literal["projected", "marched in 3D"] | None
    scale: Scale | None = None
    march: Marched | None = None
    tape: Taped | None = None
    method: Literal["pca", "skeleton"] | None = None
    evidence: tuple[Evidence, ...] = ()

    @property
    def extent(self) -> float:
        """Radius of the component about its centre, in working units."""
        return float(np.sqrt(np.einsum("ij,ij->i", self.points, self.points).max()))
