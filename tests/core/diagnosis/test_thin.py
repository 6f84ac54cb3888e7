import numpy as np

from core.diagnosis.thin import thinnest
from tests.core.diagnosis.drawings import beside, straight


def blurred(n, width, seed):
    """Samples, with noise along and across, of a straight curve of length 300 without a stretch about 100."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.0, 300.0, n)
    x = x[np.abs(x - 100.0) > width / 2]
    return beside(*(np.column_stack((x, 0 * x)) + rng.normal(size=(len(x), 2))).T, 1.0, straight(300.0))


def test_a_gap_of_a_few_sigma_is_found_though_noise_fills_it():
    for seed in range(10):
        across = blurred(6000, 4.0, seed)
        middle, length = thinnest(across)
        assert abs(middle - 100.0) < 3.0
        assert length < 6.0
        assert np.any(np.abs(across.stations - 100.0) < 2.0)


def test_independent_samples_are_nowhere_thin():
    assert sum(thinnest(blurred(6000, 0.0, seed)) is not None for seed in range(60)) <= 2


def test_few_samples_show_nothing():
    assert thinnest(blurred(200, 4.0, 0)) is None
