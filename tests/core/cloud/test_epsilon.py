import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.epsilon import estimate_epsilon, least_component_size
from core.cloud.linkage import components
from core.truth import point_set
from tests.core.cloud import brute

SINGLE = [
    "circle", "ellipse", "s_shape", "spiral", "non_uniform", "square", "star", "wasp_waist", "figure_8",
    "multi_scan", "tilted", "helix", "trefoil", "c_arc",
]  # fmt: skip


def kept(labels):
    """Sizes of the components that are no outliers, by decreasing size."""
    sizes = np.bincount(labels)
    return -np.sort(-sizes[sizes >= least_component_size(len(labels))])


def turn(count=3000, radius=1.0, centre=(0.0, 0.0), seed=0, regular=False):
    """Points of a circle, independent or regular."""
    t = np.arange(count) / count if regular else np.random.default_rng(seed).uniform(size=count)
    return np.column_stack((np.cos(2 * np.pi * t), np.sin(2 * np.pi * t))) * radius + centre


@pytest.mark.parametrize("outliers", [0.0, 0.05])
@pytest.mark.parametrize(("n", "sigma"), [(300, 0.01), (1000, 0.0025), (5000, 0.02), (30_000, 0.01)])
@pytest.mark.parametrize("name", SINGLE)
def test_one_curve_is_one_component(name, n, sigma, outliers):
    sample = point_set(name, n=n, sigma=sigma, outliers=outliers, seed=3)
    labels = components(sample.points, estimate_epsilon(sample.points))
    whole = np.argmax(np.bincount(labels))
    drawn = sample.curve_of >= 0
    assert np.mean(labels[drawn] == whole) > 0.98
    assert kept(labels)[1:].sum() <= 0.01 * n


@pytest.mark.parametrize("n", [1000, 10_000, 50_000])
@pytest.mark.parametrize(("name", "sigma"), [("nested", 0.005), ("disjoint", 0.01), ("parallel_waves", 0.01)])
def test_curves_far_apart_come_apart(name, sigma, n):
    sample = point_set(name, n=n, sigma=sigma, seed=2)
    labels = components(sample.points, estimate_epsilon(sample.points))
    assert len(kept(labels)) == len(sample.curves)
    for k in range(len(sample.curves)):
        assert np.bincount(labels[sample.curve_of == k]).max() > 0.98 * np.sum(sample.curve_of == k)


@pytest.mark.parametrize("count", [1000, 30_000])
def test_a_regular_sample_needs_no_more_than_a_few_of_its_steps(count):
    points = turn(count, regular=True)
    step = 2 * np.sin(np.pi / count)
    assert step < estimate_epsilon(points) < 4 * step


def test_an_independent_sample_needs_more_than_its_longest_gap():
    points = turn(2000, seed=1)
    angles = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    gaps = np.sort(np.diff(angles, append=angles[0] + 2 * np.pi))
    assert gaps[-2] < estimate_epsilon(points) < 3 * gaps[-1]


@pytest.mark.parametrize("repeats", [2, 30])
def test_repeated_points_change_nothing(repeats):
    points = point_set("nested", n=2000, sigma=0.005).points
    order = np.random.default_rng(0).permutation(repeats * len(points))
    assert estimate_epsilon(np.repeat(points, repeats, axis=0)[order]) == pytest.approx(
        estimate_epsilon(points)
    )


@pytest.mark.parametrize("cell", [0.002, 0.01, 0.03])
@pytest.mark.parametrize("sigma", [0.0, 0.01])
def test_coordinates_rounded_to_a_grid_stay_together(sigma, cell):
    points = point_set("ellipse", n=5000, sigma=sigma).points
    step = cell * np.linalg.norm(np.ptp(points, axis=0))
    rounded = np.round(points / step) * step
    assert kept(components(rounded, estimate_epsilon(rounded))).tolist()[0] > 0.98 * len(points)


def test_curves_of_very_different_size_are_told_apart():
    points = np.concatenate(
        (turn(2000), turn(2000, 1e-3, (3.0, 0.0), seed=1), turn(2000, 1.0, (1e6, 0.0), seed=2))
    )
    assert kept(components(points, estimate_epsilon(points))).tolist() == [2000, 2000, 2000]


