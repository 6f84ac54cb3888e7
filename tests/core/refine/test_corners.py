import numpy as np
import pytest

from core.cloud.sampling import Sample
from core.refine.corners import Corner, find_corners, sharpened
from core.refine.course import Rules
from core.refine.pieces import cornered, fit_pieces
from core.refine.polyline import Polyline
from core.refine.principal_curve import refine_curves
from core.refine.project import project
from core.refine.shares import Share
from core.truth import point_set
from tests.core.shapes import arc, distances, in_space, rotation

SIGMA = 0.01


def bent(angle, n=3000, sigma=SIGMA, seed=0):
    """Samples of two unit strokes from the origin that turn by ``angle``, and the strokes."""
    rng = np.random.default_rng(seed)
    ends = np.array([(-1.0, 0.0), (0.0, 0.0), (np.cos(angle), np.sin(angle))])
    t = rng.uniform(-1.0, 1.0, n)
    points = np.where(t[:, None] < 0, -t[:, None] * ends[0], t[:, None] * ends[2])
    return in_space(points + sigma * rng.normal(size=points.shape)), Polyline(in_space(ends), False)


def corner_at(line, s, reach=0.1):
    """A corner a tenth beyond a curve about the origin, with sides that follow it."""
    offsets = np.linspace(-reach, reach, 11)
    before, after = line.at(s + offsets[:5]), line.at(s + offsets[6:])
    errors = np.full(5, 0.02), 0.03, np.full(5, 0.02)
    return Corner(s, 1.1 * line.at(np.array([s]))[0], s - reach, s + reach, before, after, errors)


def smoothed(points, line, sigma=SIGMA):
    """The curve as the regression leaves it, and the stations of the samples on it."""
    (curve,) = refine_curves(Sample.of(points), [line.resampled(0.02)], sigma, True, corners=False).curves
    feet = project(points, [curve], 5 * sigma)
    near = feet.curve == 0
    return curve, points[near], feet.station[near]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("degrees", [60, 90, 120])
def test_a_corner_is_found_in_its_place(degrees, seed):
    points, line = bent(np.radians(degrees), n=30_000, seed=seed)
    curve, near, station = smoothed(points, line)
    (corner,) = find_corners(near, station, curve, SIGMA)
    assert np.linalg.norm(corner.place) < SIGMA
    assert corner.low < corner.station < corner.high
    assert corner.station == pytest.approx(1.0, abs=5 * SIGMA)


@pytest.mark.parametrize("seed", range(3))
def test_a_smooth_curve_has_none(seed):
    for radius in (1.0, 0.3):
        points = in_space(arc(3000, SIGMA, radius, seed=seed))
        angle = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
        ring = Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), True)
        curve, near, station = smoothed(points, ring)
        assert find_corners(near, station, curve, SIGMA) == []


def test_a_gentle_bend_is_no_corner():
    points, line = bent(np.radians(15))
    curve, near, station = smoothed(points, line)
    assert find_corners(near, station, curve, SIGMA) == []


