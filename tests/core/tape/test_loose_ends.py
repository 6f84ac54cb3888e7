import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.sampling import Sample
from core.refine.project import project
from core.tape.loose_ends import joined
from tests.core.shapes import arc, distances, in_space, line
from tests.core.tape.drawings import circle, flat, segment

SIGMA, RADIUS = 0.01, 0.2
LOG_N = np.log(2000)


def bow(start, end):
    angle = np.linspace(start, end, 100)
    return flat(np.column_stack((np.cos(angle), np.sin(angle))))


def joined_on(points, *curves, sigma=SIGMA, radius=RADIUS, thinned=1):
    """Join curves by all samples, with the feet of one in ``thinned``."""
    sample = Sample.of(in_space(points))
    feet = project(sample.points[::thinned], list(curves), 4.0 * sigma)
    return joined(sample, list(curves), feet, 1.0 / thinned, sigma, radius)


def shifted(points, x, y):
    return points + np.array((x, y))


def reversed_if(back, curve):
    return flat(curve.vertices[::-1, :2]) if back else curve


@pytest.mark.parametrize("turned", [(False, False), (True, False), (False, True), (True, True)])
@pytest.mark.parametrize("gap", [0.02, 2.0 * np.pi * LOG_N / 2000])
def test_halves_of_a_ring_are_closed_over_gaps_of_chance(gap, turned):
    angle = np.arctan2(*arc(2000, 0.0).T[::-1])
    points = arc(2000, SIGMA)[np.minimum(np.abs(angle), np.abs(np.pi - np.abs(angle))) > 0.5 * gap]
    halves = bow(0.5 * gap, np.pi - 0.5 * gap), bow(np.pi + 0.5 * gap, 2.0 * np.pi - 0.5 * gap)
    (curve,) = joined_on(points, *map(reversed_if, turned, halves))
    assert curve.closed
    assert distances(circle().vertices, curve.vertices, True).max() < SIGMA
    assert curve.length == pytest.approx(2.0 * np.pi, rel=0.02)


def test_the_ends_of_one_curve_close_it():
    (curve,) = joined_on(arc(2000, SIGMA), bow(0.02, 2.0 * np.pi - 0.02))
    assert curve.closed


@pytest.mark.parametrize("turn", [5.0, 6.0])
def test_a_gap_too_long_for_chance_stays_open(turn):
    (curve,) = joined_on(arc(2000, SIGMA, turn=turn), bow(0.02, turn - 0.02))
    assert not curve.closed
    truth = np.array([(1.0, 0.0, 0.0), (np.cos(turn), np.sin(turn), 0.0)])
    gaps = np.linalg.norm(curve.vertices[[0, -1]][:, None] - truth, axis=2)
    assert min(gaps[[0, 1], [0, 1]].max(), gaps[[0, 1], [1, 0]].max()) < 4.0 * SIGMA


def test_two_strokes_far_from_each_other_stay_two():
    points = np.concatenate(
        [shifted(line(1000, SIGMA), -0.8, 0.0), shifted(line(1000, SIGMA, seed=1), 0.8, 0.0)]
    )
    curves = joined_on(points, segment((-1.3, 0.0), (-0.3, 0.0)), segment((0.3, 0.0), (1.3, 0.0)))
    assert [curve.closed for curve in curves] == [False, False]


@pytest.mark.parametrize("seed", range(3))
def test_pieces_of_a_stroke_become_one_in_whatever_order(seed):
    rng = np.random.default_rng(seed)
    pieces = [segment((x, 0.0), (x + 0.45, 0.0)) for x in (-0.98, -0.48, 0.02, 0.52)]
    chosen = [reversed_if(rng.integers(2), pieces[k]) for k in rng.permutation(4)]
    (curve,) = joined_on(line(2000, SIGMA, 2.0, seed), *chosen)
    assert not curve.closed
    assert np.ptp(curve.vertices[:, 0]) == pytest.approx(2.0, abs=0.05)
    assert np.abs(curve.vertices[:, 1]).max() < SIGMA
    assert np.all(np.diff(curve.vertices[:, 0]) > 0) or np.all(np.diff(curve.vertices[:, 0]) < 0)


def test_arms_that_meet_are_joined_straight_on():
    points = np.concatenate([line(1000, SIGMA, 2.0, 1), line(1000, SIGMA, 2.0, 2)[:, ::-1]])
    arms = [
        segment(start, 20.0 * np.array(start))
        for start in np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * 0.05
    ]
    curves = joined_on(points, *arms)
    assert len(curves) == 2
    for curve in curves:
        assert not curve.closed
        spread = np.sort(np.ptp(curve.vertices[:, :2], axis=0))
        assert spread[0] < 2.0 * SIGMA
        assert spread[1] == pytest.approx(2.0, abs=0.05)


def test_parallel_strokes_are_not_joined():
    points = np.concatenate([shifted(line(1000, SIGMA, 2.0, k), 0.0, 8.0 * k * SIGMA) for k in (0, 1)])
    curves = joined_on(points, *(segment((-0.98, y), (0.98, y)) for y in (0.0, 8.0 * SIGMA)))
    assert len(curves) == 2
    assert sorted(round(float(np.median(c.vertices[:, 1])) / SIGMA) for c in curves) == [0, 8]


@pytest.mark.parametrize("offset", [0.0, 0.5, 1.0])
def test_a_curve_along_another_is_dropped(offset):
    beside = bow(1.0, 2.5)
    beside = flat((1.0 + offset * SIGMA) * beside.vertices[:, :2])
    (curve,) = joined_on(arc(2000, SIGMA), beside, circle())
    assert curve.closed
    assert curve.length == pytest.approx(2.0 * np.pi, rel=0.02)


def test_closed_curves_stay_as_they_are():
    (curve,) = joined_on(arc(2000, SIGMA), circle())
    assert curve.closed
    assert distances(curve.vertices, circle().vertices, True).max() < 0.2 * SIGMA


def test_curves_without_length_or_no_curves_at_all():
    points = arc(2000, SIGMA)
    assert joined_on(points, flat([(1.0, 0.0), (1.0, 0.0)])) == []
    (curve,) = joined_on(points, flat([(1.0, 0.0), (1.0, 0.0)]), circle())
    assert curve.closed


@pytest.mark.parametrize("thinned", [2, 4])
def test_a_few_feet_tell_as_much(thinned):
    halves = bow(0.02, np.pi - 0.02), bow(np.pi + 0.02, 2.0 * np.pi - 0.02)
    (curve,) = joined_on(arc(2000, SIGMA), *halves, thinned=thinned)
    assert curve.closed
    (curve,) = joined_on(arc(2000, SIGMA, turn=5.0), bow(0.02, 4.98), thinned=thinned)
    assert not curve.closed


@settings(max_examples=10, deadline=None)
@given(st.integers(-40, 40), st.floats(0.0, 2.0 * np.pi), st.booleans())
def test_the_unit_and_the_direction_change_nothing(exponent, angle, whole):
    factor = 2.0**exponent
    turn = factor * np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    span = 2.0 * np.pi if whole else 5.0
    points, curve = arc(600, SIGMA, turn=span), bow(0.05, span - 0.05)
    (one,) = joined_on(points, curve)
    moved = flat(curve.vertices[:, :2] @ turn.T)
    (other,) = joined_on(points @ turn.T, moved, sigma=factor * SIGMA, radius=factor * RADIUS)
    assert one.closed == other.closed == whole
    back = other.vertices[:, :2] @ turn / factor**2
    assert distances(in_space(back), one.vertices, one.closed).max() < 1e-6
