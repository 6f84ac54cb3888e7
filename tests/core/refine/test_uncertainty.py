import numpy as np
import pytest

from core.cloud.sampling import Sample
from core.refine.polyline import Polyline
from core.refine.principal_curve import as_they_are, refine_curves
from core.refine.regression import Bandwidths, Bins, bin_samples, local_fit
from core.refine.uncertainty import Residuals, residuals_of, sigma_error, standard_error, with_plane
from core.truth import point_set
from core.truth.coverage import coverage
from tests.core.shapes import arc, in_space, line, rotation


def ring(radius=1.0, count=200, turn=2 * np.pi):
    closed = turn == 2 * np.pi
    angle = np.linspace(0.0, turn, count, endpoint=not closed)
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), closed)


def refined(points, first, sigma, flat=True, **options):
    return refine_curves(Sample.of(in_space(points)), [first], sigma, flat, **options)


def covered(name, n, sigma, seeds, outliers=0.0):
    """Mean share of the truth within two standard errors of curves refined from near the truth."""
    shares = []
    for seed in seeds:
        truth = point_set(name, n=n, sigma=sigma, seed=seed, outliers=outliers)
        d = truth.points.shape[1]
        first = [Polyline(in_space(one.exact.polyline(150)), one.closed) for one in truth.curves]
        answer = refine_curves(Sample.of(in_space(truth.points)), first, 1.1 * truth.sigma, d == 2)
        pairs = zip(answer.curves, answer.errors, strict=True)
        shares.append(coverage([(c.vertices[:, :d], c.closed, e) for c, e in pairs], truth).share())
    return float(np.mean(shares))


@pytest.mark.parametrize(
    ("name", "n", "sigma"),
    [
        ("circle", 300, 0.01),
        ("s_shape", 1000, 0.0025),
        ("flower", 1000, 0.01),
        ("spiral", 5000, 0.005),
        ("cubic", 5000, 0.01),
        ("bean", 1000, 0.02),
        ("helix", 2000, 0.01),
        ("saddle", 1000, 0.02),
        ("non_uniform", 1000, 0.01),
        ("figure_8", 2000, 0.01),
    ],
)
def test_the_truth_lies_within_two_standard_errors_for_95_percent(name, n, sigma):
    # One set's share scatters by 0.03 to 0.06: sixteen sets' mean by 0.015 at most.
    assert 0.91 < covered(name, n, sigma, range(100, 116)) < 0.99


def test_outliers_widen_the_band_no_more_than_they_must():
    assert 0.91 < covered("ellipse", 2000, 0.01, range(100, 116), outliers=0.05) < 0.99


def rms_error(points, first, sigma):
    (error,) = refined(points, first, sigma).errors
    return np.sqrt(np.mean(error**2))


def test_the_error_falls_with_the_root_of_the_number_of_samples():
    sigma, first = 0.01, Polyline(in_space(np.array([(-2.0, 0.0), (2.0, 0.0)])), False)
    few, many = (
        np.mean([rms_error(line(n, sigma, length=4.0, seed=seed), first, sigma) for seed in range(5)])
        for n in (1000, 16_000)
    )
    # A line may be smoothed over its whole length, whatever the number of samples.
    assert few / many == pytest.approx(4.0, rel=0.25)


def test_the_error_is_proportional_to_the_noise():
    first = Polyline(in_space(np.array([(-2.0, 0.0), (2.0, 0.0)])), False)
    low, high = (rms_error(line(3000, sigma, length=4.0), first, sigma) for sigma in (0.002, 0.02))
    assert high / low == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("closed", [True, False])
def test_frame_unit_and_order_do_not_matter(closed):
    rng, turn = np.random.default_rng(0), 2 * np.pi if closed else 4.0
    points, first = in_space(arc(1500, 0.02, turn=turn)), ring(turn=turn)
    once = refined(points, first, 0.02)
    way = np.eye(3)
    way[:2, :2] = rotation(rng, 2)
    moved = Polyline(1e3 * first.vertices @ way.T + [5.0, -7.0, 0.0], closed)
    again = refined(1e3 * rng.permutation(points) @ way.T + [5.0, -7.0, 0.0], moved, 20.0)
    np.testing.assert_allclose(again.errors[0], 1e3 * once.errors[0], rtol=1e-4)
    np.testing.assert_allclose(again.sigma_errors, 1e3 * once.sigma_errors, rtol=1e-6)


def test_open_ends_are_less_certain():
    (error,) = refined(arc(4000, 0.02, turn=4.0), ring(turn=4.0), 0.02).errors
    middle = np.median(error)
    assert error[0] > 1.5 * middle
    assert error[-1] > 1.5 * middle


def test_a_closed_curve_is_as_certain_everywhere():
    (error,) = refined(arc(20_000, 0.02), ring(), 0.02).errors
    assert error.max() < 1.15 * error.min()


