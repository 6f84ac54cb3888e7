import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.noise import mass, mean_square, noise_of, truncated_deviation


def away(n, sigma, normals, seed=0):
    """Distances from a curve of Gaussian samples."""
    return sigma * np.linalg.norm(np.random.default_rng(seed).normal(size=(n, normals)), axis=1)


@pytest.mark.parametrize("normals", [1, 2])
@pytest.mark.parametrize("cut", [3.0, 4.0, 6.0])
def test_what_the_cut_takes_away_is_given_back(cut, normals):
    distance = away(200_000, 0.7, normals)
    seen = distance[distance < cut * 0.7]
    assert noise_of(seen, 0.0, 0.7, cut, normals) == pytest.approx(0.7, rel=0.01)
    spread = np.sqrt(np.mean(seen**2) / normals)
    assert truncated_deviation(cut, normals) == pytest.approx(spread / 0.7, rel=0.01)


@pytest.mark.parametrize("normals", [1, 2])
def test_a_wide_cut_truncates_nothing(normals):
    assert truncated_deviation(12.0, normals) == pytest.approx(1.0)
    widths = [truncated_deviation(cut, normals) for cut in (1.0, 2.0, 3.0, 4.0)]
    assert widths == sorted(widths)


@pytest.mark.parametrize("spent", [10.0, 50.0])
def test_the_fit_has_used_up_some_of_the_samples(spent):
    distance = away(100, 1.0, 1)
    ratio = noise_of(distance, spent, 1.0, 12.0, 1) / noise_of(distance, 0.0, 1.0, 12.0, 1)
    assert ratio == pytest.approx(np.sqrt(100 / (100 - spent)))


@pytest.mark.parametrize("normals", [1, 2])
@pytest.mark.parametrize("share", [0.02, 0.1])
@pytest.mark.parametrize("cut", [4.0, 5.0, 12.0])
def test_a_background_of_outliers_raises_the_noise_little(cut, share, normals):
    rng = np.random.default_rng(1)
    clean = away(20_000, 1.0, normals)
    stray = cut * rng.uniform(size=int(share * 20_000)) ** (1.0 / normals)
    seen = np.concatenate((clean[clean < cut], stray))
    assert noise_of(seen, 0.0, 1.0, cut, normals) == pytest.approx(1.0, rel=0.05)


@settings(max_examples=100, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 300),
    st.floats(0.0, 0.2),
    st.sampled_from([3.0, 4.0, 5.0, 12.0]),
    st.sampled_from([1, 2]),
)
def test_samples_off_the_curve_always_have_some_noise(seed, n, share, cut, normals):
    rng = np.random.default_rng(seed)
    clean = away(n, 1.0, normals, seed)
    seen = np.concatenate((clean, cut * rng.uniform(size=round(share * n))))
    seen = seen[seen < cut]
    noise = noise_of(seen, 3.0, 1.0, cut, normals)
    assert np.isfinite(noise)
    # Taking a background out never takes the noise of Gaussian samples with it.
    if n >= 100:
        assert 0.4 < noise < 1.0 + cut * share + 0.5
    elif len(seen) > 8:
        assert noise > 0.0


def test_samples_on_the_curve_have_none():
    assert noise_of(np.zeros(100), 5.0, 0.0, 4.0, 1) == 0.0
    assert noise_of(np.zeros(100), 5.0, 1.0, 4.0, 1) == 0.0


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_noise_scales(factor):
    distance = away(500, 1.0, 1)
    distance = distance[distance < 4.0]
    one = noise_of(distance, 5.0, 1.0, 4.0, 1)
    assert noise_of(factor * distance, 5.0, factor, 4.0, 1) == pytest.approx(factor * one)


@pytest.mark.parametrize("share", [0.0, 0.1])
@pytest.mark.parametrize("cut", [3.0, 4.0])
def test_weights_count_samples(cut, share):
    rng = np.random.default_rng(2)
    clean = away(3000, 1.0, 1)
    seen = np.concatenate((clean[clean < cut], cut * rng.uniform(size=int(3000 * share))))
    once = noise_of(seen, 7.0, 1.0, cut, 1)
    assert noise_of(seen, 7.0, 1.0, cut, 1, np.ones(len(seen))) == pytest.approx(once, rel=1e-12)
    # Each sample in three parts is one sample.
    parts = np.repeat([0.5, 0.3, 0.2], len(seen))
    assert noise_of(np.tile(seen, 3), 7.0, 1.0, cut, 1, parts) == pytest.approx(once, rel=1e-12)
    # A sample without weight is none.
    far = np.concatenate((seen, np.full(500, 0.99 * cut)))
    weight = np.concatenate((np.ones(len(seen)), np.zeros(500)))
    assert noise_of(far, 7.0, 1.0, cut, 1, weight) == pytest.approx(once, rel=1e-12)


def test_a_mass_that_is_a_whole_number_is_free_of_rounding():
    weight = np.random.default_rng(3).uniform(size=1000)
    both = np.concatenate((weight, 1.0 - weight))
    assert mass(2000, both) == 1000.0
    assert mass(2000, None) == 2000.0
    assert mean_square(np.full(2000, 3.0), both) == pytest.approx(9.0)
