import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.balls import optimal_balls, principal_direction
from tests.core.shapes import arc, in_space, line, rotation


def some(points, count=60):
    return points[:: max(1, len(points) // count)]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(("radius", "sigma"), [(1.0, 0.005), (1.0, 0.02), (40.0, 0.2)])
def test_the_radius_balances_noise_and_curvature(radius, sigma, seed):
    points = in_space(arc(5000, sigma, radius, seed=seed))
    balls = optimal_balls(points, some(points), 2.0 * radius)
    assert balls.found.all()
    # lambda_2 / n is least where curvature has added a third to the noise's variance.
    assert np.median(balls.radius) == pytest.approx(15**0.25 * np.sqrt(sigma * radius), rel=0.2)
    assert np.median(balls.sigma) == pytest.approx(sigma, rel=0.15)
    assert np.median(balls.density) == pytest.approx(5000 / (2 * np.pi * radius), rel=0.15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_on_a_straight_line_no_curvature_ends_the_search(dimension):
    points = in_space(line(3000, 0.01, dimension=dimension))
    balls = optimal_balls(points, some(points), 1.0, flat=dimension == 2)
    assert balls.found.all()
    assert np.median(balls.radius) > 0.3
    assert np.median(balls.sigma) == pytest.approx(0.01, rel=0.1)
    straight = np.abs(balls.direction[:, 0]) > np.cos(np.radians(5))
    assert np.mean(straight) > 0.9  # the smallest balls can be oblong by chance


def test_a_line_without_noise_has_none():
    points = in_space(line(500, 0.0))
    balls = optimal_balls(points, some(points), 1.0)
    assert balls.found.all()
    assert balls.sigma.max() < 1e-6
    np.testing.assert_allclose(np.abs(balls.direction[:, 0]), 1.0, atol=1e-9)


def test_noise_in_space_has_two_directions():
    rng = np.random.default_rng(0)
    u = rng.uniform(0, 6 * np.pi, 5000)
    points = np.column_stack((np.cos(u), np.sin(u), 0.2 * u)) + 0.02 * rng.normal(size=(5000, 3))
    balls = optimal_balls(points, some(points), 3.0, flat=False)
    assert np.median(balls.sigma) == pytest.approx(0.02, rel=0.15)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_a_ball_is_the_pca_of_the_samples_in_it(seed, flat):
    rng = np.random.default_rng(seed)
    points = in_space(arc(300, 0.03, seed=seed)) @ rotation(rng, 3).T
    seeds = some(points, 10)
    balls = optimal_balls(points, seeds, 2.0, flat)
    for k in np.flatnonzero(balls.found):
        inside = points[np.linalg.norm(points - seeds[k], axis=1) < balls.radius[k]]
        assert len(inside) == balls.samples[k]
        np.testing.assert_allclose(inside.mean(axis=0), balls.centre[k], atol=1e-12)
        values, vectors = np.linalg.eigh(np.cov(inside.T, bias=True))
        assert abs(vectors[:, 2] @ balls.direction[k]) == pytest.approx(1.0, abs=1e-9)
        across = values[:2].sum() / (1 if flat else 2)
        assert balls.variance[k] == pytest.approx(across * len(inside) / (len(inside) - 2), rel=1e-6)


def test_the_search_has_no_scale_of_its_own():
    points = in_space(arc(1000, 0.01))
    one = optimal_balls(points, some(points), 2.0)
    two = optimal_balls(points * 2.0**40, some(points) * 2.0**40, 2.0**41)
    np.testing.assert_allclose(two.radius, one.radius * 2.0**40, rtol=1e-12)
    np.testing.assert_allclose(two.sigma, one.sigma * 2.0**40, rtol=1e-12)


def test_a_filled_disc_is_no_curve():
    rng = np.random.default_rng(0)
    radius, angle = np.sqrt(rng.uniform(size=4000)), rng.uniform(0, 2 * np.pi, 4000)
    points = in_space(np.column_stack((radius * np.cos(angle), radius * np.sin(angle))))
    balls = optimal_balls(points, points[radius < 0.5][:100], 0.5)
    # By chance a few of the smallest balls are oblong; none of any size is.
    assert not np.any(balls.samples[balls.found] > 60)


def test_seeds_with_too_few_samples_have_no_ball():
    points = in_space(line(9, 0.01))
    balls = optimal_balls(points, points, 2.0)
    assert not balls.found.any()
    assert np.isnan(balls.radius).all()
    far = optimal_balls(in_space(line(200, 0.01)), np.array([[0.0, 50.0, 0.0]]), 2.0)
    assert not far.found.any()


@settings(max_examples=200, deadline=None)
@given(st.lists(st.integers(-1000, 1000), min_size=9, max_size=9), st.sampled_from([1e-9, 1.0, 1e9]))
def test_principal_direction_agrees_with_lapack(entries, scale):
    m = np.array(entries).reshape(3, 3) / 1000.0
    m = scale * (m @ m.T)
    size = np.abs(m).max()
    top, *v = principal_direction(m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2])
    assert np.linalg.norm(v) == pytest.approx(1.0, abs=1e-9)
    # Of two nearly equal eigenvalues a closed form has half of the digits.
    assert top == pytest.approx(np.linalg.eigvalsh(m)[-1], abs=1e-7 * size)
    assert np.linalg.norm(m @ v - top * np.array(v)) <= 1e-5 * size


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("along", "across"), [(3.0, 0.0), (3.0, 1.0), (1.0, 3.0), (0.0, 3.0)])
def test_principal_direction_of_a_body_of_revolution(axis, along, across):
    values = np.full(3, across)
    values[axis] = along
    top, *v = principal_direction(values[0], 0.0, 0.0, values[1], 0.0, values[2])
    assert top == pytest.approx(3.0)
    assert np.linalg.norm(v) == pytest.approx(1.0)
    # A needle's direction is its axis; a disc's is any direction across it.
    assert abs(v[axis]) == pytest.approx(1.0 if along > across else 0.0, abs=1e-9)


def test_principal_direction_of_a_sphere_is_some_unit_vector():
    top, *v = principal_direction(2.0, 0.0, 0.0, 2.0, 0.0, 2.0)
    assert top == pytest.approx(2.0)
    assert np.linalg.norm(v) == pytest.approx(1.0)
