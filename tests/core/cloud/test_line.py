import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.line import fit_line
from tests.core.shapes import line, rotation


def cloud(seed, dimension, oblong=0.3):
    """An elongated cloud somewhere, in some direction."""
    rng = np.random.default_rng(seed)
    spread = np.append(1.0, rng.uniform(0.01, oblong, dimension - 1))
    turn = rotation(rng, dimension)
    points = (rng.normal(size=(rng.integers(30, 80), dimension)) * spread) @ turn.T + 10 * rng.normal(
        size=dimension
    )
    return points, turn[:, 0]


@pytest.mark.parametrize("estimator", ["pca", "least_squares"])
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_points_on_a_line_give_that_line(estimator, seed, dimension):
    rng = np.random.default_rng(seed)
    direction = rotation(rng, dimension)[:, 0]
    along = rng.normal(size=20)
    points = np.outer(along, direction) + 5.0
    centre, found = fit_line(points, estimator)
    np.testing.assert_allclose(centre, 5.0 + along.mean() * direction, atol=1e-12)
    assert abs(found @ direction) == pytest.approx(1.0, abs=1e-12)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_least_squares_and_pca_find_the_same_line(seed, turn, dimension):
    points, _ = cloud(seed, dimension)
    centre, axis = fit_line(points)
    other_centre, other = fit_line(points, "least_squares", np.random.default_rng(turn))
    np.testing.assert_array_equal(centre, other_centre)
    assert np.linalg.norm(other) == pytest.approx(1.0)
    np.testing.assert_allclose(other * np.sign(other @ axis), axis, atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]))
def test_no_other_line_is_nearer_to_the_points(seed, dimension):
    points, _ = cloud(seed, dimension)
    centre, axis = fit_line(points)

    def squares(through, direction):
        offset = points - through
        return np.sum(offset**2) - np.sum((offset @ direction) ** 2)

    rng = np.random.default_rng(seed)
    least = squares(centre, axis)
    for size in (1e-3, 0.1, 1.0):
        nearby = axis + size * rng.normal(size=dimension)
        assert squares(centre, nearby / np.linalg.norm(nearby)) >= least
        assert squares(centre + size * rng.normal(size=dimension), axis) >= least


@pytest.mark.parametrize("estimator", ["pca", "least_squares"])
def test_noise_turns_the_line_by_what_its_standard_error_allows(estimator):
    points = line(2000, 0.05, length=2.0)
    _, direction = fit_line(points, estimator)
    error = 0.05 / (2.0 / np.sqrt(12)) / np.sqrt(2000)
    assert abs(direction[1] / direction[0]) < 4 * error


def test_a_first_frame_across_the_line_is_no_trap():
    first = np.random.default_rng(3).normal(size=2)
    across = np.array([first[1], -first[0]])
    points = np.outer(np.linspace(-1.0, 1.0, 11), across)
    _, direction = fit_line(points, "least_squares", np.random.default_rng(3))
    assert abs(direction @ across) / np.linalg.norm(across) == pytest.approx(1.0, abs=1e-12)


def test_the_same_seed_gives_the_same_bits():
    points, _ = cloud(7, 3)
    one = fit_line(points, "least_squares", np.random.default_rng(5))[1]
    two = fit_line(points, "least_squares", np.random.default_rng(5))[1]
    np.testing.assert_array_equal(one, two)
