import numpy as np
import pytest

from core.diagnosis.junctions import Junctions
from core.diagnosis.meetings import doubtful_meetings
from core.refine.polyline import Polyline
from tests.core.shapes import in_space

HALF = 60.0


def stroke(slope, half_gap=0.0, side=1.0):
    x = np.linspace(-HALF, HALF, 481)
    y = slope * x if half_gap == 0.0 else side * np.sqrt((slope * x) ** 2 + half_gap**2)
    return np.column_stack((x, y))


def samples(courses, n, seed):
    rng = np.random.default_rng(seed)
    picked = [course[rng.integers(0, len(course), n // len(courses))] for course in courses]
    places = np.concatenate(picked)
    return in_space(places + rng.normal(size=places.shape))


def crossed(slope):
    return [Polyline(in_space(stroke(sign * slope)), False) for sign in (1.0, -1.0)]


@pytest.mark.parametrize("slope", [0.3, 0.6, 1.0])
def test_branches_that_cross_are_not_doubted(slope):
    doubted = sum(
        bool(doubtful_meetings(samples([stroke(slope), stroke(-slope)], 4000, seed), crossed(slope), 1.0))
        for seed in range(20)
    )
    assert doubted == 0


@pytest.mark.parametrize("slope", [0.3, 0.6])
def test_branches_that_touch_are_not_taken_for_a_crossing(slope):
    courses = [stroke(slope, 1.75, side) for side in (1.0, -1.0)]
    for seed in range(5):
        (doubt,) = doubtful_meetings(samples(courses, 4000, seed), crossed(slope), 1.0)
        assert np.linalg.norm(doubt.place) < 1e-6
        assert doubt.gap == pytest.approx(3.5, rel=0.35)


def test_branches_that_stay_together_are_told():
    x = np.linspace(-HALF, HALF, 481)
    braid = [Polyline(in_space(np.column_stack((x, sign * np.sin(x / 4.0)))), False) for sign in (1.0, -1.0)]
    doubts = doubtful_meetings(samples([b.vertices[:, :2] for b in braid], 2000, 0), braid, 1.0)
    assert doubts
    assert all(doubt.gap <= 2.0 + 1e-9 for doubt in doubts)


def test_without_noise_there_is_no_doubt():
    assert doubtful_meetings(samples([stroke(0.5)], 100, 0), crossed(0.5), 0.0) == []


def test_a_crossing_explains_what_is_near_it():
    junctions = Junctions.of(crossed(0.5), 1.0, True)
    assert junctions.explain(np.array([2.0, 0.0, 0.0]), 2.0)
    assert not junctions.explain(np.array([40.0, 0.0, 0.0]), 3.0)


def test_an_end_on_another_branch_explains_what_is_near_it():
    bar = Polyline(in_space(np.array([(-HALF, 0.0), (HALF, 0.0)])), False)
    post = Polyline(in_space(np.column_stack((np.zeros(100), np.linspace(1.0, HALF, 100)))), False)
    junctions = Junctions.of([bar, post], 1.0, True)
    assert len(junctions.places) == 1
    assert junctions.explain(np.array([1.0, 1.0, 0.0]), 1.5)
    apart = Polyline(post.vertices + np.array([0.0, 10.0, 0.0]), False)
    assert len(Junctions.of([bar, apart], 1.0, True).places) == 0


def test_the_sides_of_a_wedge_are_near_because_they_meet():
    x = np.linspace(0.0, HALF, 400)
    wedge = np.concatenate(
        (np.column_stack((x[::-1], 0.15 * x[::-1])), np.column_stack((x[1:], -0.15 * x[1:])))
    )
    junctions = Junctions.of([Polyline(in_space(wedge), False)], 0.2, True)
    assert junctions.explain(np.array([2.0, 0.0, 0.0]), 0.6)


def test_the_strokes_of_a_hairpin_are_not():
    x = np.linspace(0.0, HALF, 400)
    strokes = np.concatenate((np.column_stack((x[::-1], 0 * x + 0.4)), np.column_stack((x, 0 * x - 0.4))))
    junctions = Junctions.of([Polyline(in_space(strokes), False)], 0.2, True)
    assert not junctions.explain(np.array([30.0, 0.0, 0.0]), 0.8)
