"""The skeleton SK(T): medial axis and graph, from a border resampled until the tape covers them (§4.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from core.errors import InvalidParameter
from core.tape.graph import Graph, skeleton_graph
from core.tape.medial_axis import (
    MOST_SAMPLES,
    SPACING,
    Border,
    MedialAxis,
    mean_width,
    medial_axis,
    resampled_border,
)

__all__ = ["Skeleton", "skeleton_of"]

PASSES = 4  # each halves the spacing


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The skeleton of a tape.

    Attributes
    ----------
    axis : MedialAxis
        Voronoi edges, hair included.
    graph : Graph
        Without hair.
    passes : int
        How often the border was resampled.
    outside : (U, 2) array
        Middles of the graph's segments that the tape does not cover.
    """

    axis: MedialAxis
    graph: Graph
    passes: int
    outside: NDArray[np.float64]


def skeleton_of(polygon: shapely.Geometry, prune: float, spacing: float | None = None) -> Skeleton:
    """Build the skeleton, resampling the border more finely until the polygon covers it.

    Parameters
    ----------
    polygon : shapely.Polygon or shapely.MultiPolygon
        Valid and not empty.
    prune : float
        Reach of a leaf beyond its fork, in disc radii, below which it is hair.
    spacing : float, optional
        First spacing of the border samples; by default a share of the mean width.

    Raises
    ------
    InvalidParameter
        When that spacing makes too many samples.
    """
    if spacing is not None and spacing * MOST_SAMPLES < polygon.length:
        raise InvalidParameter(
            f"resample would make more than {MOST_SAMPLES} samples of the tape's border; give a larger one.",
            ("parameters", "resample"),
        )
    width = mean_width(polygon)
    shapely.prepare(polygon)
    best: Skeleton | None = None
    for passes, border in _finer_and_finer(polygon, spacing or SPACING * width, SPACING * width):
        axis = medial_axis(polygon, border, 0.5 * width)
        graph = skeleton_graph(axis, prune)
        outside = _not_covered(polygon, graph)
        if best is None or len(outside) < len(best.outside):
            best = Skeleton(axis, graph, passes, outside)
        if not len(outside):
            break
    assert best is not None  # noqa: S101 - there is always a first pass
    return best


def _finer_and_finer(polygon: shapely.Geometry, step: float, chord: float) -> Iterator[tuple[int, Border]]:
    for k in range(PASSES):
        if k and step / 2**k * MOST_SAMPLES < polygon.length:
            return
        yield k + 1, resampled_border(polygon, step / 2**k, chord)


def _not_covered(polygon: shapely.Geometry, graph: Graph) -> NDArray[np.float64]:
    """Middles of the segments of the graph that the polygon does not cover."""
    segments = [np.stack([edge.places[:-1], edge.places[1:]], axis=1) for edge in graph.edges]
    if not segments:
        return np.zeros((0, 2))
    ends = np.concatenate(segments)
    return np.asarray(ends[~shapely.covers(polygon, shapely.linestrings(ends))].mean(axis=1))
