import numpy as np
import pytest

from core.diagnosis.hidden import hidden_branches, separation
from tests.core.diagnosis.drawings import around, beside


def pair(n, gap, seed, share=1.0):
    """Samples of a branch of length 200, which is double over a share of it."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.0, 200.0, n)
    double = x < 200.0 * share
    y = rng.normal(size=n) + np.where(double, rng.choice([-0.5, 0.5], n) * gap, 0.0)
    return x, y


@pytest.mark.parametrize("gap", [2.0, 2.5, 3.0, 3.5])
@pytest.mark.parametrize("seed", range(3))
def test_two_branches_under_one_curve_are_seen(gap, seed):
    found = hidden_branches(beside(*pair(3000, gap, seed)))
    assert found
    assert found[0].gap / found[0].sigma == pytest.approx(gap, rel=0.25)
    assert found[0].sigma == pytest.approx(1.0, rel=0.2)


def test_a_double_stretch_is_found_where_it_is():
    found = hidden_branches(beside(*pair(4000, 3.5, 0, share=0.25)))
    middle = 0.5 * (found[0].low + found[0].high)
    assert 0.0 < middle < 50.0


@pytest.mark.parametrize("noise", ["gaussian", "student", "laplace", "varying", "strays"])
def test_one_branch_hides_none(noise):
    flagged = 0
    for seed in range(40):
        rng = np.random.default_rng([seed, 9])
        n = 2000
        x = rng.uniform(0.0, 200.0, n)
        y = {
            "gaussian": lambda n=n, rng=rng: rng.normal(size=n),
            "student": lambda n=n, rng=rng: rng.standard_t(3, size=n),
            "laplace": lambda n=n, rng=rng: rng.laplace(size=n),
            "varying": lambda n=n, x=x, rng=rng: (0.5 + x / 100.0) * rng.normal(size=n),
            "strays": lambda n=n, rng=rng: np.where(
                rng.random(n) < 0.1, rng.uniform(-6, 6, n), rng.normal(size=n)
            ),
        }[noise]()
        flagged += bool(hidden_branches(beside(x, y, sigma=float(np.std(y[np.abs(y) < 6])))))
    assert flagged <= 2  # of 40, where 0.3 are due


def test_a_ring_of_any_noise_hides_no_other():
    for sigma in (0.01, 0.1, 0.2):
        assert not hidden_branches(around(1.0, 3000, sigma, 1))


@pytest.mark.parametrize("gap", [1.5, 2.0, 3.0])
def test_moments_of_a_mixture_give_its_branches_back(gap):
    variance, fourth = 1.0 + gap**2 / 4, 3.0 + 6.0 * gap**2 / 4 + (gap / 2) ** 4
    found, sigma = separation(variance, fourth / variance**2 - 3.0)
    assert found == pytest.approx(gap)
    assert sigma == pytest.approx(1.0)


def test_the_unit_does_not_matter():
    x, y = pair(2000, 3.0, 5)
    one = hidden_branches(beside(x, y))
    other = hidden_branches(beside(1e-3 * x, 1e-3 * y))
    assert [h.gap for h in other] == pytest.approx([1e-3 * h.gap for h in one])


def test_few_samples_or_none_say_nothing():
    assert hidden_branches(beside(*pair(20, 3.0, 0))) == []
    assert hidden_branches(beside(np.linspace(0, 1, 500), np.zeros(500), sigma=0.0)) == []
