"""Tape, containment, graph and stages of solved components, in the user's frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.cloud.balls import Balls
from core.cloud.points import LARGEST
from core.cloud.working_frame import WorkingFrame
from core.refine.crossings import crossings
from core.results import (
    Ball,
    Containment,
    Delaunay,
    Graph,
    GraphEdge,
    GraphNode,
    SkeletonStages,
    TapePolygon,
    Warn,
)
from core.solved import Solved
from core.tape.solve import Taped

__all__ = ["containment_of", "graph_of", "skeleton_stages", "skeleton_warnings", "tape_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_WARNINGS = 20  # of one kind and component
LOW_ANGLE = 25.0  # degrees below which crossing and touching look alike
DETAIL = 5.3  # in sigma: nearer branches share one tape
HIDDEN = 0.4  # of the component's radius
NO_TAPE = "leaves no room for a tape polygon, or its tape has no skeleton: its curves are the PCA march's."
THIN_TAPE = "has too little noise to fill a tape: the PCA march explains it better, and its curves are given."
TANGENTIAL = "Branches cross at so small an angle here that they may as well touch."
AMBIGUOUS = (
    "Whether branches cross or only touch here the samples cannot tell; more samples or less noise would."
)


def tape_of(solved: Sequence[Solved]) -> tuple[TapePolygon, ...]:
    """The tape's polygons with their holes (§4.4.1)."""
    out = []
    for one, taped in _taped(solved):
        oriented = shapely.orient_polygons(taped.tape.polygon, exterior_cw=one.frame.mirrored)
        for part in shapely.get_parts(oriented):
            outer, *holes = (shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(part))
            placed = [_restored(one.frame, ring) for ring in (outer, *holes)]
            out.append(TapePolygon(placed[0], tuple(placed[1:]), one.component.label))
    return tuple(out)


def containment_of(solved: Sequence[Solved]) -> Containment | None:
    """Whether the skeletons lie in their tapes (§4.5), and what share of the samples does."""
    covered, passes, inside, total = True, 0, 0, 0
    for one, taped in _taped(solved):
        covered &= not len(taped.skeleton.outside)
        passes = max(passes, taped.skeleton.passes)
        shapely.prepare(taped.tape.polygon)
        inside += int(np.count_nonzero(shapely.contains_xy(taped.tape.polygon, one.points[:, :2])))
        total += len(one.points)
    return Containment(covered, passes, inside / total) if total else None


def graph_of(solved: Sequence[Solved]) -> Graph | None:
    """The skeletons as one graph."""
    nodes: list[GraphNode] = []
    edges: list[GraphEdge] = []
    any_tape = False
    for one, taped in _taped(solved):
        any_tape = True
        first, graph, label = len(nodes), taped.graph, one.component.label
        places = _restored(one.frame, graph.places)
        nodes += [
            GraphNode(place, float(_scaled(radius, one.frame)), int(degree), label)
            for place, radius, degree in zip(places, graph.radius, graph.degree, strict=True)
        ]
        edges += [
            GraphEdge(
                (edge.ends[0] + first, edge.ends[1] + first),
                _restored(one.frame, edge.places),
                _scaled(2.0 * edge.radius, one.frame),
                float(_scaled(edge.length, one.frame)),
            )
            for edge in graph.edges
        ]
    return Graph(tuple(nodes), tuple(edges)) if any_tape else None


def skeleton_warnings(solved: Sequence[Solved], asked: bool) -> list[Warn]:
    """Where the skeleton leaves its tape, and where a crossing could be read in another way.

    Parameters
    ----------
    solved : sequence of Solved
    asked : bool
        Whether no method but the skeleton was asked for, so that marches only stand in for it.
    """
    out: list[Warn] = []
    for one in solved:
        if asked and one.march is not None:
            place = tuple(one.component.frame.origin[: one.frame.dimension].tolist())
            message = f"Component {one.component.label} {NO_TAPE if one.tape is None else THIN_TAPE}"
            out.append(Warn("march-instead", message, place))
    for one, taped in _taped(solved):
        leaving = (
            f"After {taped.skeleton.passes} resamplings of the border the skeleton still leaves the tape "
            "here; give a smaller resample."
        )
        out += _warned("skeleton-not-contained", leaving, _restored(one.frame, taped.skeleton.outside))
        out += _warned("ambiguous-crossing", AMBIGUOUS, one.frame.restore(taped.doubts))
        low = [m.place for m in crossings(taped.curves) if m.angle < LOW_ANGLE]
        out += _warned("ambiguous-crossing", TANGENTIAL, one.frame.restore(np.reshape(low, (-1, 3))))
        if DETAIL * one.refined.sigma > HIDDEN * one.extent:
            widest = taped.graph.places[[int(np.argmax(taped.graph.radius))]]
            out += _warned("noise-hides-detail", _hidden(one), _restored(one.frame, widest))
    return out


