import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.ends import ends_of, prolonged
from core.refine.polyline import Polyline
from tests.core.shapes import in_space

SEEDS = st.integers(0, 2**32 - 1)


LOW, HIGH = 0.3, 9.7  # a curve that has been prolonged by 0.3 either side


def blurred(n, sigma, seed=0):
    """Stations of samples of the curve, as noise along it blurs them."""
    rng = np.random.default_rng(seed)
    return rng.uniform(LOW, HIGH, n) + sigma * rng.normal(size=n)


@pytest.mark.parametrize("n", [300, 3000, 30_000])
@pytest.mark.parametrize("sigma", [0.01, 0.1])
def test_ends_are_found_within_a_fraction_of_the_blur(n, sigma):
    errors = []
    for seed in range(8):
        low, high = ends_of(blurred(n, sigma, seed=seed), 10.0, sigma)
        errors += [low - LOW, HIGH - high]
    spacing = 9.4 / n
    assert np.quantile(np.abs(errors), 0.9) < 1.5 * sigma + 5 * spacing
    assert abs(np.mean(errors)) < 0.3 * sigma + spacing


def test_without_noise_the_ends_are_the_outermost_samples():
    station = np.linspace(LOW, HIGH, 601)
    low, high = ends_of(station, 10.0, 0.0)
    assert low == pytest.approx(LOW, abs=0.02)
    assert high == pytest.approx(HIGH, abs=0.02)


def test_a_stray_sample_far_out_moves_no_end():
    station = blurred(2000, 0.03)
    low, high = ends_of(np.concatenate(([0.01], station, [9.99])), 10.0, 0.03)
    assert low == pytest.approx(LOW, abs=0.05)
    assert high == pytest.approx(HIGH, abs=0.05)


@pytest.mark.parametrize("n", [100, 3000])
def test_weights_count_samples(n):
    station = blurred(n, 0.05)
    once = ends_of(station, 10.0, 0.05)
    assert ends_of(station, 10.0, 0.05, np.ones(n)) == once
    # A thin haze of shares before the curve begins and behind its end is no part of it.
    haze = np.linspace(0.0, 10.0, n)
    both, weight = np.concatenate((station, haze)), np.concatenate((np.ones(n), np.full(n, 0.01)))
    np.testing.assert_allclose(ends_of(both, 10.0, 0.05, weight), once, atol=0.05 + 2.0 / n)


def test_a_tail_of_small_shares_prolongs_no_curve():
    # Behind the end lie as many samples as before it, of which nearly all of each is another curve's.
    station = np.random.default_rng(4).uniform(0.0, 10.0, 20_000)
    weight = np.where((station > LOW) & (station < 9.2), 1.0, 0.05)
    low, high = ends_of(station, 10.0, 0.05, weight)
    assert low == pytest.approx(LOW, abs=0.05)
    assert high == pytest.approx(9.2, abs=0.05)


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(8, 400), st.floats(0.0, 0.3))
def test_the_direction_of_the_curve_does_not_matter(seed, n, sigma):
    station = np.clip(blurred(n, sigma, seed=seed), 0.0, 10.0)
    low, high = ends_of(station, 10.0, sigma)
    back_low, back_high = ends_of(10.0 - station, 10.0, sigma)
    assert back_low == pytest.approx(10.0 - high, abs=1e-9)
    assert back_high == pytest.approx(10.0 - low, abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(8, 400), st.floats(0.0, 0.1))
def test_rounding_does_not_decide_where_a_curve_ends(seed, n, sigma):
    station = np.clip(blurred(n, sigma, seed=seed), 0.0, 10.0)
    once = ends_of(station, 10.0, sigma)
    for factor in (1.0 + 1e-14, 1.0 - 1e-14):
        again = ends_of(factor * station, factor * 10.0, factor * sigma)
        np.testing.assert_allclose(again, once, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(0, 12), st.floats(0.0, 1.0))
def test_few_samples_have_finite_ends(seed, n, sigma):
    station = np.random.default_rng(seed).uniform(0.0, 10.0, n)
    assert np.isfinite(ends_of(station, 10.0, sigma)).all()
    assert np.isfinite(ends_of(np.full(n, 3.0), 10.0, sigma)).all()


def test_prolonging_adds_straight_tangents():
    angle = np.linspace(0.0, 2.0, 400)
    line = Polyline(in_space(np.column_stack((np.cos(angle), np.sin(angle)))), False)
    longer = prolonged(line, 0.1)
    assert longer.length == pytest.approx(line.length + 0.2, rel=1e-3)
    np.testing.assert_array_equal(longer.vertices[1:-1], line.vertices)
    first = longer.vertices[0] - line.vertices[0]
    assert np.linalg.norm(first) == pytest.approx(0.1)
    assert first[1] / 0.1 < -np.cos(0.1)


def test_closed_curves_are_not_prolonged():
    ring = Polyline(in_space(np.array([(0, 0), (1, 0), (0, 1)], float)), True)
    assert prolonged(ring, 0.5) is ring


def test_a_curve_of_one_place_is_prolonged_to_something_finite():
    dot = Polyline(np.zeros((3, 3)), False)
    assert np.isfinite(prolonged(dot, 0.5).vertices).all()
