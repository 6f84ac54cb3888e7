"""Where the planes of a stack lie (§5.1.1, step ii)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.errors import InvalidParameter
from core.surface.parameters import MAX_LEVELS, SliceParameters
from core.surface.results import Mesh

__all__ = ["level_heights", "sample_distance"]

Floats = NDArray[np.float64]

_FEWEST, _MOST = 100, 400  # levels without being asked: the paper uses more than 100
_EDGES = 200_000  # that a median distance is taken of: its standard error is then below 1 %


def level_heights(meshes: Sequence[Mesh], heights: Sequence[Floats], parameters: SliceParameters) -> Floats:
    """Return the heights of the planes, ascending.

    ``levels`` planes halve the layers between them: the first and the last lie half a spacing inside.
    Planes with a given ``spacing`` are centred in the extent. By default the spacing is the typical
    distance d between samples, since what is sampled at d carries no wavelength below 2 d, and
    planes at d catch that wavelength twice (Nyquist); 100 planes are the fewest, for meshes of few and
    large triangles, and 400 the most.

    Parameters
    ----------
    meshes : sequence of Mesh
    heights : sequence of (V,) arrays
        Heights of their vertices along the axis.
    parameters : SliceParameters

    Raises
    ------
    InvalidParameter
        When the spacing asks for more than 10 000 planes.
    """
    if parameters.heights is not None:
        return np.unique(np.asarray(parameters.heights, np.float64))
    low = min(float(one.min()) for one in heights if len(one))
    high = max(float(one.max()) for one in heights if len(one))
    if parameters.levels is not None:
        return _inside(low, high, parameters.levels)
    if parameters.spacing is None:
        count = (high - low) / max(sample_distance(meshes), np.finfo(float).tiny)
        return _inside(low, high, round(min(max(count, _FEWEST), _MOST)))
    count = (high - low) / parameters.spacing
    if count > MAX_LEVELS:
        raise InvalidParameter(
            f"This spacing asks for more than {MAX_LEVELS} planes; give a larger one.",
            ("parameters", "spacing"),
        )
    steps = np.arange(max(1, int(count + 1e-9)))
    return np.asarray((low + high) / 2.0 + (steps - steps[-1] / 2.0) * parameters.spacing, np.float64)


def sample_distance(meshes: Sequence[Mesh]) -> float:
    """Return the typical distance between samples: the median length of the edges of all triangles.

    Of many edges a regular part is looked at.
    """
    total = sum(len(one.faces) for one in meshes)
    stride = max(1, 3 * total // _EDGES)
    lengths = [
        np.linalg.norm(one.vertices[some] - one.vertices[np.roll(some, 1, axis=1)], axis=2).ravel()
        for one in meshes
        if len(some := one.faces[::stride])
    ]
    return float(np.median(np.concatenate(lengths))) if lengths else 0.0


def _inside(low: float, high: float, count: int) -> Floats:
    return np.asarray(low + (np.arange(count) + 0.5) * ((high - low) / count), np.float64)
