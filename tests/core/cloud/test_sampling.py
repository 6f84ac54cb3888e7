import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.sampling import Sample, estimate_scale, spread_subsample
from tests.core.shapes import arc, in_space, line, rotation


def as_rows(points):
    return sorted(map(tuple, points.tolist()))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 150), st.sampled_from([2, 3]))
def test_a_subsample_is_a_choice_without_repetition(seed, size, dimension):
    points = np.random.default_rng(seed).normal(size=(100, dimension))
    chosen = spread_subsample(points, size)
    assert len(chosen) == min(size, 100)
    assert len(np.unique(chosen)) == len(chosen)
    assert chosen.min() >= 0
    assert chosen.max() < 100


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_the_choice_depends_neither_on_order_nor_on_frame(seed, dimension):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, dimension))
    chosen = set(spread_subsample(points, 40).tolist())
    order = rng.permutation(200)
    assert set(order[spread_subsample(points[order], 40)].tolist()) == chosen
    moved = 3.7 * points @ rotation(rng, dimension).T + rng.normal(size=dimension)
    assert set(spread_subsample(moved, 40).tolist()) == chosen


def test_a_small_sample_stands_for_itself():
    points = np.random.default_rng(0).normal(size=(300, 3))
    sample = Sample.of(points)
    assert sample.thinning == 1.0
    np.testing.assert_array_equal(sample.few, sample.points)


def test_a_large_sample_keeps_its_density_in_the_few():
    points = in_space(arc(100_000, 0.01))
    sample = Sample.of(points)
    assert len(sample.few) < len(points)
    assert sample.thinning == pytest.approx(len(sample.few) / len(points))
    angle = np.arctan2(sample.few[:, 1], sample.few[:, 0])
    octants = np.histogram(angle, 8, (-np.pi, np.pi))[0] / len(sample.few)
    np.testing.assert_allclose(octants, 1 / 8, atol=0.015)


@pytest.mark.parametrize("n", [1000, 30_000])
@pytest.mark.parametrize(("radius", "share"), [(1.0, 0.01), (250.0, 0.004)])
def test_noise_density_and_curvature_of_a_circle(n, radius, share):
    sigma = share * radius
    scale = estimate_scale(Sample.of(in_space(arc(n, sigma, radius))), 1.1 * radius, True)
    assert scale.sigma == pytest.approx(sigma, rel=0.15)
    assert scale.density == pytest.approx(n / (2 * np.pi * radius), rel=0.15)
    assert scale.curvature == pytest.approx(1 / radius, rel=0.6)
    assert scale.radius == pytest.approx(15**0.25 * np.sqrt(sigma * radius), rel=0.35)


def test_the_density_is_that_of_a_typical_place_not_of_a_typical_sample():
    dense, sparse = arc(4000, 0.005, turn=np.pi, seed=1), arc(1000, 0.005, turn=np.pi, seed=2)
    points = in_space(np.concatenate((dense, -sparse)))
    scale = estimate_scale(Sample.of(points), 1.1, True)
    by_sample, by_length = (4000**2 + 1000**2) / 5000 / np.pi, 5000 / (2 * np.pi)
    assert abs(scale.density - by_length) < 0.4 * (by_sample - by_length)


def test_the_density_of_a_straight_segment():
    scale = estimate_scale(Sample.of(in_space(line(3000, 0.01, length=2.0))), 1.1, True)
    assert scale.density == pytest.approx(1500, rel=0.2)


def test_noise_in_space_has_two_directions():
    points = line(3000, 0.01, dimension=3)
    assert estimate_scale(Sample.of(points), 0.6, False).sigma == pytest.approx(0.01, rel=0.1)


def test_a_line_without_noise_has_no_sigma():
    points = in_space(line(500, 0.0))
    assert estimate_scale(Sample.of(points), 0.6, True).sigma < 1e-6


def test_too_few_points_have_no_scale():
    points = in_space(line(6, 0.01))
    assert estimate_scale(Sample.of(points), 0.6, True) is None


def test_the_scale_scales():
    points = in_space(arc(2000, 0.01))
    one = estimate_scale(Sample.of(points), 1.1, True)
    two = estimate_scale(Sample.of(points * 8.0), 8.8, True)
    assert two.sigma == pytest.approx(8 * one.sigma)
    assert two.radius == pytest.approx(8 * one.radius)
    assert two.density == pytest.approx(one.density / 8)
    assert two.curvature == pytest.approx(one.curvature / 8)
