import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from core.surface.contour_fit import LEAST_SAMPLES, MOST_VERTICES, fit_contour

SIGMA = 0.01
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def circle(count, radius=1.0):
    return ellipse(count, radius, radius)


def ellipse(count, a=3.0, b=1.0):
    t = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack([a * np.cos(t), b * np.sin(t)], axis=1)


def along(ring, count):
    """Vertices equally far apart on a closed polyline."""
    line = shapely.LinearRing(ring)
    return shapely.get_coordinates(line.interpolate(np.arange(count) * (line.length / count)))


def sampled(ring, count, sigma, seed=0, keep=None):
    """Samples of a closed polyline in random order, with normal noise."""
    rng = np.random.default_rng(seed)
    line = shapely.LinearRing(ring)
    share = rng.uniform(0.0, 1.0, count)
    if keep is not None:
        share = share[keep(share)]
    points = shapely.get_coordinates(line.interpolate(share, normalized=True))
    return points + sigma * rng.normal(size=points.shape)


def fit(points, guess):
    return fit_contour(points, guess, np.asarray(cKDTree(guess).query(points)[1], np.int64))


def away(fitted, ring):
    """Distances of places on a fitted contour from a closed polyline."""
    return shapely.LinearRing(ring).distance(shapely.points(along(fitted.vertices, 1000)))


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("count", [200, 1000, 20000])
def test_the_mean_radius_of_a_circle_is_right_within_its_standard_error(count):
    found = fit(sampled(circle(4000), count, SIGMA), circle(90, 1.02) + 0.01)
    radius = np.linalg.norm(along(found.vertices, 500) - 0.0, axis=1)
    assert abs(radius.mean() - 1.0) < 4.0 * SIGMA / np.sqrt(count)
    assert rms(radius - 1.0) < 12.0 * SIGMA / np.sqrt(count)
    assert found.sigma == pytest.approx(SIGMA, rel=6.0 / np.sqrt(count))
    assert found.length == pytest.approx(2.0 * np.pi, rel=5e-3)


def test_an_ellipse_comes_closer_than_a_third_of_the_noise():
    found = fit(sampled(ellipse(4000), 1500, SIGMA), ellipse(120, 3.02, 0.98))
    assert rms(away(found, ellipse(4000))) < SIGMA / 3.0


def test_samples_without_noise_are_followed():
    found = fit(sampled(ellipse(8000), 3000, 0.0), ellipse(120, 3.02, 0.98))
    assert away(found, ellipse(8000)).max() < 2e-4
    assert found.sigma < 2e-4


def test_without_noise_corners_are_rounded_off_by_what_samples_cannot_tell():
    spacing = 4.0 / 400
    for guess in (along(SQUARE, 400), 1.01 * along(SQUARE, 90)):
        found = fit(along(SQUARE, 400), guess)
        distance = away(found, SQUARE)
        assert distance.max() < 1.5 * spacing
        assert rms(distance) < 0.2 * spacing


@pytest.mark.parametrize("ring", [SQUARE, [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]])
def test_corners_are_rounded_off_by_no_more_than_a_few_sigma(ring):
    found = fit(sampled(ring, 3000, 0.005), along(ring, 150))
    distance = away(found, ring)
    assert distance.max() < 3.0 * 0.005
    assert rms(distance) < 0.4 * 0.005


def test_sides_that_run_near_each_other_keep_apart():
    thin = [(0.0, 0.0), (5.0, 0.0), (5.0, 0.2), (0.0, 0.2)]
    found = fit(sampled(thin, 3000, 0.02), along(thin, 300))
    assert shapely.LinearRing(found.vertices).is_simple
    assert rms(away(found, thin)) < 0.5 * 0.02


def test_outliers_do_not_matter():
    clean, rng = sampled(ellipse(4000), 1500, SIGMA), np.random.default_rng(1)
    strays = rng.uniform((-4.0, -2.0), (4.0, 2.0), (150, 2))
    found = fit(np.concatenate((clean, strays)), ellipse(120, 3.02, 0.98))
    assert rms(away(found, ellipse(4000))) < SIGMA / 2.0
    assert found.sigma < 1.3 * SIGMA


@pytest.mark.parametrize("missing", [0.1, 0.3, 0.6])
def test_in_a_gap_the_guess_is_followed(missing):
    guess = ellipse(200, 3.0 + SIGMA, 1.0 + SIGMA)
    found = fit(sampled(ellipse(4000), 2000, SIGMA, keep=lambda share: share > missing), guess)
    assert away(found, ellipse(4000)).max() < 3.0 * SIGMA
    station = np.sort(found.station)
    assert np.diff(station, append=station[0] + found.length).max() > 0.8 * missing * found.length


