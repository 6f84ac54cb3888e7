import numpy as np
import pytest

from core.diagnosis.gaps import expected_gap, longest_gap, widest_gap
from tests.core.diagnosis.drawings import ring, straight


def test_the_longest_gap_between_samples_and_ends():
    line = straight(10.0)
    assert longest_gap(line, np.array([1.0, 2.0, 6.0, 9.0])) == pytest.approx((4.0, 4.0))
    assert longest_gap(line, np.array([5.0, 6.0])) == pytest.approx((2.5, 5.0))
    assert longest_gap(line, np.array([])) == pytest.approx((5.0, 10.0))


def test_a_gap_over_the_seam_of_a_closed_curve():
    line = ring(1.0)
    middle, length = longest_gap(line, np.linspace(1.0, line.length - 0.5, 400))
    assert length == pytest.approx(1.5)
    assert middle == pytest.approx(0.25)


def test_independent_samples_rarely_leave_more_than_expected():
    line, beyond = straight(1.0), 0
    for seed in range(300):
        n = 500
        station = np.sort(np.random.default_rng(seed).uniform(0.0, 1.0, n))
        gap = widest_gap(line, station, n)
        beyond += gap.spacings > gap.expected
    assert beyond <= 9  # of 300, where at most 3 are due


@pytest.mark.parametrize("closed", [True, False])
def test_a_true_gap_is_longer_than_expected(closed):
    line = ring(1.0) if closed else straight(2 * np.pi)
    for seed in range(20):
        n = 1000
        width = 3.0 * (np.log(n) + 4.6) * line.length / n
        low = np.random.default_rng(seed).uniform(0.0, line.length - width)
        station = np.random.default_rng([seed, 1]).uniform(0.0, line.length - width, n)
        station = np.sort(np.where(station > low, station + width, station))
        gap = widest_gap(line, station, n)
        assert gap.spacings > gap.expected
        assert gap.middle == pytest.approx(low + width / 2, abs=0.3 * width)
        assert gap.length >= width * (1 - 1e-9)


def test_a_density_that_changes_makes_no_gap():
    line, beyond = straight(1.0), 0
    for seed in range(100):
        u = np.random.default_rng(seed).uniform(0.0, 1.0, 2000)
        gap = widest_gap(line, np.sort(np.expm1(u * np.log(11.0)) / 10.0), 2000)
        beyond += gap.spacings > gap.expected
    assert beyond <= 4


def test_what_to_expect_grows_with_the_samples_and_with_what_is_not_known():
    assert expected_gap(1000, 1e9) == pytest.approx(np.log(1000) + 4.6, abs=0.01)
    assert expected_gap(10_000, 60) > expected_gap(1000, 60) > expected_gap(1000, 600)


def test_repeated_samples_are_no_end_of_the_scale():
    station = np.sort(np.repeat(np.random.default_rng(0).uniform(0.0, 1.0, 300), 3))
    gap = widest_gap(straight(1.0), station, 900)
    assert np.isfinite([gap.spacings, gap.expected]).all()


def test_few_samples_say_nothing():
    assert widest_gap(straight(1.0), np.array([0.1, 0.5]), 2) is None
    assert widest_gap(straight(1.0), np.array([]), 0) is None
