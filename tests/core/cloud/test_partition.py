import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import core.cloud
from core.cloud.epsilon import estimate_epsilon, least_component_size
from core.cloud.frame import principal_frame
from core.cloud.partition import partition
from core.errors import InvalidPoints
from core.parameters import PartitionParameters, PcaParameters
from core.truth import point_set
from tests.core.cloud import brute

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def blobs(generator, sizes, dimension=2):
    """Tight blobs of the given sizes, ten apart."""
    places = [
        10.0 * k * np.eye(dimension)[0] + generator.uniform(0, 1, (n, dimension)) for k, n in enumerate(sizes)
    ]
    return np.concatenate(places)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=8), st.integers(1, 80), st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_components_are_numbered_by_size_and_small_ones_are_outliers(sizes, least, seed):
    generator = np.random.default_rng(seed)
    answer = partition(blobs(generator, sizes), PartitionParameters(epsilon=2.0, min_component_size=least))
    expected = sorted((n for n in sizes if n >= least), reverse=True)
    assert answer.count == len(expected)
    assert [one.size for one in answer.components] == expected
    assert [one.label for one in answer.components] == list(range(len(expected)))
    assert np.bincount(answer.labels + 1, minlength=1)[1:].tolist() == expected
    truth = np.repeat(np.arange(len(sizes)), sizes)
    for k in range(answer.count):
        assert len(set(truth[answer.labels == k])) == 1


def test_each_component_has_its_box_and_its_frame():
    sample = point_set("disjoint", n=2000, sigma=0.005, outliers=0.05)
    answer = partition(sample.points)
    assert answer.count == 4
    for one in answer.components:
        members = sample.points[answer.labels == one.label]
        np.testing.assert_array_equal(one.bbox, [members.min(axis=0), members.max(axis=0)])
        alone = principal_frame(members)
        assert one.frame.component == one.label
        assert one.size == len(members)
        np.testing.assert_allclose(one.frame.origin, alone.origin, atol=1e-9)
        np.testing.assert_allclose(one.frame.axes, alone.axes, atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_given_epsilon_makes_exactly_its_components(dimension):
    points = np.random.default_rng(1).uniform(size=(600, dimension))
    answer = partition(points, PartitionParameters(epsilon=0.07, min_component_size=1))
    assert answer.epsilon == 0.07
    assert answer.epsilon_source == "given"
    pairs = set(zip(answer.labels.tolist(), brute.components(points, 0.07).tolist(), strict=True))
    assert len(pairs) == answer.count == brute.components(points, 0.07).max() + 1


def test_without_parameters_the_data_decide():
    points = point_set("nested", n=3000, sigma=0.003).points
    answer = partition(points)
    assert answer.epsilon == estimate_epsilon(points)
    assert answer.epsilon_source == "estimated"
    assert answer.count == 3
    assert answer.warnings == ()


def test_parameters_of_a_method_will_do():
    answer = partition(np.zeros((3, 2)), PcaParameters(epsilon=1.0, min_component_size=4))
    assert answer.labels.tolist() == [-1, -1, -1]


def test_lists_are_taken_and_bad_points_refused():
    assert partition([[0, 0], [1, 0], [2, 0]], PartitionParameters(epsilon=1.0)).count == 1
    with pytest.raises(InvalidPoints) as caught:
        partition([[0.0, 0.0], [1.0, float("nan")]])
    assert caught.value.loc == ("points", 1, 1)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_equal_sizes_are_numbered_alike_in_every_order_and_place(seed):
    generator = np.random.default_rng(seed)
    centres = np.array([[0.0, 0], [30, 0], [0, 20], [-45, 3], [7, -60]])
    points = np.concatenate([centre + generator.uniform(-1, 1, (20, 2)) for centre in centres])
    rule = PartitionParameters(epsilon=2.5)
    labels = partition(points, rule).labels
    order = generator.permutation(len(points))
    np.testing.assert_array_equal(partition(points[order], rule).labels, labels[order])
    moved = points @ brute.rotation(generator, 2).T + generator.normal(size=2) * 1e3
    np.testing.assert_array_equal(partition(moved, rule).labels, labels)
    # Nearest to the centre of all points first.
    distances = [np.linalg.norm(points[labels == k].mean(axis=0) - points.mean(axis=0)) for k in range(5)]
    assert distances == sorted(distances)


def test_symmetric_components_are_numbered_alike_in_every_order():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    points = np.concatenate([square + centre for centre in ([0, 0], [9, 0], [0, 9], [9, 9])])
    rule = PartitionParameters(epsilon=1.0)
    labels = partition(points, rule).labels
    for seed in range(20):
        order = np.random.default_rng(seed).permutation(len(points))
        np.testing.assert_array_equal(partition(points[order], rule).labels, labels[order])


def test_nothing_but_outliers_is_said():
    answer = partition(np.arange(200.0).reshape(100, 2), PartitionParameters(epsilon=1.0))
    assert answer.components == ()
    assert (answer.labels == -1).all()
    assert [one.code for one in answer.warnings] == ["no-component"]


def test_many_outliers_are_said():
    generator = np.random.default_rng(2)
    points = np.concatenate((generator.uniform(0, 1, (60, 2)), generator.uniform(10, 1e6, (40, 2))))
    answer = partition(points, PartitionParameters(epsilon=0.5))
    assert answer.count == 1
    assert [one.code for one in answer.warnings] == ["many-outliers"]


@pytest.mark.parametrize("points", [
    np.zeros((1, 2)),
    np.ones((2, 3)),
    np.full((500, 2), 1e300),
    np.array([[0.0, 0.0], [1e-300, 1e300]]),
    np.outer(np.arange(100.0), [1.0, 1.0, 1.0]),
    np.outer(np.arange(100.0) // 10, [1.0, 1.0]),
    np.stack(np.meshgrid(np.arange(30.0), np.arange(30.0)), axis=-1).reshape(-1, 2),
])  # fmt: skip
def test_degenerate_points_are_one_component(points):
    answer = partition(points)
    assert answer.epsilon > 0
    assert answer.count == 1
    assert (answer.labels == 0).all()
    assert np.isfinite(answer.components[0].frame.axes).all()


@given(hnp.arrays(np.float64, st.tuples(st.integers(1, 60), st.sampled_from([2, 3])), elements=FINITE))
@settings(max_examples=200, deadline=None)
def test_all_finite_doubles_have_a_sound_partition(points):
    answer = partition(points)
    assert 0 < answer.epsilon < np.inf
    assert answer.labels.shape == (len(points),)
    least = least_component_size(len(points))
    assert all(one.size >= least for one in answer.components)
    for one in answer.components:
        assert np.isfinite(one.frame.origin).all()
        np.testing.assert_allclose(one.frame.axes @ one.frame.axes.T, np.eye(3), atol=1e-9)
        assert 0 <= one.frame.planarity <= 1


def test_points_are_left_as_they_were():
    points = point_set("nested", n=2000, outliers=0.05).points
    before = points.copy()
    partition(points)
    np.testing.assert_array_equal(points, before)


def test_the_room_is_entered_without_compiled_code():
    program = "import sys, core.cloud.points; sys.exit('numba' in sys.modules or 'scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0  # noqa: S603


def test_all_public_names_are_there():
    for name in core.cloud.__all__:
        assert callable(getattr(core.cloud, name))
    assert not hasattr(core.cloud, "no_such_name")