@given(
    st.sampled_from(["spiral", "disjoint", "trefoil"]),
    st.integers(0, 2**32 - 1),
    st.floats(-100, 100),
    st.sampled_from([0.0, 1e3, 1e7]),
)
@settings(max_examples=25, deadline=None)
def test_moving_turning_scaling_and_shuffling_change_nothing(name, seed, power, offset):
    points = point_set(name, n=1500, sigma=0.01, seed=1).points
    generator = np.random.default_rng(seed)
    dimension = points.shape[1]
    moved = points @ brute.rotation(generator, dimension).T
    moved = (moved + offset * np.ptp(points) * generator.normal(size=dimension)) * 10.0**power
    order = generator.permutation(len(points))
    epsilon = estimate_epsilon(points)
    # An offset rounds the coordinates themselves.
    assert estimate_epsilon(moved[order]) == pytest.approx(
        10.0**power * epsilon, rel=1e-9 if offset == 0 else 0.02
    )
    still, turned = components(points, epsilon), components(moved[order], estimate_epsilon(moved[order]))
    assert kept(still).tolist() == kept(turned).tolist()


@pytest.mark.parametrize("count", [1, 2, 3, 5, 10, 20, 50])
@pytest.mark.parametrize("dimension", [2, 3])
def test_few_points_on_a_line_are_one_component(count, dimension):
    line = np.outer(np.arange(count), np.arange(1.0, dimension + 1))
    assert kept(components(line, estimate_epsilon(line))).tolist() == [count]


@pytest.mark.parametrize("side", [3, 10, 100])
def test_a_grid_is_one_component(side):
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2).astype(float)
    assert kept(components(grid, estimate_epsilon(grid))).tolist() == [side * side]


@pytest.mark.parametrize("place", [0.0, 1.0, -1e300, 5e-324])
@pytest.mark.parametrize("count", [1, 2, 100])
def test_coincident_points_have_a_positive_epsilon_that_joins_nothing_else(place, count):
    epsilon = estimate_epsilon(np.full((count, 2), place))
    assert 0 < epsilon <= 1e-15 * abs(place) + 1e-322


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e160, 1e300, 1.7e308])
def test_extreme_sizes(size):
    points = turn(500) * size
    epsilon = estimate_epsilon(points)
    assert epsilon / size == pytest.approx(estimate_epsilon(turn(500)), rel=1e-6)


@given(st.integers(1, 10**7))
def test_the_least_size_never_exceeds_the_number_of_points_and_grows_with_it(count):
    assert 1 <= least_component_size(count) <= min(count, 19)
    assert least_component_size(count) <= least_component_size(3 * count) <= least_component_size(count) + 2


def stepped(name, n, sigma, ratio, seed):
    """Samples of one curve, one half of its length ``ratio`` times denser, and which are of it."""
    sample = point_set(name, n=n, sigma=sigma, seed=seed)
    curve = sample.curves[0].exact
    generator = np.random.default_rng(seed)
    dense = generator.uniform(size=n) < ratio / (ratio + 1)
    u = np.where(dense, 0.0, 0.5) + generator.uniform(0, 0.5, n)
    return curve.at(u) + sample.sigma * generator.normal(size=(n, 2)), dense


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sigma", [0.005, 0.015])
@pytest.mark.parametrize("name", ["wave", "c_arc", "ellipse", "random_open"])
def test_a_half_ten_times_sparser_is_not_given_up(name, sigma, seed):
    points, dense = stepped(name, 2000, sigma, 10, seed)
    labels = components(points, estimate_epsilon(points))
    whole = np.argmax(np.bincount(labels))
    assert np.mean(labels[~dense] == whole) > 0.95


@pytest.mark.parametrize("quantum", [1.5, 2.0])
def test_samples_on_a_coarse_lattice_need_a_few_of_its_steps(quantum):
    sample = point_set("bean", n=5000, sigma=0.01, seed=1)
    step = quantum * sample.sigma
    rounded = np.round(sample.points / step) * step
    assert 1.4 * step < estimate_epsilon(rounded) < 4 * step
    assert kept(components(rounded, estimate_epsilon(rounded)))[0] > 0.98 * len(rounded)
