import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from core.refine.regression import Bandwidths, Bins, bin_samples, local_fit, select_bandwidths

LENGTH = 10.0


def bins_of(curve, size=200, length=LENGTH, closed=False, count=5.0):
    """Bins whose means lie exactly on a curve, given as a function of arc length."""
    station = (np.arange(size) + 0.5) * (length / size)
    return Bins(station, np.full(size, count), curve(station), length, closed)


def polynomial(seed, order):
    """A random space curve whose coordinates are polynomials of the arc length."""
    rng = np.random.default_rng(seed)
    parts = [Polynomial(rng.normal(size=order + 1), domain=[0, LENGTH]) for _ in range(3)]
    return (
        lambda s: np.column_stack([p(s) for p in parts]),
        lambda s: np.column_stack([p.deriv(2)(s) for p in parts]),
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.6, 1.5))
def test_fourth_order_polynomials_are_met_exactly_inside(seed, bandwidth):
    curve, second = polynomial(seed, 4)
    inside = np.linspace(bandwidth, LENGTH - bandwidth, 23)
    fit = local_fit(bins_of(curve), inside, Bandwidths(bandwidth, bandwidth))
    np.testing.assert_allclose(fit.value, curve(inside), atol=1e-8)
    np.testing.assert_allclose(fit.second, second(inside), atol=1e-6)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.6, 1.5))
def test_second_order_polynomials_are_met_exactly_to_the_ends(seed, bandwidth):
    curve, second = polynomial(seed, 2)
    everywhere = np.linspace(0.0, LENGTH, 41)
    fit = local_fit(bins_of(curve), everywhere, Bandwidths(bandwidth, bandwidth))
    np.testing.assert_allclose(fit.value, curve(everywhere), atol=1e-8)
    np.testing.assert_allclose(fit.second, second(everywhere), atol=1e-6)


@pytest.mark.parametrize("size", [400, 4000])
def test_fine_bins_may_be_merged_without_harm(size):
    def circle(s):
        return np.column_stack((np.cos(s), np.sin(s), 0 * s))

    bins = bins_of(circle, size, 2 * np.pi, closed=True)
    at = np.linspace(0.0, 2 * np.pi, 50)
    fit = local_fit(bins, at, Bandwidths(0.8, 0.8))
    np.testing.assert_allclose(fit.value, circle(at), atol=1e-3)
    np.testing.assert_allclose(fit.second, -circle(at), atol=0.02)


def test_a_closed_curve_has_no_seam():
    def circle(s):
        return np.column_stack((np.cos(s), np.sin(s), 0 * s))

    bins = bins_of(circle, 200, 2 * np.pi, closed=True)
    width = 2 * np.pi / 200
    at = width * np.arange(200)
    fit = local_fit(bins, at, Bandwidths(0.6, 0.6))
    radius = np.linalg.norm(fit.value, axis=1)
    np.testing.assert_allclose(radius, radius[0], rtol=1e-9)
    np.testing.assert_allclose(fit.leverage, fit.leverage[0], rtol=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_bins_keep_every_sample_and_all_sums(seed, closed):
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 300)
    points, station = rng.normal(size=(n, 3)), rng.uniform(0.0, LENGTH, n)
    bins = bin_samples(points, station, LENGTH, 40, closed)
    assert bins.count.sum() == pytest.approx(n)
    np.testing.assert_allclose(bins.count @ bins.mean, points.sum(axis=0), atol=1e-9)
    if not closed:
        assert bins.count @ bins.station == pytest.approx(station.sum())


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([12, 16, 32, 48]), st.floats(0.3, 0.7))
def test_around_a_closed_curve_the_fit_is_continuous(seed, size, share):
    # A window that spans the whole curve must not care on which side the far bins are counted.
    rng = np.random.default_rng(seed)
    points, station = rng.normal(size=(200, 3)), rng.uniform(0.0, LENGTH, 200)
    bins = bin_samples(points, station, LENGTH, size, True)
    at = np.arange(64) * LENGTH / 64
    h = Bandwidths(share * LENGTH, share * LENGTH)
    before, after = (local_fit(bins, at + nudge, h).value for nudge in (-1e-12, 1e-12))
    np.testing.assert_allclose(before, after, atol=1e-7)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_straight_line_goes_through_the_bins_unchanged(seed):
    rng = np.random.default_rng(seed)
    station = rng.uniform(0.0, LENGTH, 500)
    start, way = rng.normal(size=(2, 3))
    bins = bin_samples(start + station[:, None] * way, station, LENGTH, 64, False)
    at = np.linspace(0.0, LENGTH, 20)
    fit = local_fit(bins, at, Bandwidths(2.0, 2.0))
    np.testing.assert_allclose(fit.value, start + at[:, None] * way, atol=1e-8)
    np.testing.assert_allclose(fit.second, 0.0, atol=1e-7)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.integers(0, 40))
