import numpy as np
import pytest

from core.diagnosis.noise import noise_along, noise_error
from core.refine.principal_curve import Refined
from core.refine.project import project
from tests.core.diagnosis.drawings import beside, straight
from tests.core.shapes import in_space


def error_of(x, y, sigma):
    across = beside(x, y, sigma)
    feet = project(in_space(np.column_stack((x, y))), [across.line], 6 * sigma)
    none = (np.zeros(len(across.line.vertices)),)
    refined = Refined((across.line,), feet, sigma, np.array([sigma]), none)
    return noise_error(refined, [across], 1)


@pytest.mark.parametrize("n", [500, 4000])
def test_the_error_is_that_of_a_standard_deviation(n):
    rng = np.random.default_rng(n)
    x, y = rng.uniform(0.0, 300.0, n), rng.normal(size=n)
    assert error_of(x, y, float(np.std(y))) == pytest.approx(1.0 / np.sqrt(2 * n), rel=0.2)


def test_estimates_scatter_as_much_as_their_errors_say():
    scores = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(0.0, 300.0, 1000), rng.normal(size=1000)
        sigma = float(np.sqrt(np.mean(y**2)))
        scores.append((sigma - 1.0) / error_of(x, y, sigma))
    assert 0.7 < np.std(scores) < 1.35
    assert abs(np.mean(scores)) < 0.5


def test_heavy_tails_make_it_less_certain():
    rng = np.random.default_rng(0)
    x, y = rng.uniform(0.0, 300.0, 4000), rng.laplace(size=4000)
    sigma = float(np.std(y))
    assert error_of(x, y, sigma) > 1.2 * sigma / np.sqrt(2 * 4000)


def test_without_noise_there_is_no_error_to_tell():
    x = np.linspace(0.0, 1.0, 300)
    assert error_of(x, 0 * x, 0.0) is None


def test_noise_that_varies_is_told_along_the_curve():
    rng = np.random.default_rng(1)
    x = rng.uniform(0.0, 300.0, 4000)
    y = (1.0 + 2.0 * x / 300.0) * rng.normal(size=4000)
    found = noise_along(beside(x, y), 1)
    assert found.at(np.array([280.0])) / found.at(np.array([20.0])) == pytest.approx(2.7, rel=0.3)


def test_noise_that_does_not_vary_is_told_once():
    rng = np.random.default_rng(2)
    x, y = rng.uniform(0.0, 300.0, 4000), rng.normal(size=4000)
    assert noise_along(beside(x, y), 1) is None
    assert noise_along(beside(x[:50], y[:50], line=straight(300.0)), 1) is None