def test_fewer_samples_make_a_stretch_less_certain():
    points = arc(8000, 0.02, seed=1)
    rare = (points[:, 0] > 0.0) | (np.random.default_rng(0).uniform(size=8000) < 0.1)
    answer = refined(points[rare], ring(), 0.02)
    x = answer.curves[0].vertices[:, 0]
    # A tenth of the samples: the root of ten.
    ratio = np.median(answer.errors[0][x < -0.6]) / np.median(answer.errors[0][x > 0.6])
    assert ratio == pytest.approx(np.sqrt(10.0), rel=0.15)


def test_more_noise_makes_a_stretch_less_certain():
    rng, angle = np.random.default_rng(0), np.random.default_rng(1).uniform(0.0, 2 * np.pi, 8000)
    noise = 0.01 * 2.0 ** np.cos(angle)
    radius = 1.0 + noise * rng.normal(size=8000)
    points = radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    answer = refined(points, ring(), 0.013)
    x = answer.curves[0].vertices[:, 0]
    ratio = np.median(answer.errors[0][x > 0.95]) / np.median(answer.errors[0][x < -0.95])
    assert 2.8 < ratio < 4.4


@pytest.mark.parametrize("seed", [0, 1])
def test_noise_that_varies_is_seen_whole_and_bends_nothing(seed):
    rng, sigma = np.random.default_rng(seed), 0.04
    angle = rng.uniform(0.0, 2 * np.pi, 20_000)
    points = np.column_stack((np.cos(angle), np.sin(angle)))
    local = sigma * 2.0 ** np.cos(angle)
    answer = refined(points + local[:, None] * rng.normal(size=points.shape), ring(), 1.1 * sigma)
    # No sample of the noisy side is cut off,
    assert answer.sigma == pytest.approx(np.sqrt(np.mean(local**2)), rel=0.03)
    # and the bias of curvature is that of the noise there: 0.0032 on one side, 0.0002 on the other.
    off = np.linalg.norm(answer.curves[0].vertices, axis=1) - 1.0
    x = answer.curves[0].vertices[:, 0]
    assert abs(off[x > 0.8].mean()) < 3.0 * answer.errors[0][x > 0.8].mean()
    assert np.sqrt(np.mean((off / answer.errors[0]) ** 2)) < 2.0


def test_a_constant_noise_is_not_told_to_vary():
    for seed in range(4):
        (error,) = refined(arc(3000, 0.02, seed=seed), ring(), 0.02).errors
        assert error.max() < 1.25 * error.min()


def crossing(degrees, n, sigma, seed):
    """Samples of two unit segments that cross, and the segments."""
    rng, parts, lines = np.random.default_rng(seed), [], []
    for turn in (0.0, np.radians(degrees)):
        way = np.array([np.cos(turn), np.sin(turn), 0.0])
        noise = sigma * in_space(rng.normal(size=(n, 2)))
        parts.append(rng.uniform(-0.5, 0.5, n)[:, None] * way + noise)
        lines.append(Polyline(np.linspace(-0.5, 0.5, 80)[:, None] * way, False))
    return np.concatenate(parts), lines


def test_near_a_crossing_curves_are_less_certain():
    sigma = 0.01
    points, lines = crossing(20.0, 6000, sigma, 0)
    answer = refine_curves(Sample.of(points), lines, 1.1 * sigma, True)
    for curve, error in zip(answer.curves, answer.errors, strict=True):
        away = np.linalg.norm(curve.vertices, axis=1)
        alone = refined(points[:6000], lines[0], 1.1 * sigma).errors[0]
        assert error[away < 2.0 * sigma].mean() > 1.1 * np.median(alone)
        assert np.median(error[(away > 0.2) & (away < 0.3)]) < 1.2 * np.median(alone)


def test_shared_samples_tell_less():
    rng = np.random.default_rng(0)
    n, size = 4000, 200
    station, distance = rng.uniform(0.0, 1.0, n), np.abs(rng.normal(0.0, 0.01, n))
    at, h = np.linspace(0.2, 0.8, 7), Bandwidths(0.1, 0.1)

    def error(weight):
        bins = bin_samples(np.zeros((n, 3)), station, 1.0, size, False, weight)
        residuals = residuals_of(bins, station, distance, distance / 0.01, weight, 0.0, 4.0, 1, 0.1)
        return standard_error(bins, at, h, residuals, 0.0, 1)

    whole, half, sure = error(None), error(np.full(n, 0.5)), error(np.ones(n))
    np.testing.assert_allclose(sure, whole, rtol=1e-9)
    # Each is either wholly the curve's or not at all: at best half of the samples remain.
    assert np.all(half > np.sqrt(2.0) * whole * (1.0 - 1e-9))


