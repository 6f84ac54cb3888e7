"""Pre-processing of one component (§4.1): scaled, projected, turned, and asked what its samples say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.cloud.frame import is_quasi_planar
from core.cloud.lattice import lattice_step
from core.cloud.points import distinct
from core.cloud.sampling import Sample, Scale, estimate_scale
from core.cloud.working_frame import WorkingFrame, working_frame
from core.errors import InvalidParameter
from core.parameters import CommonParameters, PcaParameters, SkeletonParameters
from core.results import Component

__all__ = ["Prepared", "prepared"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_VERTICES = 1_000_000  # along the diagonal of a component's box


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """A component in working coordinates (§4.1), and what its samples say of themselves.

    Attributes
    ----------
    component : Component
    members : (n,) array
        Indices of its samples in the input.
    frame : WorkingFrame
    sample, once : Sample
        All samples, and the distinct ones.
    scale : Scale or None
        None where no ball looks like a piece of a curve.
    extent : float
        Radius about the centre, in working units.
    quasi_planar : bool
        Also when 3D was asked for.
    parameters : CommonParameters
    copies : bool
        Whether equal points are copies of one sample, which tell nothing more: not so on a lattice.
    hasty : bool
        Whether the refinement may stop before its pass over all samples.
    """

    component: Component
    members: Ints
    frame: WorkingFrame
    sample: Sample
    once: Sample
    scale: Scale | None
    extent: float
    quasi_planar: bool
    parameters: CommonParameters
    copies: bool = False
    hasty: bool = False

    @property
    def spacing(self) -> float | None:
        """The wished spacing of vertices in working units."""
        wished = self.parameters.vertex_spacing
        return None if wished is None else wished / self.frame.scale

    @property
    def fitted(self) -> Sample:
        """The samples that curves are refined with."""
        sample = self.once if self.copies else self.sample
        return Sample(sample.few, sample.few, sample.few) if self.hasty else sample


def prepared(points: Floats, members: Ints, component: Component, parameters: CommonParameters) -> Prepared:
    """Bring a component into its working frame.

    Parameters
    ----------
    points : (n, d) array
        Its samples, in the user's frame.
    members : (n,) array
        Their indices in the input.
    component : Component
    parameters : CommonParameters

    Raises
    ------
    InvalidParameter
        When a length is out of all proportion to the points.
    """
    planar = parameters.planar if isinstance(parameters, PcaParameters) else True
    in_plane = points.shape[1] == 2 or planar is False or is_quasi_planar(points)
    turned = isinstance(parameters, SkeletonParameters)
    work, frame = working_frame(points, component.frame.axes, in_plane if planar is None else planar, turned)
    _require_room(parameters, work, frame)
    sample = Sample.of(work)
    extent = float(np.sqrt(np.einsum("ij,ij->i", work, work).max()))
    once = distinct(work)  # a ball of repetitions would be a perfect line
    once_sample = sample if once is work else Sample.of(once)
    scale = estimate_scale(once_sample, extent, frame.flat) if extent > 0 else None
    copies = once is not work and lattice_step(once) is None
    return Prepared(
        component, members, frame, sample, once_sample, scale, extent, in_plane, parameters, copies
    )


def _require_room(parameters: CommonParameters, work: Floats, frame: WorkingFrame) -> None:
    """Refuse a spacing of vertices that no memory could hold."""
    wished = parameters.vertex_spacing
    if wished is None:
        return
    diagonal = float(np.linalg.norm(np.ptp(work, axis=0)))
    if wished * MOST_VERTICES < diagonal * frame.scale:
        raise InvalidParameter(
            f"vertex_spacing would make more than {MOST_VERTICES} vertices; give a larger one.",
            ("parameters", "vertex_spacing"),
        )
