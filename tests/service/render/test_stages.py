from __future__ import annotations

import dataclasses
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import Delaunay as Triangulation

from core.results import Delaunay, Graph, Reconstruction, SkeletonStages
from render.results import TRIANGLES, VORONOI, cloud, skeleton
from service.render import scene
from service.render.scenes import Scene, Sheet
from service.render.stages import MOST_SHAPES

NAMES = ["balls", "delaunay", "triangles", "tape", "border", "voronoi", "graph", "curves"]


def panels(result: Reconstruction, points: np.ndarray) -> dict[str, Scene]:
    sheet = scene(result, points)
    assert isinstance(sheet, Sheet)
    return sheet.panels


def triangulated(points: np.ndarray) -> Reconstruction:
    """A skeleton of which every triangle is accepted, half of them for lying in a ball."""
    made = skeleton(stages=True)
    assert isinstance(made.stages, SkeletonStages)
    triangles = Triangulation(points).simplices.astype(np.int64)
    half, none = np.arange(len(triangles)) % 2 == 0, np.zeros(len(triangles), bool)
    delaunay = Delaunay(triangles, half, ~half, none, ~none, np.zeros((0, 2), int))
    return dataclasses.replace(made, stages=dataclasses.replace(made.stages, delaunay=delaunay))


def test_the_stages_come_in_the_order_of_the_work() -> None:
    assert list(panels(skeleton(stages=True), cloud())) == NAMES


def test_every_edge_of_the_triangulation_is_drawn_once() -> None:
    (edges,) = panels(skeleton(stages=True), cloud())["delaunay"].segments
    pairs = {frozenset(pair) for row in TRIANGLES.tolist() for pair in combinations(row, 2)}
    drawn = {frozenset(map(tuple, ends)) for ends in edges.ends.tolist()}
    assert len(edges.ends) == len(pairs)
    assert drawn == {frozenset(tuple(cloud()[k].tolist()) for k in pair) for pair in pairs}


def test_triangles_are_coloured_by_what_they_are_kept_for() -> None:
    shown = panels(skeleton(stages=True), cloud())["triangles"]
    assert [area.name for area in shown.areas] == ["enclosed", "small area", "short edges", "hole filled"]
    assert len({area.colour for area in shown.areas}) == 4
    for area, triangle in zip(shown.areas, TRIANGLES, strict=False):
        assert [ring.tolist() for ring in area.rings] == [cloud()[triangle].tolist()]
    (bridges,) = shown.segments
    assert bridges.ends.tolist() == [cloud()[[7, 8]].tolist(), cloud()[[8, 9]].tolist()]


def test_the_border_the_voronoi_edges_and_the_graph_lie_on_the_tape() -> None:
    shown = panels(skeleton(stages=True), cloud())
    assert len(shown["border"].dots[0].points) == 8
    assert np.array_equal(shown["voronoi"].segments[0].ends, VORONOI)
    assert [len(path.vertices) for path in shown["graph"].paths] == [3, 3]
    assert len(shown["graph"].marks[0].points) == 2
    assert all(len(shown[name].areas) == 2 for name in ("tape", "border", "voronoi", "graph", "curves"))


def test_many_triangles_are_drawn_as_dots_and_many_edges_thinned_out() -> None:
    points = cloud(MOST_SHAPES)
    shown = panels(triangulated(points), points)
    assert len(shown["delaunay"].segments[0].ends) == MOST_SHAPES
    assert not shown["triangles"].areas
    kept = [len(group.points) for group in shown["triangles"].dots]
    assert sum(kept) == len(Triangulation(points).simplices)


def test_the_longest_edges_stay_when_many_are_thinned_out() -> None:
    points = np.vstack([cloud(MOST_SHAPES), [[900.0, 900.0]]])
    (edges,) = panels(triangulated(points), points)["delaunay"].segments
    assert (edges.ends == 900.0).any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_samples_without_a_tape_have_empty_stages(dimension: int) -> None:
    none = np.zeros(0, bool)
    empty = SkeletonStages(
        (),
        Delaunay(np.zeros((0, 3), int), none, none, none, none, np.zeros((0, 2), int)),
        (),
        np.zeros((0, 2, dimension)),
    )
    bare = dataclasses.replace(skeleton(dimension), tape=(), graph=Graph((), ()), stages=empty)
    shown = panels(bare, cloud(50, dimension))
    assert list(shown) == NAMES
    assert not shown["voronoi"].segments[0].ends.size
    assert len(shown["curves"].paths) == 1