@pytest.mark.parametrize("closed", [True, False])
def test_the_error_is_the_scatter_of_fits_with_known_stations(closed):
    rng = np.random.default_rng(0)
    size, length, h = 120, 10.0, Bandwidths(2.0, 3.0)
    station = (np.arange(size) + 0.5) * (length / size)
    count = rng.integers(1, 9, size).astype(float)
    noise = 1.0 + 0.5 * np.sin(station)
    at = np.linspace(0.0, length, 15)
    values = []
    for _ in range(600):
        mean = (noise / np.sqrt(count))[:, None] * rng.normal(size=(size, 3))
        values.append(local_fit(Bins(station, count, mean, length, closed), at, h).value)
    scatter = np.std(values, axis=(0, 2))
    bins = Bins(station, count, np.zeros((size, 3)), length, closed)
    told = standard_error(bins, at, h, Residuals(count, count, noise**2, 1.0), 0.0, 1)
    bias = np.sqrt(7.0 / 6.0)
    # Two orders are blended near open ends, and taken for wholly dependent there.
    inside = slice(None) if closed else (at > 2.0) & (at < length - 2.0)
    np.testing.assert_allclose(told[inside] / bias, scatter[inside], rtol=0.1)
    assert np.all(told / bias > 0.9 * scatter)
    assert np.all(told / bias < 1.3 * scatter)


def test_the_plane_adds_its_own_error():
    # Heights of fitted planes over an ellipse, beside a known scatter in the plane.
    rng, n, sigma = np.random.default_rng(0), 400, 0.05
    angle = np.linspace(0.0, 2 * np.pi, n, endpoint=False)
    flat = np.column_stack((3.0 * np.cos(angle), np.sin(angle), 0.0 * angle))
    basis = np.column_stack((np.ones(n), flat[:, :2]))
    heights = basis @ np.linalg.lstsq(basis, sigma * rng.normal(size=(n, 4000)), rcond=None)[0]
    for own in (0.006, 0.012, 0.05):
        band = with_plane(np.full(n, own), flat, flat, sigma)
        away = np.hypot(heights, own * rng.normal(size=heights.shape))
        assert np.mean(away < 2.0 * band[:, None]) == pytest.approx(0.955, abs=0.012)


@pytest.mark.parametrize("normals", [1, 2])
def test_the_standard_error_of_sigma_is_the_scatter_of_estimates(normals):
    rng = np.random.default_rng(0)
    distance = np.linalg.norm(rng.normal(size=(4000, 500, normals)), axis=2)
    scatter = np.sqrt(np.mean(distance**2, axis=1) / normals).std()
    told = [sigma_error(d, None, 0.0, 1.0, normals) for d in distance[:50]]
    assert np.mean(told) == pytest.approx(scatter, rel=0.1)
    assert np.mean(told) == pytest.approx(1.0 / np.sqrt(2 * normals * 500), rel=0.1)


def test_heavy_tails_make_sigma_less_certain():
    rng = np.random.default_rng(0)
    heavy = np.abs(rng.laplace(size=(2000, 400)))
    scatter = np.sqrt(np.mean(heavy**2, axis=1)).std()
    told = [sigma_error(d, None, 0.0, np.sqrt(2.0), 1) for d in heavy[:100]]
    assert np.mean(told) == pytest.approx(scatter, rel=0.2)


@pytest.mark.parametrize("unit", [1e-200, 1.0, 1e200])
def test_the_unit_of_the_distances_does_not_matter(unit):
    rng = np.random.default_rng(0)
    distance, weight = np.abs(rng.standard_t(5, size=400)), rng.uniform(size=400)
    for given in (None, weight):
        told = sigma_error(unit * distance, given, 5.0, 2.0, 1)
        assert told == pytest.approx(sigma_error(distance, given, 5.0, 2.0, 1), rel=1e-9)


def test_sigma_has_its_standard_error():
    far = []
    for seed in range(40):
        answer = refined(arc(500, 0.02, seed=seed), ring(), 0.02)
        far.append((answer.sigmas[0] - 0.02) / answer.sigma_errors[0])
    assert np.sqrt(np.mean(np.square(far))) == pytest.approx(1.0, abs=0.35)


def test_curves_kept_as_they_are_have_no_standard_error():
    answer = as_they_are(Sample.of(in_space(arc(2000, 0.02))), [ring()], 0.02, True)
    assert np.isnan(answer.errors[0]).all()
    assert answer.sigma_errors[0] == pytest.approx(0.02 / np.sqrt(4000), rel=0.1)


def test_a_curve_with_too_few_samples_has_no_standard_error():
    far = np.full((1, 3), 50.0)
    answer = refine_curves(Sample.of(far), [ring()], 0.01, True)
    assert np.isnan(answer.errors[0]).all()


@pytest.mark.parametrize("n", [8, 12, 20, 50])
def test_few_samples_have_finite_standard_errors(n):
    answer = refined(arc(n, 0.02), ring(), 0.02)
    assert np.all(np.isfinite(answer.errors[0]))
    assert np.all(answer.errors[0] > 0.0)


@pytest.mark.parametrize("n", [20, 50, 3000])
def test_samples_without_noise_have_hardly_any_error(n):
    (error,) = refined(arc(n, 0.0), ring(), 0.005).errors
    # Once the noise has shrunk below the chords' deviation no sample is near enough for a fit.
    assert np.isnan(error).all() or np.all(error < 1e-4)
