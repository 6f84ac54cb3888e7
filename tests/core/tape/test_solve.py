from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.crossings import crossings
from core.tape.small_triangles import Smallness
from core.tape.solve import Choices, solve_tape
from tests.core.shapes import arc, distances, line
from tests.core.tape.drawings import circle, eight, flat, segment
from tests.core.tape.samples import along, measured

SIGMA = 0.02
SEEDS = st.integers(0, 2**32 - 1)


def solved(points, choices=None):
    return solve_tape(*measured(points), choices or Choices())


def kinds(taped):
    """Numbers of closed and open curves."""
    closed = sum(one.closed for one in taped.curves)
    return closed, len(taped.curves) - closed


def off(taped, truth):
    return max(distances(one.vertices, truth.vertices, truth.closed).max() for one in taped.curves)


@settings(max_examples=5, deadline=None)
@given(SEEDS)
def test_a_circle_is_one_closed_curve(seed):
    taped = solved(arc(600, SIGMA, seed=seed))
    assert kinds(taped) == (1, 0)
    assert taped.curves[0].length == pytest.approx(2.0 * np.pi, rel=0.05)
    assert off(taped, circle()) < 2.0 * SIGMA
    assert taped.sigma == pytest.approx(SIGMA, rel=0.2)
    assert taped.explained > 0.98
    assert len(taped.doubts) == 0


@pytest.mark.parametrize("seed", range(3))
def test_an_eight_is_one_closed_curve_that_crosses_itself_once(seed):
    taped = solved(along(eight(), 1000, SIGMA, seed))
    assert kinds(taped) == (1, 0)
    (meeting,) = crossings(taped.curves)
    np.testing.assert_allclose(meeting.place, 0.0, atol=4.0 * SIGMA)
    assert off(taped, eight()) < 2.5 * SIGMA
    assert taped.explained > 0.98
    # The graph has its crossing as one node.
    assert taped.graph.degree.tolist() == [4]
    assert len(taped.graph.edges) == 2


@pytest.mark.parametrize("seed", range(3))
def test_a_segment_is_one_open_curve(seed):
    taped = solved(line(500, SIGMA, 4.0, seed))
    assert kinds(taped) == (0, 1)
    assert taped.curves[0].length == pytest.approx(4.0, rel=0.06)
    assert off(taped, flat([(-2.2, 0.0), (2.2, 0.0)])) < 2.5 * SIGMA
    assert taped.explained > 0.98


def test_two_lines_cross():
    bars = [segment((-1, -0.4), (1, 0.4)), segment((-1, 0.4), (1, -0.4))]
    taped = solved(np.concatenate([along(bar, 500, SIGMA, k) for k, bar in enumerate(bars)]))
    assert kinds(taped) == (0, 2)
    assert len(crossings(taped.curves)) == 1


def test_circles_one_in_another_are_two_curves():
    taped = solved(np.concatenate([arc(500, SIGMA), arc(900, SIGMA, radius=2.0, seed=1)]))
    assert kinds(taped) == (2, 0)


@pytest.mark.parametrize("slope", [0.0, 0.7])
def test_collinear_points_have_no_tape(slope):
    x = np.linspace(-1.0, 1.0, 300)
    assert solved(np.column_stack((x, np.zeros(300))) @ np.array([[1, slope], [-slope, 1]])) is None


@settings(max_examples=3, deadline=None)
@given(SEEDS)
def test_what_is_found_belongs_together(seed):
    taped = solved(arc(500, SIGMA, turn=4.0, seed=seed))
    assert kinds(taped) == (0, 1)
    assert taped.tape.polygon.is_valid
    assert 0.0 <= taped.explained <= 1.0
    assert np.isfinite(taped.nats)
    assert taped.doubts.shape[1] == 3
    assert all(np.all(one.vertices[:, 2] == 0.0) for one in taped.curves)


def test_what_an_expert_fixes_is_used():
    points = arc(600, SIGMA)
    usual = solved(points)
    fine = solved(points, Choices(resample=0.01))
    assert len(fine.skeleton.axis.border.points) > 2 * len(usual.skeleton.axis.border.points)
    tight = solved(points, replace(Choices(), smallness=Smallness(f_l=2.0, f_a=1.0)))
    assert not np.array_equal(tight.tape.small.accepted, usual.tape.small.accepted)
    assert kinds(tight) == (1, 0)


def test_hair_is_pruned_unless_told_otherwise():
    edges = np.array(
        [
            [len(solved(arc(600, 0.05, seed=seed), Choices(prune=prune)).graph.edges) for seed in range(4)]
            for prune in (0.0, None)
        ]
    )
    assert np.all(edges[1] == 1)
    assert edges[0].max() > 1
