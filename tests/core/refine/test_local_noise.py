"""Noise that varies along a curve, from distances drawn with a known one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.local_noise import LocalNoise, sigma_along
from core.refine.noise import noise_of

LENGTH, CUT = 10.0, 4.0


def _wave(station):
    """From 0.5 to 2 and back along a closed curve."""
    return 2.0 ** np.sin(2.0 * np.pi * station / LENGTH)


def _drawn(rng, n, true, normals=1, shape=None):
    station = rng.uniform(0.0, LENGTH, n)
    noise = rng.normal(size=(n, normals)) if shape is None else rng.standard_t(shape, (n, normals))
    return station, true(station) * np.linalg.norm(noise, axis=1)


def _settled(station, distance, closed, normals=1, first=1.24, passes=4):
    """Cut and estimate in turn, as the passes of the refinement do."""
    noise = LocalNoise.constant(first, LENGTH)
    for _ in range(passes):
        near = distance < CUT * noise.at(station)
        noise = sigma_along(station[near], distance[near], LENGTH, closed, noise, CUT, normals)
    return noise


def _even(station):
    return np.ones_like(station)


@pytest.mark.parametrize("n", [300, 3000])
def test_constant_noise_is_that_of_all_samples_together(n):
    station, distance = _drawn(np.random.default_rng(n), n, _even)
    near = distance < CUT * 1.1
    noise = sigma_along(station[near], distance[near], LENGTH, True, 1.1, CUT, spent=5.0)
    assert not noise.varies
    assert noise.mean == pytest.approx(noise_of(distance[near], 5.0, 1.1, CUT, 1))


@pytest.mark.parametrize("shape", [None, 3])
@pytest.mark.parametrize("strays", [0, 100])
def test_neither_tails_nor_outliers_make_a_constant_noise_vary(shape, strays):
    for seed in range(20):
        rng = np.random.default_rng(seed)
        station, distance = _drawn(rng, 1000, _even, shape=shape)
        station = np.append(station, rng.uniform(0.0, LENGTH, strays))
        distance = np.append(distance, rng.uniform(0.0, 20.0, strays))
        assert not _settled(station, distance, True).varies


@pytest.mark.parametrize("normals", [1, 2])
@pytest.mark.parametrize("strays", [0, 100])
def test_a_fourfold_variation_is_found_and_followed(normals, strays):
    rng = np.random.default_rng(normals)
    station, distance = _drawn(rng, 1500, _wave, normals)
    station = np.append(station, rng.uniform(0.0, LENGTH, strays))
    distance = np.append(distance, rng.uniform(0.0, 20.0, strays))
    noise = _settled(station, distance, True, normals)
    at = np.linspace(0.0, LENGTH, 100)
    error = np.log(noise.at(at) / _wave(at))
    assert noise.varies
    assert np.abs(error).max() < 0.35
    assert np.sqrt(np.mean(error**2)) < 0.15


def test_an_open_curve_may_be_noisier_at_one_end():
    def growing(station):
        return 0.5 + 0.15 * station

    station, distance = _drawn(np.random.default_rng(1), 20_000, growing)
    noise = _settled(station, distance, False)
    at = np.linspace(0.0, LENGTH, 50)
    assert np.abs(np.log(noise.at(at) / growing(at))).max() < 0.15


def test_a_closed_curve_has_one_noise_where_it_begins_and_ends():
    station, distance = _drawn(np.random.default_rng(2), 2000, _wave)
    noise = _settled(station, distance, True)
    assert noise.varies
    assert noise.sigma[0] == noise.sigma[-1]


def test_a_blob_of_outliers_beside_the_curve_is_not_its_noise():
    for seed in range(10):
        rng = np.random.default_rng(seed)
        station, distance = _drawn(rng, 1000, _even)
        station = np.append(station, rng.normal(4.0, 0.2, 30))
        distance = np.append(distance, np.abs(rng.normal(5.0, 1.0, 30)))
        assert _settled(station, distance, True).largest < 1.7


def test_samples_that_count_half_say_the_same_as_half_the_samples():
    station, distance = _drawn(np.random.default_rng(3), 4000, _wave)
    near = distance < CUT * 1.24
    whole = sigma_along(station[near], distance[near], LENGTH, True, 1.24, CUT)
    twice = sigma_along(
        np.tile(station[near], 2), np.tile(distance[near], 2), LENGTH, True, 1.24, CUT,
        weight=np.full(2 * near.sum(), 0.5),
    )  # fmt: skip
    assert twice.sigma == pytest.approx(whole.sigma, rel=1e-9)


@settings(deadline=None, max_examples=20)
@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_units_of_length_and_of_distance_do_not_matter(along, across):
    station, distance = _drawn(np.random.default_rng(4), 1000, _wave)
    near = distance < CUT * 1.24
    station, distance = station[near], distance[near]
    one = sigma_along(station, distance, LENGTH, True, 1.24, CUT)
    other = sigma_along(along * station, across * distance, along * LENGTH, True, across * 1.24, CUT)
    at = np.linspace(0.0, LENGTH, 30)
    # A rounded sample may change its bin.
    assert other.at(along * at) == pytest.approx(across * one.at(at), rel=0.02)


def test_no_samples_leave_the_noise_as_it_was():
    before = LocalNoise.constant(0.3, LENGTH)
    assert sigma_along(np.zeros(0), np.zeros(0), LENGTH, True, before, CUT) is before


def test_the_mean_is_that_of_the_variance():
    noise = LocalNoise(np.array([0.0, 4.0, 10.0]), np.array([1.0, 1.0, 3.0]))
    s = np.linspace(0.0, 10.0, 100_001)
    assert noise.mean == pytest.approx(np.sqrt(np.mean(noise.at(s) ** 2)), rel=1e-4)
    assert noise.largest == 3.0
    assert noise.scaled(2.0).mean == pytest.approx(2.0 * noise.mean)


@pytest.mark.parametrize("more", [1.0, -1.0])
def test_a_longer_or_shorter_curve_keeps_its_noise_where_it_was(more):
    noise = LocalNoise(np.linspace(0.0, 10.0, 201), np.linspace(1.0, 3.0, 201))
    other = noise.between(-more, 10.0 + more)
    at = np.linspace(2.0, 8.0, 20)
    assert other.length == 10.0 + 2.0 * more
    assert other.at(at + more) == pytest.approx(noise.at(at), rel=0.01)


def test_a_stretched_curve_keeps_the_course_of_its_noise():
    noise = LocalNoise(np.array([0.0, 4.0, 10.0]), np.array([1.0, 2.0, 3.0]))
    assert noise.stretched(20.0).at(np.array([0.0, 8.0, 14.0, 20.0])).tolist() == [1.0, 2.0, 2.5, 3.0]
