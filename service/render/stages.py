"""The stages of the skeleton method, a picture each (Figs. 5 and 10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from core.results import Delaunay, Graph, Reconstruction, SkeletonStages
from service.render.pen import Pen
from service.render.scenes import COLOURS, GREY, LINE, Area, Dots, Marks, Scene, Segments

__all__ = ["MOST_SHAPES", "skeleton_stages", "visible"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

MOST_SHAPES = 20_000
"""More triangles or edges than this are thinned out: they would be smaller than a dot."""

_CRITERIA = ("enclosed", "small area", "short edges", "hole filled")


def skeleton_stages(
    result: Reconstruction, stages: SkeletonStages, points: Floats, pen: Pen, curves: Scene
) -> dict[str, Scene]:
    """Return the pictures by name, in the order of the work.

    Parameters
    ----------
    result : Reconstruction
    stages : SkeletonStages
        Those of the result.
    points : (N, d) array
        The samples.
    pen : Pen
    curves : Scene
        The picture of the result without its stages.
    """
    cloud = (Dots(pen(points), GREY),)
    tape = pen.tape(result.tape or ())
    scenes = {
        "balls": Scene("Samples and local balls", dots=cloud, circles=curves.circles),
        "delaunay": _triangulation(stages.delaunay, pen(points)),
        "triangles": _accepted(stages.delaunay, pen(points)),
        "tape": Scene("Tape polygon", areas=tape),
        "border": _border(stages, pen, tape),
        "voronoi": _voronoi(stages, pen, tape),
        "graph": _graph(result.graph or Graph((), ()), pen, tape),
        "curves": replace(curves, title="Curves", circles=()),
    }
    return {name: replace(one, unit=pen.unit) for name, one in scenes.items()}


def _triangulation(delaunay: Delaunay, paper: Floats) -> Scene:
    edges = _edges(delaunay.triangles)
    return Scene("Delaunay triangles", segments=(Segments(visible(paper[edges]), LINE),))


def _edges(triangles: Ints) -> Ints:
    """Every edge once, as pairs of indices."""
    both = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    base = int(both.max(initial=0)) + 1
    return np.column_stack(np.divmod(np.unique(both[:, 0] * base + both[:, 1]), base))


def visible(ends: Floats, most: int = MOST_SHAPES) -> Floats:
    """Thin segments (E, 2, 2) out: the longest half of what may be drawn stays, and of the others some."""
    if len(ends) <= most:
        return ends
    order = np.argsort(-np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), kind="stable")
    long, short = order[: most // 2], order[most // 2 :]
    some = np.random.default_rng(0).choice(short, most // 2, replace=False, shuffle=False)
    kept: Floats = ends[np.sort(np.concatenate([long, some]))]
    return kept


def _accepted(delaunay: Delaunay, paper: Floats) -> Scene:
    """Colour each triangle by the first criterion that keeps it (Fig. 10c, d)."""
    first = np.select([delaunay.enclosed, delaunay.small_area, delaunay.short_edges], [0, 1, 2], 3)
    kinds = [delaunay.triangles[delaunay.accepted & (first == k)] for k in range(len(_CRITERIA))]
    bridges = Segments(paper[delaunay.bridges], "#000000", "bridges")
    segments = (bridges,) if len(bridges.ends) else ()
    looks = [
        (paper[triangles], colour, name)
        for triangles, colour, name in zip(kinds, COLOURS, _CRITERIA, strict=False)
        if len(triangles)
    ]
    title = "Small triangles"
    if sum(len(corners) for corners, _, _ in looks) > MOST_SHAPES:
        dots = tuple(Dots(corners.mean(axis=1), colour, name) for corners, colour, name in looks)
        return Scene(title, segments=segments, dots=dots)
    areas = tuple(Area(tuple(corners), _tint(colour), colour, name) for corners, colour, name in looks)
    return Scene(title, areas=areas, segments=segments)


def _tint(colour: str) -> str:
    """Half of the colour, half white."""
    return "#" + "".join(f"{(int(colour[k : k + 2], 16) + 255) // 2:02X}" for k in (1, 3, 5))


def _border(stages: SkeletonStages, pen: Pen, tape: tuple[Area, ...]) -> Scene:
    dots = (Dots(pen(np.concatenate(stages.border)), COLOURS[1]),) if stages.border else ()
    return Scene("Border, resampled", areas=tape, dots=dots)


def _voronoi(stages: SkeletonStages, pen: Pen, tape: tuple[Area, ...]) -> Scene:
    ends = stages.voronoi
    drawn = pen(ends.reshape(-1, ends.shape[2])).reshape(-1, 2, 2)
    return Scene("Voronoi edges, hair included", areas=tape, segments=(Segments(visible(drawn), COLOURS[0]),))


def _graph(graph: Graph, pen: Pen, tape: tuple[Area, ...]) -> Scene:
    paths = tuple(
        pen.path(number, edge.vertices, False, f"edge {number}") for number, edge in enumerate(graph.edges)
    )
    places = [node.location for node in graph.nodes]
    marks = (Marks(pen(np.array(places)), "#000000"),) if places else ()
    return Scene("Skeleton without hair", areas=tape, paths=paths, marks=marks)
