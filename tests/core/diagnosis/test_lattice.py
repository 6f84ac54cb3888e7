import numpy as np
import pytest

from core.diagnosis.lattice import Lattice
from core.methods import diagnose
from core.truth import Conditions, point_set


def band(n, seed):
    """Samples of a slanting course of length 300, with noise."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.0, 300.0, n)
    return np.column_stack((0.8 * x, 0.6 * x)) + rng.normal(size=(n, 2))


def test_a_grid_is_coarse_when_its_steps_are_like_the_noise():
    points = band(4000, 0)
    assert not Lattice.of(points, 1.0).coarse
    assert not Lattice.of(np.round(points / 0.4) * 0.4, 1.0).coarse
    assert Lattice.of(np.round(points / 1.5) * 1.5, 1.0).coarse


@pytest.mark.parametrize("step", [0.2, 1.0])
def test_different_samples_on_a_grid_share_coordinates(step):
    points = band(4000, 1)
    assert Lattice.of(np.round(points / step) * step, 1.0).gridded


@pytest.mark.parametrize("times", [1, 2, 5])
def test_copies_are_no_grid(times):
    points = np.repeat(band(4000, 2), times, axis=0)
    assert Lattice.of(points, 1.0) == Lattice(False, False)


def test_copies_tell_nothing_new():
    sample = point_set("ellipse", n=1500, sigma=0.01, seed=4)
    one = diagnose(sample.points).sampling
    twice = diagnose(np.repeat(sample.points, 2, axis=0)).sampling
    assert twice.nyquist.compliant == one.nyquist.compliant
    assert twice.sigma_error == pytest.approx(one.sigma_error, rel=0.2)
    assert twice.largest_gap.spacings == pytest.approx(one.largest_gap.spacings, rel=0.1)


@pytest.mark.parametrize("n", [1000, 4000])
def test_copies_and_grids_are_sound(n):
    for conditions in (Conditions(duplicates=0.3), Conditions(quantum=0.5)):
        sample = point_set("bean", n=n, sigma=0.005, seed=3, conditions=conditions)
        assert diagnose(sample.points).sampling.nyquist.compliant