def test_the_order_of_independent_samples_hardly_matters():
    points = sampled(ellipse(4000), 1500, SIGMA)
    one, other = fit(points, ellipse(120)), fit(points[::-1], ellipse(120))
    assert rms(away(one, other.vertices)) < 1e-9
    shuffled = fit(np.random.default_rng(3).permutation(points), ellipse(120))
    assert rms(away(one, shuffled.vertices)) < 0.1 * SIGMA


def test_the_other_way_round_is_the_same_contour():
    points, guess = sampled(ellipse(4000), 1500, SIGMA), ellipse(120)
    assert rms(away(fit(points, guess), fit(points, guess[::-1]).vertices)) < 0.1 * SIGMA


@settings(max_examples=25, deadline=None)
@given(
    angle=st.floats(0.0, 6.3),
    exponent=st.integers(-140, 140),
    shift=st.tuples(st.floats(-100.0, 100.0), st.floats(-100.0, 100.0)),
)
def test_motion_and_scale_move_and_scale_the_contour(angle, exponent, shift):
    points, guess = sampled(ellipse(500), 300, SIGMA), ellipse(60)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    scale = 1.7 * 10.0**exponent
    base = fit(points, guess)
    segments = np.asarray(cKDTree(guess).query(points)[1], np.int64)
    moved = fit_contour(scale * (points @ turn.T + shift), scale * (guess @ turn.T + shift), segments)
    assert moved.vertices.shape == base.vertices.shape
    assert np.abs(moved.vertices / scale - (base.vertices @ turn.T + shift)).max() < 1e-8
    assert moved.sigma == pytest.approx(scale * base.sigma, rel=1e-6)
    assert moved.length == pytest.approx(scale * base.length, rel=1e-8)


def test_noise_that_samples_in_a_row_share_is_smoothed_more():
    t = np.sort(np.random.default_rng(5).uniform(0.0, 2.0 * np.pi, 900))
    noise = np.random.default_rng(6).normal(size=902)
    radius = 1.0 + SIGMA * (noise[:-2] + noise[1:-1] + noise[2:]) / np.sqrt(3.0)
    wave = radius + 0.02 * np.cos(9.0 * t)
    points = wave[:, None] * np.stack([np.cos(t), np.sin(t)], axis=1)
    apart = np.random.default_rng(7).permutation(points)
    s = np.linspace(0.0, 2.0 * np.pi, 4000)
    truth = (1.0 + 0.02 * np.cos(9.0 * s))[:, None] * np.stack([np.cos(s), np.sin(s)], axis=1)
    in_a_row, mixed = fit(points, circle(120)), fit(apart, circle(120))
    assert rms(away(in_a_row, truth)) < rms(away(mixed, truth))


def test_vertices_are_equally_far_apart_and_stations_within_the_length():
    points = sampled(ellipse(4000), 1500, SIGMA)
    found = fit(points, ellipse(120))
    step = np.linalg.norm(np.roll(found.vertices, -1, axis=0) - found.vertices, axis=1)
    assert found.length == pytest.approx(step.sum())
    assert step.max() < 1.2 * step.min()
    assert 20 < len(found.vertices) <= MOST_VERTICES
    assert found.station.shape == found.distance.shape == (len(points),)
    assert found.station.min() >= 0.0
    assert found.station.max() <= found.length * (1.0 + 1e-12)
    line = shapely.LinearRing(found.vertices)
    assert found.distance == pytest.approx(line.distance(shapely.points(points)), abs=1e-9)


def test_feet_are_found_from_segments_that_are_off():
    points, guess = sampled(ellipse(4000), 1500, SIGMA), ellipse(120)
    segments = np.asarray(cKDTree(guess).query(points)[1], np.int64)
    base, shifted = fit_contour(points, guess, segments), fit_contour(points, guess, (segments + 9) % 120)
    assert np.abs(base.vertices - shifted.vertices).max() < 1e-9


def test_few_samples_or_no_guess_give_nothing():
    points = sampled(circle(100), LEAST_SAMPLES - 1, SIGMA)
    assert fit(points, circle(30)) is None
    assert fit(sampled(circle(100), 100, SIGMA), np.ones((5, 2))) is None
    assert fit_contour(np.zeros((0, 2)), circle(30), np.zeros(0, np.int64)) is None


@settings(max_examples=60, deadline=None)
@given(
    count=st.integers(12, 80),
    places=st.integers(1, 20),
    vertices=st.integers(1, 40),
    sigma=st.sampled_from([0.0, 1e-300, 1e-12, 0.1, 5.0]),
    seed=st.integers(0, 2**32),
)
def test_whatever_samples_there_are_nothing_but_numbers_comes_out(count, places, vertices, sigma, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(places, 2))[rng.integers(places, size=count)]
    points = points + sigma * rng.normal(size=points.shape)
    found = fit(points, circle(vertices) + rng.normal(size=2))
    if found is not None:
        assert 0 < len(found.vertices) <= MOST_VERTICES
        for one in found:
            assert np.isfinite(one).all()
