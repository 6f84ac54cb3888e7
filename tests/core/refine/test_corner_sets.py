import numpy as np
import pytest

from core.refine.corner_sets import SIDE_SAMPLES, SmoothCurve, fitted, knots_of, polished
from core.refine.polyline import Polyline
from tests.core.shapes import in_space, rotation

SIGMA = 0.01


def on(vertices, closed=False, n=3000, seed=0):
    """A polygonal course as its own smooth curve, with noisy samples of it."""
    line = Polyline(in_space(np.array(vertices, np.float64)), closed)
    rng = np.random.default_rng(seed)
    station = np.sort(rng.uniform(0.0, line.length, n))
    points = line.at(station) + in_space(SIGMA * rng.normal(size=(n, 2)))
    return SmoothCurve(points, station, line, SIGMA)


def straight(length=2.0, n=3000):
    return on([(0.0, 0.0), (length, 0.0)], n=n)


def right_angle(n=3000, seed=0):
    return on([(-1.0, 0.0), (0.0, 0.0), (0.0, 1.0)], n=n, seed=seed)


SQUARE = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2)]


# ---------------------------------------------------------------- the smooth curve and its samples


def test_lengths_grow_with_the_noise_and_with_the_spacing_of_samples():
    many, few = straight(n=3000), straight(n=30)
    assert many.spacing == pytest.approx(2.0 / 3000)
    assert SIGMA < many.look < few.look
    assert many.look < many.longest < few.longest
    # A side holds enough samples, however few there are.
    assert few.longest >= few.look + SIDE_SAMPLES * few.spacing


def test_samples_between_two_stations():
    curve = straight()
    inside = (curve.station >= 0.5) & (curve.station <= 0.75)
    np.testing.assert_array_equal(curve.between(0.5, 0.75), curve.points[inside])


def test_a_crowd_is_thinned_evenly():
    curve = straight(n=20_000)
    whole, few = curve.between(0.0, 2.0, np.inf), curve.between(0.0, 2.0, 10.0)
    assert len(whole) == 20_000
    assert 0.5 * 10.0 * 2.0 / SIGMA <= len(few) <= 10.0 * 2.0 / SIGMA
    kept = np.flatnonzero(np.isin(whole[:, 0], few[:, 0]))
    assert len(np.unique(np.diff(kept))) == 1


def test_samples_are_found_over_the_seam_of_a_closed_curve():
    curve = on(SQUARE, closed=True)
    low = 0.75  # of 0.8
    inside = (curve.station >= low) | (curve.station <= 0.05)
    np.testing.assert_array_equal(curve.between(low, 0.85), curve.points[inside])


# ---------------------------------------------------------------- sets of corners


def test_without_corners_there_are_no_sets():
    assert knots_of(np.zeros(0), np.array([1.0]), straight()) == []


def test_a_lonely_corner_has_two_sides_of_full_length():
    curve = straight()
    ((knots, ring),) = knots_of(np.array([1.0]), np.array([1.0]), curve)
    assert not ring
    np.testing.assert_allclose(knots, 1.0 + curve.longest * np.array([-1.0, 0.0, 1.0]))


def test_sides_end_with_an_open_curve():
    curve = straight()
    ((knots, _),) = knots_of(np.array([0.1]), np.array([0.1]), curve)
    np.testing.assert_allclose(knots, [0.0, 0.1, 0.1 + curve.longest], atol=1e-12)


def test_corners_within_a_side_of_each_other_share_it():
    curve = straight()
    kept = 1.0 + 0.8 * curve.longest * np.array([0.0, 1.0])
    ((knots, _),) = knots_of(kept, kept, curve)
    np.testing.assert_allclose(knots[1:3], kept)
    kept = np.array([0.5, 0.5 + 1.2 * curve.longest])
    assert [len(knots) for knots, _ in knots_of(kept, kept, curve)] == [3, 3]


