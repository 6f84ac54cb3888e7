import numpy as np
import pytest

from core.refine.corner_evidence import LEAST_TURN, sharp_ones
from core.refine.corner_sets import SmoothCurve, fitted, knots_of
from core.refine.polyline import Polyline
from tests.core.shapes import in_space, rotation

SIGMA = 0.01


def stretch(course, corners, n=4000, smoothing=8.0, seed=0, closed=False):
    """Noisy samples of a course, which a window rounds off as the regression does, and a set of corners.

    Parameters
    ----------
    course : (M, 2) array
    corners : stations of the rivals
    smoothing : half-width of the window, in sigma
    """
    truth = Polyline(in_space(np.asarray(course, np.float64)), closed)
    rng = np.random.default_rng(seed)
    station = np.sort(rng.uniform(0.0, truth.length, n))
    points = truth.at(station) + in_space(SIGMA * rng.normal(size=(n, 2)))
    at = np.linspace(0.0, truth.length, 400, endpoint=not closed)
    window = smoothing * SIGMA * np.linspace(-1.0, 1.0, 33)
    weight = 1.0 - np.linspace(-1.0, 1.0, 33) ** 2
    seen = truth.at((at[:, None] + window).ravel()).reshape(len(at), 33, 3)
    smooth = Polyline(np.einsum("kwc,w->kc", seen, weight) / weight.sum(), closed)
    curve = SmoothCurve(points, station * (smooth.length / truth.length), smooth, SIGMA)
    kept = np.asarray(corners) * (smooth.length / truth.length)
    ((knots, ring),) = knots_of(kept, kept, curve)
    return fitted(knots, ring, curve), curve


def bent(degrees):
    angle = np.radians(degrees)
    return np.array([(-1.0, 0.0), (0.0, 0.0), (np.cos(angle), np.sin(angle))])


def filleted(radius, degrees=90):
    """Two strokes that an arc joins, and the station of its middle."""
    angle = np.radians(degrees)
    t = np.linspace(0.0, angle, 60)
    arc = radius * np.column_stack((np.sin(t), 1.0 - np.cos(t)))
    far = arc[-1] + np.array([np.cos(angle), np.sin(angle)])
    return np.concatenate([[(-1.0, 0.0)], arc, [far]]), 1.0 + 0.5 * radius * angle


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("degrees", [50, 90, 130])
def test_a_corner_is_one(degrees, seed):
    assert sharp_ones(*stretch(bent(degrees), [1.0], seed=seed)).tolist() == [True]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("radius", [6.0, 10.0])
def test_an_arc_is_none(radius, seed):
    course, middle = filleted(radius * SIGMA)
    assert sharp_ones(*stretch(course, [middle], seed=seed)).tolist() == [False]


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_course_has_none(seed):
    assert sharp_ones(*stretch(bent(0), [1.0], seed=seed)).tolist() == [False]


def test_a_gentle_turn_is_none_however_many_samples_tell_it():
    gentle = 0.8 * np.degrees(LEAST_TURN)
    assert sharp_ones(*stretch(bent(gentle), [1.0], n=20_000)).tolist() == [False]


def test_too_few_samples_tell_no_corner():
    assert sharp_ones(*stretch(bent(60), [1.0], n=60)).tolist() == [False]


def test_each_corner_of_a_set_is_judged_by_itself():
    # The second rival stands on a straight stretch.
    assert sharp_ones(*stretch(bent(90), [1.0, 1.2])).tolist() == [True, False]


def test_all_corners_of_a_ring_are_found():
    side = 0.2
    square = side * np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    fit, curve = stretch(square, side * np.arange(4), n=2000, closed=True)
    assert fit.strokes.ring
    assert sharp_ones(fit, curve).tolist() == [True] * 4


@pytest.mark.parametrize("degrees", [0, 90])
def test_the_frame_does_not_matter(degrees):
    fit, curve = stretch(bent(degrees), [1.0])
    turn = rotation(np.random.default_rng(1), 3).T
    line = Polyline(3.0 * curve.line.vertices @ turn, False)
    turned = SmoothCurve(3.0 * curve.points @ turn, 3.0 * curve.station, line, 3.0 * SIGMA)
    there = fitted(3.0 * fit.knots, False, turned)
    np.testing.assert_array_equal(sharp_ones(there, turned), sharp_ones(fit, curve))
