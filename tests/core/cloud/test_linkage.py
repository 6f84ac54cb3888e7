import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.linkage import components
from core.cloud.points import bounds
from tests.core.cloud import brute

DIMENSIONS = st.sampled_from([2, 3])


@st.composite
def lattices(draw):
    """Points with small integer coordinates, and the square of an epsilon: ties all the time."""
    dimension = draw(DIMENSIONS)
    extent = draw(st.integers(1, 60 if dimension == 2 else 12))
    seed = draw(st.integers(0, 2**32 - 1))
    count = draw(st.integers(1, 300))
    points = np.random.default_rng(seed).integers(-extent, extent + 1, (count, dimension)).astype(float)
    return points, draw(st.integers(1, 4 * extent * extent))


@given(lattices())
@settings(max_examples=300, deadline=None)
def test_components_equal_brute_force_ties_included(case):
    points, square = case
    epsilon = float(np.sqrt(square))
    np.testing.assert_array_equal(components(points, epsilon), brute.components(points, epsilon))


@given(lattices())
@settings(max_examples=100, deadline=None)
def test_an_epsilon_just_below_a_distance_does_not_join(case):
    points, square = case
    epsilon = float(np.nextafter(np.sqrt(square), 0.0))
    np.testing.assert_array_equal(components(points, epsilon), brute.components(points, epsilon))


@given(DIMENSIONS, st.integers(0, 2**32 - 1), st.floats(1e-4, 3.0))
@settings(max_examples=150, deadline=None)
def test_random_points_equal_brute_force(dimension, seed, epsilon):
    generator = np.random.default_rng(seed)
    centres = generator.uniform(-1, 1, (8, dimension))
    spread = 10.0 ** generator.uniform(-4, 0, (8, 1))
    which = generator.integers(0, 8, 300)
    points = centres[which] + spread[which] * generator.normal(size=(300, dimension))
    np.testing.assert_array_equal(components(points, epsilon), brute.components(points, epsilon))


@given(lattices(), st.integers(-960, 950))
@settings(max_examples=100, deadline=None)
def test_a_power_of_two_in_scale_changes_nothing(case, exponent):
    points, square = case
    epsilon = float(np.sqrt(square))
    scaled = components(np.ldexp(points, exponent), float(np.ldexp(epsilon, exponent)))
    np.testing.assert_array_equal(scaled, brute.components(points, epsilon))


@given(lattices(), st.integers(0, 2**32 - 1))
@settings(max_examples=100, deadline=None)
def test_order_and_exact_offsets_change_nothing(case, seed):
    points, square = case
    epsilon = float(np.sqrt(square))
    order = np.random.default_rng(seed).permutation(len(points))
    labels = components(points, epsilon)
    moved = components(points[order] + 2.0**45, epsilon)
    pairs = set(zip(labels[order].tolist(), moved.tolist(), strict=True))
    assert len(pairs) == labels.max() + 1 == moved.max() + 1


@given(DIMENSIONS, st.integers(0, 2**32 - 1), st.integers(1, 40))
@settings(max_examples=100, deadline=None)
def test_an_epsilon_far_below_the_extent_is_exact(dimension, seed, square):
    """Lattices of spacing 2^-44 on a few sites whole units apart: more cells than any index could number."""
    generator = np.random.default_rng(seed)
    sites = generator.integers(-200, 200, (6, dimension)).astype(float)
    lattice = generator.integers(-8, 9, (200, dimension)).astype(float)
    points = sites[generator.integers(0, 6, 200)] + lattice * 2.0**-44
    epsilon = float(np.sqrt(square) * 2.0**-44)
    np.testing.assert_array_equal(components(points, epsilon), brute.components(points, epsilon))


@pytest.mark.parametrize("dimension", [2, 3])
def test_single_points_without_number_stay_apart(dimension):
    points = np.random.default_rng(1).normal(size=(100_000, dimension))
    np.testing.assert_array_equal(components(points, 1e-14), np.arange(100_000))


@pytest.mark.parametrize("gap", [1 - 1e-9, 1.0, 1 + 1e-9])
@pytest.mark.parametrize("shape", ["arcs", "lines", "clump and arc", "staggered"])
def test_crowded_cells_touch_exactly_when_a_pair_does(shape, gap):
    """Three thousand points on either side of a gap that is as wide as epsilon, or nearly."""
    t = np.linspace(0, 0.3, 3000)
    arc = np.column_stack((np.cos(t), np.sin(t)))
    line = np.column_stack((t, np.zeros_like(t)))
    near, far = {
        "arcs": (arc * 1e3, arc * (1e3 + gap)),
        "lines": (line, np.add(line, [0, gap])),
        "clump and arc": (line * 1e-12, arc * gap),
        "staggered": (line[::2], np.add(line[1::2], [0, gap])),
    }[shape]
    smallest = brute_distance(near, far)
    assert 0.999 < smallest < 1.001
    labels = components(np.concatenate((near, far)), 1.0)
    assert (labels.max() == 0) == (smallest <= 1.0)


def brute_distance(points, others):
    """Least distance between two sets on smooth arcs, computed as the graph's definition has it."""
    least = np.inf
    for start in range(0, len(points), 400):
        block = points[start : start + 400]
        least = min(least, np.sum((block[:, None] - others[None]) ** 2, axis=-1).min())
    return np.sqrt(least)


def test_everything_is_one_component_beyond_the_extent():
    points = np.random.default_rng(2).normal(size=(1000, 3))
    reach = float(np.linalg.norm(bounds(points)[1] - bounds(points)[0]))
    assert components(points, reach).max() == 0
    assert components(points, 1e300).max() == 0


def test_coincident_points_are_one_component():
    assert components(np.full((1000, 2), 1 / 3), 5e-324).max() == 0


def test_one_point_is_one_component():
    assert components(np.array([[1.0, 2.0, 3.0]]), 1.0).tolist() == [0]


@pytest.mark.parametrize("epsilon", [5e-324, 1e-300, 1.0, 1e300, 1.7e308])
def test_coordinates_at_the_limits_of_doubles(epsilon):
    points = np.array([[-1.7e308, 1.7e308], [1.7e308, 1.7e308], [0.0, 0.0], [0.0, 5e-324], [1e-300, 0.0]])
    joined = components(points, epsilon)
    # Distances: the first two are farther apart than any double, the last three closer than 1e-299.
    assert joined[0] != joined[1]
    assert joined[2] == joined[3]
    assert (joined[2] == joined[4]) == (epsilon >= 1e-300)


def test_input_is_left_as_it_was():
    points = np.random.default_rng(3).normal(size=(5000, 2))
    before = points.copy()
    components(points, 0.5)
    np.testing.assert_array_equal(points, before)