def test_no_side_runs_over_a_bend_that_is_no_corner():
    curve = straight()
    kept = 1.0 + 0.9 * curve.longest * np.array([0.0, 1.0])
    bends = np.array([kept[0], kept.mean(), kept[1]])
    first, second = (knots for knots, _ in knots_of(kept, bends, curve))
    assert first[-1] < bends[1] < second[0]


def test_corners_all_around_a_closed_curve_make_a_ring():
    curve = on(SQUARE, closed=True)
    corners = np.array([0.0, 0.2, 0.4, 0.6])
    ((knots, ring),) = knots_of(corners, corners, curve)
    assert ring
    np.testing.assert_allclose(knots, [0.0, 0.2, 0.4, 0.6, 0.8])


def test_a_set_may_run_over_the_seam():
    curve = on([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], closed=True)
    corners = np.array([0.05, 3.9])
    ((knots, ring),) = knots_of(corners, corners, curve)
    assert not ring
    np.testing.assert_allclose(knots[1:3], [3.9, 4.05])


# ---------------------------------------------------------------- fits


@pytest.mark.parametrize("seed", range(3))
def test_a_fitted_corner_is_where_the_strokes_meet(seed):
    curve = right_angle(seed=seed)
    ((knots, ring),) = knots_of(np.array([1.0]), np.array([1.0]), curve)
    fit = fitted(knots, ring, curve)
    np.testing.assert_array_equal(fit.corners, knots[1:-1])
    assert fit.sides(0) == (0, 1)
    assert np.linalg.norm(fit.place(0)) < SIGMA
    # Straight sides remain straight: their own bend is within its error.
    assert not fit.strokes.bent.any()


def test_a_ring_has_as_many_corners_as_sides():
    curve = on(SQUARE, closed=True)
    ((knots, ring),) = knots_of(np.array([0.0, 0.2, 0.4, 0.6]), np.zeros(0), curve)
    fit = fitted(knots, ring, curve)
    np.testing.assert_array_equal(fit.corners, knots[:-1])
    assert [fit.sides(j) for j in range(4)] == [(3, 0), (0, 1), (1, 2), (2, 3)]
    places = np.array([fit.place(j)[:2] for j in range(4)])
    assert np.linalg.norm(places - SQUARE, axis=1).max() < SIGMA
    stations = fit.node_stations
    assert np.all(np.diff(stations) > 0.0)
    assert 0.0 < stations[0] < stations[-1] < 0.8


def test_a_fit_turns_with_the_frame():
    curve = right_angle()
    knots = np.array([0.8, 1.0, 1.2])
    turn = rotation(np.random.default_rng(0), 3).T
    line = Polyline(curve.line.vertices @ turn, False)
    turned = SmoothCurve(curve.points @ turn, curve.station, line, SIGMA)
    here, there = fitted(knots, False, curve), fitted(knots, False, turned)
    np.testing.assert_allclose(there.strokes.control, here.strokes.control @ turn, atol=1e-9)


def test_without_samples_a_set_stays_where_it_begins():
    curve = right_angle()
    bare = SmoothCurve(np.zeros((0, 3)), np.zeros(0), curve.line, SIGMA)
    knots = np.array([0.8, 1.0, 1.2])
    fit = fitted(knots, False, bare)
    np.testing.assert_allclose(fit.strokes.control[::2], curve.line.at(knots))


def test_polishing_takes_all_samples_in():
    curve = right_angle(n=40_000)
    knots = np.array([0.8, 1.0, 1.2])
    fit = fitted(knots, False, curve)
    best = polished(fit, curve)
    assert len(fit.samples) < len(best.samples) == np.count_nonzero(np.abs(curve.station - 1.0) <= 0.2)
    assert np.linalg.norm(best.place(0)) < 0.25 * SIGMA
    assert best.strokes.error_at(0, np.array([1.0]), True) < fit.strokes.error_at(0, np.array([1.0]), True)


def test_there_is_nothing_to_polish_where_all_samples_were_taken():
    curve = right_angle(n=1000)
    fit = fitted(np.array([0.8, 1.0, 1.2]), False, curve)
    assert polished(fit, curve) is fit