def _hidden(one: Solved) -> str:
    sigma = one.refined.sigma * one.frame.scale
    return (
        f"The noise, sigma {sigma:.3g}, hides branches nearer to each other than about {DETAIL * sigma:.3g}, "
        "a large part of the whole; the tape is widest here."
    )


def _warned(code: str, message: str, places: Floats) -> list[Warn]:
    return [Warn(code, message, tuple(place.tolist())) for place in places[:MOST_WARNINGS]]


def skeleton_stages(solved: Sequence[Solved]) -> SkeletonStages:
    """What Figs. 5 and 10 show, of all components together."""
    balls: list[Ball] = []
    border: list[Floats] = []
    triangles, flags, bridges, voronoi = [], [], [], []
    for one, taped in _taped(solved):
        mesh, small, axis = taped.tape.mesh, taped.tape.small, taped.skeleton.axis
        _, found = cKDTree(one.points[:, :2]).query(mesh.points)
        index = one.members[np.asarray(found, np.int64)]
        triangles.append(index[mesh.triangles])
        bridges.append(index[small.bridges].reshape(-1, 2))
        flags.append(np.stack([small.enclosed, small.small_area, small.short_edges, small.accepted]))
        # Thin triangles at the border have circumcentres far outside.
        edges = axis.places[axis.raw]
        edges = edges[shapely.covers(taped.tape.polygon, shapely.linestrings(edges))]
        ends = _restored(one.frame, edges.reshape(-1, 2))
        voronoi.append(ends.reshape(-1, 2, ends.shape[1]))
        breaks = np.flatnonzero(np.diff(axis.border.ring)) + 1
        border += [_restored(one.frame, ring) for ring in np.split(axis.border.points, breaks)]
        if one.scale is not None:
            balls += _balls(one.frame, one.scale.balls, one.component.label)
    criteria = np.concatenate(flags, axis=1) if flags else np.zeros((4, 0), np.bool_)
    dimension = len(solved[0].component.bbox[0])
    return SkeletonStages(
        tuple(balls),
        Delaunay(
            np.concatenate(triangles or [np.zeros((0, 3), np.int64)]),
            criteria[0],
            criteria[1],
            criteria[2],
            criteria[3],
            np.concatenate(bridges or [np.zeros((0, 2), np.int64)]),
        ),
        tuple(border),
        np.concatenate(voronoi or [np.zeros((0, 2, dimension))]),
    )


def _taped(solved: Sequence[Solved]) -> list[tuple[Solved, Taped]]:
    return [(one, one.tape) for one in solved if one.tape is not None]


def _scaled(lengths: float | Floats, frame: WorkingFrame) -> Floats:
    """Lengths in the user's units; beyond the largest double they cannot be said."""
    with np.errstate(over="ignore"):
        return np.asarray(np.minimum(np.multiply(lengths, frame.scale), LARGEST))


def _restored(frame: WorkingFrame, places: Floats) -> Floats:
    """Planar working coordinates (M, 2) in the user's frame, (M, d)."""
    return frame.restore(np.column_stack([places, np.zeros(len(places))]))


def _balls(frame: WorkingFrame, balls: Balls, label: int) -> list[Ball]:
    found = np.flatnonzero(balls.found)
    centres = frame.restore(balls.centre[found])
    ways = (balls.direction[found] @ frame.axes)[:, : frame.dimension]
    return [
        Ball(
            centre,
            float(_scaled(balls.radius[k], frame)),
            way,
            int(balls.samples[k]),
            label,
        )
        for k, centre, way in zip(found, centres, ways, strict=True)
    ]
