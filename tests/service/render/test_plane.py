from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import pdist
from scipy.stats import special_ortho_group

from core.surface.axis import axis_frame
from render.results import cloud
from service.render.plane import paper_of, three_quarter


def test_the_plane_is_its_own_paper() -> None:
    points = cloud()
    assert np.array_equal(paper_of([points])(points), points)


@given(st.integers(0, 100), st.floats(-1e6, 1e6))
def test_planar_sets_keep_all_distances(seed: int, offset: float) -> None:
    flat = np.column_stack([cloud(20), np.zeros(20)])
    points = flat @ special_ortho_group.rvs(3, random_state=seed).T + offset
    drawn = paper_of([points[:12], points[12:]])(points)
    assert drawn.shape == (20, 2)
    assert np.allclose(pdist(drawn), pdist(flat), atol=1e-9 * (1 + abs(offset)))


def test_level_planes_are_seen_from_above_with_y_up() -> None:
    points = np.column_stack([cloud(20), np.full(20, 7.0)])
    assert np.allclose(paper_of([points])(points), points[:, :2] - points[:, :2].mean(axis=0))


@pytest.mark.parametrize("axis", [0, 1])
def test_upright_planes_are_seen_with_z_up(axis: int) -> None:
    points = np.insert(cloud(20), axis, 3.0, axis=1)
    drawn = paper_of([points])(points)
    assert np.allclose(np.diff(drawn[:, 1]), np.diff(points[:, 2]))
    assert np.allclose(np.diff(drawn[:, 0]), np.diff(points[:, 1 - axis]))


@pytest.mark.parametrize(
    "points", [np.zeros((3, 3)), np.ones((1, 3)), np.empty((0, 3)), np.full((4, 3), -1e90)]
)
def test_points_without_a_plane_are_drawn_somewhere(points: np.ndarray) -> None:
    assert np.isfinite(paper_of([points])(points)).all()


def test_a_line_keeps_its_length() -> None:
    points = np.linspace(0, 1, 9)[:, None] * np.array([1.0, 2.0, 2.0])
    drawn = paper_of([points])(points)
    assert np.linalg.norm(drawn[-1] - drawn[0]) == pytest.approx(3.0)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 2.0, -2.0), (0.0, 0.0, -1.0)])
def test_one_looks_from_the_front_right_and_above(axis: tuple[float, float, float]) -> None:
    frame = axis_frame(axis).axes
    look = three_quarter(frame)
    assert look @ look.T == pytest.approx(np.eye(3))
    assert np.linalg.det(look) == pytest.approx(1.0)
    right, back, up = frame @ look.T  # as they are seen
    assert up[0] == pytest.approx(0.0)
    assert up[1] > 0.0
    assert right[0] > 0.0
    assert [right[2] > 0.0, back[2] < 0.0, up[2] > 0.0] == [True] * 3  # these sides turn to the eye


def test_from_higher_up_one_sees_more_of_the_top() -> None:
    tops = [three_quarter(np.eye(3), above)[2, 2] for above in (0.1, 0.5, 1.2)]
    assert tops == pytest.approx(np.sin([0.1, 0.5, 1.2]))