def test_the_fit_is_continuous_in_the_stations(seed, closed, edge):
    rng = np.random.default_rng(seed)
    points, station = rng.normal(size=(100, 3)), rng.uniform(0.0, LENGTH, 100)
    at = np.linspace(0.0, LENGTH, 30)
    fits = []
    # One sample crosses a border, or the middle, of a bin by a rounding error.
    for nudge in (-1e-12, 1e-12):
        station[0] = np.clip(edge * LENGTH / 40 + nudge, 0.0, LENGTH)
        bins = bin_samples(points, station, LENGTH, 20, closed)
        fits.append(local_fit(bins, at, Bandwidths(3.0, 3.0)).value)
    np.testing.assert_allclose(fits[0], fits[1], atol=1e-8)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_seam_of_a_closed_curve_is_continuous_too(seed):
    rng = np.random.default_rng(seed)
    points, station = rng.normal(size=(100, 3)), rng.uniform(0.0, LENGTH, 100)
    at = np.linspace(0.0, LENGTH, 30)
    fits = []
    for place in (0.0, LENGTH * (1 - 1e-14), LENGTH):
        station[0] = place
        bins = bin_samples(points, station, LENGTH, 20, True)
        fits.append(local_fit(bins, at, Bandwidths(3.0, 3.0)).value)
    np.testing.assert_allclose(fits[1], fits[0], atol=1e-8)
    np.testing.assert_allclose(fits[2], fits[0], atol=1e-8)


def spent(size, closed, bandwidth):
    bins = bins_of(lambda s: np.zeros((len(s), 3)), size, closed=closed)
    fit = local_fit(bins, bins.station, Bandwidths(bandwidth, bandwidth))
    return float(bins.count @ fit.leverage)


def test_leverages_add_up_to_the_degrees_of_freedom():
    # A window that all samples fill is a global parabola: three parameters.
    assert spent(100, False, 20 * LENGTH) == pytest.approx(3.0, rel=0.02)
    # Halving the windows doubles the number of parameters spent.
    for closed in (False, True):
        wide, narrow = spent(200, closed, 1.0), spent(200, closed, 0.5)
        assert narrow / wide == pytest.approx(2.0, rel=0.15)


def test_leverage_does_not_depend_on_how_the_samples_are_counted():
    many = bins_of(lambda s: np.zeros((len(s), 3)), count=50.0)
    few = bins_of(lambda s: np.zeros((len(s), 3)), count=5.0)
    at, h = np.linspace(0, LENGTH, 9), Bandwidths(1.0, 1.0)
    np.testing.assert_allclose(10 * local_fit(many, at, h).leverage, local_fit(few, at, h).leverage)


def test_the_standard_error_is_what_leverage_says():
    rng = np.random.default_rng(0)
    at, h = np.linspace(1.5, LENGTH - 1.5, 8), Bandwidths(1.0, 1.0)
    values = []
    for _ in range(300):
        bins = bins_of(lambda s: rng.normal(size=(len(s), 3)), count=1.0)
        fit = local_fit(bins, at, h)
        values.append(fit.value)
    ratio = np.array(values).var(axis=(0, 2)) / fit.leverage
    # A kernel's own weight at the middle exceeds its sum of squares a little.
    assert np.all((ratio > 0.6) & (ratio < 1.2))


