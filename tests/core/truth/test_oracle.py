from dataclasses import replace

import numpy as np
import pytest

from core.truth import held_out_names, names, oracle_rms, point_set, score
from core.truth.oracle import local_quadratic, oracle_curves


def test_a_parabola_is_regressed_exactly():
    rng = np.random.default_rng(0)
    u = rng.uniform(size=20000)
    values = np.column_stack((1 + 2 * u - 3 * u**2, -u))
    estimate = local_quadratic(u, values, closed=False, width=0.2)
    grid = np.linspace(0, 1, len(estimate))
    np.testing.assert_allclose(estimate, np.column_stack((1 + 2 * grid - 3 * grid**2, -grid)), atol=1e-5)


def test_a_window_without_samples_has_no_regression():
    u = np.array([0.1, 0.11, 0.12, 0.9])
    assert local_quadratic(u, u[:, None], closed=False, width=0.05) is None


def test_the_variance_of_a_regression_on_noise_is_that_of_theory():
    # local quadratic, Epanechnikov kernel: the equivalent kernel has a square integral of 5/4
    n, width = 20000, 0.05
    rng = np.random.default_rng(1)
    estimate = local_quadratic(rng.uniform(size=n), rng.normal(size=(n, 64)), closed=True, width=width)
    assert np.sqrt(np.mean(estimate**2)) == pytest.approx(np.sqrt(1.25 / (n * width)), rel=0.1)


def test_a_periodic_regression_has_no_seam():
    u = np.random.default_rng(2).uniform(size=20000)
    wave = np.cos(2 * np.pi * u)[:, None]
    estimate = local_quadratic(u, wave, closed=True, width=0.03)
    steps = np.abs(np.diff(np.vstack((estimate, estimate[:1])), axis=0))
    assert steps.max() < 2.5 * np.pi / len(estimate)
    rolled = local_quadratic((u + 0.5) % 1.0, wave, closed=True, width=0.03)
    np.testing.assert_allclose(np.roll(rolled, -len(rolled) // 2, axis=0), estimate, atol=1e-9)


def test_error_of_a_straight_line_is_near_that_of_a_global_parabola():
    # the widest window is best on a line; a global quadratic has three degrees of freedom
    n, rng = 1000, np.random.default_rng(0)
    estimate = local_quadratic(rng.uniform(size=n), rng.normal(size=(n, 400)), closed=False, width=1.0)
    assert 0.95 < np.mean(estimate**2) / (3 / n) < 1.5


@pytest.mark.parametrize("name", [*names(), *held_out_names()])
def test_the_oracle_is_well_below_the_noise(name):
    sample = point_set(name, n=4000, sigma=0.005)
    registration = 1.0 if name == "multi_scan" else 0.3
    assert 0 < oracle_rms(sample) < registration * sample.sigma


def test_the_error_falls_with_the_number_of_samples_as_theory_says():
    # local quadratic regression: the bias is of order h^4 at interior points, so rms ~ N^(-4/9)
    sizes = np.array([1000, 4000, 16000, 64000])
    errors = [np.mean([oracle_rms(point_set("ellipse", n=n, seed=s)) for s in range(4)]) for n in sizes]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert -0.52 < slope < -0.38


def test_the_oracle_is_an_estimate_of_each_curve():
    sample = point_set("disjoint", n=4000, sigma=0.005)
    curves = [(one, c.closed) for one, c in zip(oracle_curves(sample), sample.curves, strict=True)]
    got = score(curves, sample)
    assert got.flags_right
    assert got.covered
    assert got.rms == pytest.approx(oracle_rms(sample), rel=1e-9)


def test_outliers_do_not_concern_the_oracle():
    plain, littered = (point_set("s_shape", n=2000, outliers=share, seed=3) for share in (0.0, 0.5))
    assert oracle_rms(littered) == pytest.approx(oracle_rms(plain), rel=1e-9)


def test_the_oracle_is_the_same_wherever_the_curve_lies():
    flat = point_set("circle", n=3000, seed=1)
    assert oracle_rms(flat) / flat.sigma == pytest.approx(0.05, abs=0.03)
    shuffled = np.random.default_rng(0).permutation(3000)
    again = replace(
        flat,
        points=flat.points[shuffled],
        curve_of=flat.curve_of[shuffled],
        u=flat.u[shuffled],
        noise=flat.noise[shuffled],
    )
    assert oracle_rms(again) == pytest.approx(oracle_rms(flat), rel=1e-9)


def test_too_few_samples_leave_no_floor():
    assert oracle_rms(point_set("circle", n=3)) == float("inf")