def test_a_corner_turns_with_the_frame():
    points, line = bent(np.pi / 2)
    curve, near, station = smoothed(points, line)
    (here,) = find_corners(near, station, curve, SIGMA)
    turn = rotation(np.random.default_rng(0), 3).T
    (there,) = find_corners(near @ turn, station, Polyline(curve.vertices @ turn, False), SIGMA)
    np.testing.assert_allclose(there.place, here.place @ turn, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_between_straight_chords_rounding_does_not_choose_the_place(seed):
    # Wherever both chords are straight the turn is the same: a whole stretch about the corner has the most.
    points, line = bent(np.pi / 2)
    station = project(points, [line], 5 * SIGMA).station
    (here,) = find_corners(points, station, line, SIGMA)
    assert here.station == pytest.approx(1.0, abs=SIGMA)
    rng = np.random.default_rng(seed)
    turn, scale = rotation(rng, 3).T, rng.uniform(0.5, 2.0)
    turned = Polyline(scale * line.vertices @ turn, False)
    (there,) = find_corners(scale * points @ turn, scale * station, turned, scale * SIGMA)
    assert there.station == pytest.approx(scale * here.station, rel=1e-9)
    assert len(there.before) == len(here.before)
    assert len(there.after) == len(here.after)


@pytest.mark.parametrize("name", ["square", "star"])
def test_all_corners_of_a_polygon_are_sharp(name):
    sample = point_set(name, n=20_000, sigma=0.0025, seed=1)
    (truth,) = sample.curves
    first = Polyline(in_space(truth.vertices[::20]), True)
    (curve,) = refine_curves(Sample.of(in_space(sample.points)), [first], sample.sigma, True).curves
    ring = np.concatenate((truth.vertices[-1:], truth.vertices, truth.vertices[:1]))
    steps = np.diff(ring, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    corners = truth.vertices[np.einsum("ij,ij->i", steps[:-1], steps[1:]) < 0.9]
    assert len(corners) == (4 if name == "square" else 10)
    assert distances(in_space(corners), curve.vertices, True).max() < sample.sigma


def test_without_noise_or_samples_there_is_nothing_to_decide():
    points, line = bent(np.pi / 2)
    curve, near, station = smoothed(points, line)
    assert find_corners(near, station, curve, 0.0) == []
    assert find_corners(near[:10], station[:10], curve, SIGMA) == []


def test_sharpening_puts_the_corner_into_the_course():
    points, line = bent(np.pi / 2)
    curve, near, station = smoothed(points, line)
    found = find_corners(near, station, curve, SIGMA)
    sharp = sharpened(curve, found)
    assert any(np.array_equal(v, found[0].place) for v in sharp.vertices)
    # Outside the corner's reach nothing moves.
    away = np.abs(curve.stations - found[0].station) > found[0].high - found[0].station
    kept = {tuple(v) for v in sharp.vertices.tolist()}
    assert {tuple(v) for v in curve.vertices[away].tolist()} <= kept
    assert sharpened(curve, []) is curve


def test_pieces_meet_in_the_corner_and_follow_the_strokes():
    points, line = bent(np.pi / 2, n=10_000)
    curve, near, station = smoothed(points, line)
    found = find_corners(near, station, curve, SIGMA)
    sharp = cornered(curve, found)
    assert sharp.marks.tolist() == [0, sharp.marks[1], len(sharp.line.vertices) - 1]
    feet = project(near, [sharp.line], 1.0)
    share = Share(np.arange(len(near)), feet.station, feet.distance, None)
    fitted, error = fit_pieces(near, share, sharp, SIGMA, Rules(1, 4.0, None))
    assert len(error) == len(fitted.vertices)
    assert not fitted.closed
    assert np.linalg.norm(fitted.vertices - found[0].place, axis=1).min() < 1e-12
    off = distances(fitted.vertices, line.vertices, False)
    assert np.sqrt(np.mean(off**2)) < SIGMA / 2


def test_a_closed_curve_is_turned_to_begin_at_a_corner():
    angle = 2 * np.pi * (np.arange(200) + 0.5) / 200
    ring = Polyline(in_space(np.column_stack((np.cos(angle), np.sin(angle)))), True)
    at = np.array([1.0, 4.0])
    corners = [corner_at(ring, s) for s in at]
    sharp = cornered(ring, corners)
    assert sharp.line.closed
    np.testing.assert_allclose(sharp.line.vertices[sharp.marks[:-1]], [c.place for c in corners])
    assert sharp.marks[0] == 0
    assert sharp.marks[-1] == len(sharp.line.vertices)


def test_a_closed_curve_with_one_corner_stays_closed():
    # A drop: an arc of three quarters of a circle, and two tangents that meet.
    sample = point_set("airfoil", n=6000, sigma=0.003, seed=2)
    (truth,) = sample.curves
    first = Polyline(in_space(truth.vertices[::20]), True)
    answer = refine_curves(Sample.of(in_space(sample.points)), [first], sample.sigma, True)
    (curve,) = answer.curves
    assert curve.closed
    assert len(answer.errors[0]) == len(curve.vertices)
    assert curve.length == pytest.approx(truth.length, rel=0.01)
    steps = np.linalg.norm(np.diff(curve.ring, axis=0), axis=1)
    assert steps.min() > 0.0


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", ["square", "star"])
def test_corners_stay_sharp_where_the_sides_are_short_in_terms_of_the_noise(name, seed):
    sample = point_set(name, n=5000, sigma=0.02, seed=seed)
    (truth,) = sample.curves
    first = Polyline(in_space(truth.vertices[::20]), True)
    (curve,) = refine_curves(Sample.of(in_space(sample.points)), [first], sample.sigma, True).curves
    corners = truth.exact.evaluate(np.array(truth.exact.corners))
    gap = np.linalg.norm(curve.vertices[:, None, :2] - corners[None], axis=2).min(axis=0)
    assert np.count_nonzero(gap < sample.sigma) >= 0.9 * len(corners)
    off = distances(curve.vertices, in_space(truth.vertices), True)
    assert np.sqrt(np.mean(off**2)) < 0.25 * sample.sigma


@pytest.mark.parametrize("seed", range(2))
def test_a_trailing_edge_is_kept(seed):
    sample = point_set("airfoil", n=5000, sigma=0.01, seed=seed)
    (truth,) = sample.curves
    first = Polyline(in_space(truth.vertices[::20]), True)
    (curve,) = refine_curves(Sample.of(in_space(sample.points)), [first], sample.sigma, True).curves
    edge = truth.exact.evaluate(np.array([0.0]))
    assert np.linalg.norm(curve.vertices[:, :2] - edge, axis=1).min() < sample.sigma


@pytest.mark.parametrize("name", ["ellipse", "wave", "bean", "wasp_waist"])
@pytest.mark.parametrize("sigma", [0.005, 0.01])
def test_smooth_families_have_no_corners(name, sigma):
    sample = point_set(name, n=2000, sigma=sigma, seed=3)
    (truth,) = sample.curves
    first = Polyline(in_space(truth.vertices[::20]), truth.closed)
    points = in_space(sample.points)
    (curve,) = refine_curves(Sample.of(points), [first], sample.sigma, True, corners=False).curves
    feet = project(points, [curve], 5 * sample.sigma)
    near = feet.curve == 0
    assert find_corners(points[near], feet.station[near], curve, sample.sigma) == []


def test_order_of_the_samples_and_scale_make_no_difference():
    points, line = bent(np.pi / 2)
    curve, near, station = smoothed(points, line)
    (here,) = find_corners(near, station, curve, SIGMA)
    order = np.random.default_rng(5).permutation(len(near))
    (shuffled,) = find_corners(near[order], station[order], curve, SIGMA)
    np.testing.assert_allclose(shuffled.place, here.place, atol=1e-9)
    shift = np.array([3.0, -2.0, 0.0])
    moved = Polyline(8.0 * curve.vertices + shift, False)
    (there,) = find_corners(8.0 * near + shift, 8.0 * station, moved, 8.0 * SIGMA)
    np.testing.assert_allclose(there.place, 8.0 * here.place + shift, atol=1e-9)


def test_the_sides_of_a_corner_lead_to_it():
    points, line = bent(np.pi / 2, n=10_000)
    curve, near, station = smoothed(points, line)
    (corner,) = find_corners(near, station, curve, SIGMA)
    course = np.concatenate([corner.before, corner.place[None], corner.after])
    assert distances(course, line.vertices, False).max() < SIGMA
    assert np.linalg.norm(np.diff(course, axis=0), axis=1).max() < 2 * SIGMA
    before, at, after = corner.errors
    assert len(before) == len(corner.before)
    assert len(after) == len(corner.after)
    assert 0.0 < at < SIGMA
    assert 0.0 < before.min() <= before.max() < SIGMA