def test_gaps_are_bridged_by_wider_windows():
    curve, _ = polynomial(3, 2)
    bins = bins_of(curve)
    bins.count[60:140] = 0.0
    at = np.linspace(0.0, LENGTH, 41)
    fit = local_fit(bins, at, Bandwidths(0.5, 0.5))
    np.testing.assert_allclose(fit.value, curve(at), atol=1e-3)


def test_few_samples_still_have_a_finite_fit():
    for n in (1, 2, 3, 5):
        rng = np.random.default_rng(n)
        bins = bin_samples(rng.normal(size=(n, 3)), rng.uniform(0, LENGTH, n), LENGTH, 10, False)
        fit = local_fit(bins, np.linspace(0, LENGTH, 11), Bandwidths(1.0, 1.0))
        assert np.isfinite(fit.value).all()
        assert np.isfinite(fit.leverage).all()


def wave_bins(sigma, closed, seed=0):
    rng = np.random.default_rng(seed)

    def wave(s):
        turn = 2 * np.pi * s / LENGTH
        y = np.sin(turn) if closed else np.sin(1.3 * turn)
        return np.column_stack((s if not closed else np.cos(turn), y, 0 * s)) + sigma * rng.normal(
            size=(len(s), 3)
        )

    return bins_of(wave, 400, closed=closed, count=1.0)


@pytest.mark.parametrize("closed", [False, True])
def test_more_noise_asks_for_wider_windows(closed):
    candidates = np.geomspace(0.2, 5.0, 15)
    chosen = []
    for sigma in (0.002, 0.02, 0.2):
        runs = [
            select_bandwidths(wave_bins(sigma, closed, seed), candidates, 3 * sigma**2) for seed in range(5)
        ]
        chosen.append(np.median([(run.inside, run.ends) for run in runs], axis=0))
    assert np.all(np.diff(chosen, axis=0) > 0)


def test_the_bandwidths_lie_within_the_candidates_and_vary_continuously():
    candidates = np.geomspace(0.2, 5.0, 15)
    bins = wave_bins(0.05, False)
    chosen = [select_bandwidths(bins, candidates, 3 * v * 0.05**2) for v in (1.0, 1.001)]
    for run in chosen:
        assert candidates[0] <= run.inside <= candidates[-1]
        assert candidates[0] <= run.ends <= candidates[-1]
    assert chosen[1].inside == pytest.approx(chosen[0].inside, rel=1e-2)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_the_choice_of_bandwidth_scales(factor):
    candidates = np.geomspace(0.2, 5.0, 15)
    one = wave_bins(0.05, False)
    two = Bins(factor * one.station, one.count, factor * one.mean, factor * one.length, one.closed)
    small = select_bandwidths(one, candidates, 3 * 0.05**2)
    large = select_bandwidths(two, factor * candidates, 3 * (factor * 0.05) ** 2)
    assert large.inside == pytest.approx(factor * small.inside)
    assert large.ends == pytest.approx(factor * small.ends)


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e9, 1e15])
def test_a_bandwidth_far_beyond_the_curve_costs_no_more(ratio):
    curve, _ = polynomial(1, 2)
    fit = local_fit(bins_of(curve, 60), np.array([2.0, 5.0]), Bandwidths(ratio * LENGTH, ratio * LENGTH))
    assert np.isfinite(fit.value).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_weights_count_samples(seed, closed):
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 300)
    points, station = rng.normal(size=(n, 3)), rng.uniform(0.0, LENGTH, n)
    often = rng.integers(1, 4, n)
    many = bin_samples(np.repeat(points, often, axis=0), np.repeat(station, often), LENGTH, 40, closed)
    weighed = bin_samples(points, station, LENGTH, 40, closed, often.astype(float))
    np.testing.assert_allclose(weighed.count, many.count, atol=1e-9)
    np.testing.assert_allclose(weighed.mean, many.mean, atol=1e-9)
    np.testing.assert_allclose(weighed.station, many.station, atol=1e-9)
    plain = bin_samples(points, station, LENGTH, 40, closed)
    np.testing.assert_array_equal(
        bin_samples(points, station, LENGTH, 40, closed, np.ones(n)).mean, plain.mean
    )
