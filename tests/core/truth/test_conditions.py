from dataclasses import replace

import numpy as np
import pytest

from core.errors import InvalidParameter
from core.truth import PLAIN, Conditions, clearance, oracle_rms, point_set

N = 40000


def residuals(sample):
    """Deviations of the samples from where they were drawn, in units of sigma."""
    mine = sample.curve_of >= 0
    result = np.full(sample.points.shape, np.nan)
    for k, one in enumerate(sample.curves):
        here = mine & (sample.curve_of == k)
        result[here] = (sample.points[here] - one.exact.at(sample.u[here])) / sample.sigma
    return result


def drawn(name="ellipse", n=N, seed=1, outliers=0.0, **conditions):
    return point_set(name, n=n, seed=seed, outliers=outliers, conditions=Conditions(**conditions))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("noise_ratio", 0.5),
        ("density_ratio", float("nan")),
        ("blocks", -1),
        ("degrees_of_freedom", 0.5),
        ("quantum", -1.0),
        ("duplicates", 1.5),
        ("outliers", "none"),
        ("spacing", "odd"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(name, value):
    with pytest.raises(InvalidParameter) as refused:
        Conditions(**{name: value})
    assert refused.value.loc == ("conditions", name)


@pytest.mark.parametrize("name", ["non_uniform", "disjoint", "multi_scan", "helix"])
def test_conditions_that_ask_for_nothing_change_nothing(name):
    plain = point_set(name, n=300, outliers=0.1, seed=3)
    again = point_set(name, n=300, outliers=0.1, seed=3, conditions=replace(PLAIN, blocks=5))
    np.testing.assert_array_equal(plain.points, again.points)
    assert np.nanmax(np.abs(plain.noise - plain.sigma)) == 0.0


def test_conditions_leave_alone_what_they_do_not_ask_for():
    plain, noisy = drawn(n=500), drawn(n=500, noise_ratio=4.0)
    np.testing.assert_array_equal(plain.u, noisy.u)
    np.testing.assert_allclose(
        residuals(noisy) * (noisy.sigma / noisy.noise)[:, None], residuals(plain), atol=1e-9
    )


@pytest.mark.parametrize("name", ["ellipse", "s_shape", "nested"])
def test_noise_runs_from_least_to_four_times_that_and_keeps_its_mean_square(name):
    sample = drawn(name, noise_ratio=4.0)
    assert sample.noise.max() / sample.noise.min() == pytest.approx(4.0, rel=1e-3)
    assert np.mean(sample.noise**2) == pytest.approx(sample.sigma**2, rel=0.03)
    standard = residuals(sample) * (sample.sigma / sample.noise)[:, None]
    np.testing.assert_allclose(np.cov(standard.T), np.eye(2), atol=0.05)
    order = np.lexsort((sample.u, sample.curve_of))
    steps = np.abs(np.diff(sample.noise[order])[np.diff(sample.curve_of[order]) == 0])
    assert steps.max() < 0.02 * sample.sigma


@pytest.mark.parametrize("blocks", [0, 5])
def test_density_varies_ten_to_one(blocks):
    counts = np.histogram(drawn(density_ratio=10.0, blocks=blocks).u, bins=50, range=(0, 1))[0]
    assert counts.max() / counts.min() == pytest.approx(10.0, rel=0.3)
    if blocks:
        dense = counts.reshape(5, 10).sum(axis=1)
        np.testing.assert_allclose(dense / dense[1], [10, 1, 10, 1, 10], rtol=0.15)


def test_density_of_a_condition_multiplies_the_family_s_own():
    counts = np.histogram(drawn("non_uniform", density_ratio=10.0).u, bins=20, range=(0, 1))[0]
    plain = np.histogram(drawn("non_uniform").u, bins=20, range=(0, 1))[0]
    ratio = counts / plain
    assert ratio.max() / ratio.min() == pytest.approx(10.0, rel=0.3)


def test_tails_of_student_are_heavy_and_as_wide_in_the_middle():
    deviation = residuals(drawn(degrees_of_freedom=3.0))
    np.testing.assert_allclose(np.median(np.abs(deviation), axis=0), 0.6745, rtol=0.03)
    assert np.mean(np.abs(deviation) > 6.0) > 0.003
    turned = deviation @ np.array([0.6, 0.8])
    assert np.median(np.abs(turned)) == pytest.approx(0.6745, rel=0.03)


def test_rounded_coordinates_lie_on_a_grid_near_where_they_were():
    plain, rounded = drawn(n=2000), drawn(n=2000, quantum=2.0)
    step = 2.0 * rounded.sigma
    np.testing.assert_allclose(rounded.points / step, np.round(rounded.points / step), atol=1e-9)
    assert np.abs(rounded.points - plain.points).max() <= step / 2 * (1 + 1e-9)


def test_copies_are_exact_and_on_top():
    sample = drawn(n=2000, outliers=0.1, duplicates=0.3)
    assert len(sample.points) == 2860
    assert len(np.unique(sample.points, axis=0)) == 2200
    kept = sample.curve_of >= 0
    assert np.abs(residuals(sample)[kept]).max() < 6.0


def test_clustered_outliers_come_in_blobs_near_the_curve_and_far_from_it():
    sample = drawn(n=5000, outliers=0.08, seed=4)
    uniform = sample.points[sample.curve_of < 0]
    clustered = point_set("ellipse", 5000, None, 0.08, 4, Conditions(outliers="clustered"))
    stray = clustered.points[clustered.curve_of < 0]
    assert len(stray) == len(uniform) == 400
    assert nearest(stray) < 0.6 * nearest(uniform)
    kept, plain = clustered.points[clustered.curve_of >= 0], drawn(n=5000, seed=4).points
    np.testing.assert_array_equal(np.sort(kept[:, 0]), np.sort(plain[:, 0]))


def nearest(points):
    gaps = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(gaps, np.inf)
    return np.median(gaps.min(axis=1))


@pytest.mark.parametrize("name", ["ellipse", "disjoint", "planets_equal"])
def test_even_spacing_leaves_no_gap_wider_than_two(name):
    sample = drawn(name, n=3000, spacing="even")
    assert clearance(sample).gap < 2.05
    assert abs(np.corrcoef(np.arange(3000), sample.u)[0, 1]) < 0.15


def test_curves_of_equal_numbers_have_equal_numbers():
    counts = np.bincount(drawn("planets_equal").curve_of)
    np.testing.assert_allclose(counts / N, 0.2, atol=0.012)
    lengths = [one.length for one in point_set("planets", n=1).curves]
    shares = np.bincount(drawn("planets").curve_of) / N
    np.testing.assert_allclose(shares, np.array(lengths) / sum(lengths), atol=0.012)


def test_scans_keep_their_places():
    with pytest.raises(InvalidParameter):
        drawn("multi_scan", n=100, spacing="even")


def test_copies_tell_the_oracle_nothing_new():
    assert oracle_rms(drawn(n=3000, duplicates=0.5)) == pytest.approx(oracle_rms(drawn(n=3000)), rel=1e-9)


def test_heavy_tails_cost_the_oracle_what_fisher_s_information_says():
    # efficient variance over that of a Gaussian: scale^2 (nu + d + 2) / (nu + d), bandwidth apart
    pairs = [(drawn(n=6000, seed=s, degrees_of_freedom=3.0), drawn(n=6000, seed=s)) for s in range(8)]
    ratio = np.mean([oracle_rms(a) for a, _ in pairs]) / np.mean([oracle_rms(b) for _, b in pairs])
    assert ratio == pytest.approx((0.8818**2 * 7 / 5) ** (4 / 9), rel=0.12)


@pytest.mark.parametrize("seed", range(4))
def test_knowing_the_noise_never_harms_the_oracle(seed):
    sample = drawn(n=4000, seed=seed, noise_ratio=10.0)
    assert oracle_rms(sample) < 1.001 * oracle_rms(replace(sample, conditions=PLAIN))
