"""The skeleton SK(T): medial axis and graph, from a border resampled until the tape covers them (§4.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

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

PASSES = 4  # with the usual spacing first; each halves it


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
    best, least = None, (0, np.inf, 0)
    parts = len(shapely.get_parts(polygon))
    for passes, border in _finer_and_finer(polygon, spacing or SPACING * width, SPACING * width):
        axis = medial_axis(polygon, border, 0.5 * width)
        graph = skeleton_graph(axis, prune)
        outside = _not_covered(polygon, graph)
        # Coarse segments are few, but long; where there are none the border was too coarse.
        length = float(np.hypot(*np.diff(outside, axis=1)[:, 0].T).sum()) if graph.edges else np.inf
        # A neck narrower than the spacing is not seen at all: the skeleton is torn there.
        left = max(_pieces(graph) - parts, 0), length, len(outside)
        if best is None or left < least:
            best, least = Skeleton(axis, graph, passes, outside.mean(axis=1)), left
        if left == (0, 0.0, 0):
            break
    assert best is not None  # noqa: S101 - there is always a first pass
    return best


def _finer_and_finer(polygon: shapely.Geometry, step: float, usual: float) -> Iterator[tuple[int, Border]]:
    """Borders sampled at half the spacing each time; a coarse one goes on until it is fine enough."""
    step = min(step, polygon.length)
    finest = max(0.99 * min(step, usual) / 2 ** (PASSES - 1), polygon.length / MOST_SAMPLES)
    passes = 1
    yield passes, resampled_border(polygon, step, usual)
    while step >= 2.0 * finest:
        step, passes = step / 2.0, passes + 1
        yield passes, resampled_border(polygon, step, usual)


def _pieces(graph: Graph) -> int:
    """Number of connected parts of the graph."""
    size = len(graph.places)
    ends = np.array([edge.ends for edge in graph.edges], np.int64).reshape(-1, 2)
    links = coo_matrix((np.ones(len(ends)), ends.T), shape=(size, size))
    return int(connected_components(links, directed=False)[0]) if size else 0


def _not_covered(polygon: shapely.Geometry, graph: Graph) -> NDArray[np.float64]:
    """(U, 2, 2) the segments of the graph that the polygon does not cover."""
    segments = [np.stack([edge.places[:-1], edge.places[1:]], axis=1) for edge in graph.edges]
    if not segments:
        return np.zeros((0, 2, 2))
    ends = np.concatenate(segments)
    return np.asarray(ends[~shapely.covers(polygon, shapely.linestrings(ends))])
