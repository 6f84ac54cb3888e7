import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.march.strip import N_AHEAD, N_ALL, N_OWNED, SIGMA
from tests.core.march.walks import Field, at
from tests.core.shapes import in_space, line, rotation

SEEDS = st.integers(0, 2**32 - 1)


def parabola(n, bow, noise=0.0, seed=0, reach=1.0):
    """Samples of o = bow t^2 / 2 about its top, in the xy plane."""
    rng = np.random.default_rng(seed)
    t = rng.uniform(-reach, reach, n)
    points = np.column_stack((t, 0.5 * bow * t * t, np.zeros(n)))
    points[:, 1] += noise * rng.normal(size=n)
    return points


def turned(seed, points):
    """Points and the frame (rows) in which they were given, turned at random in space."""
    q = rotation(np.random.default_rng(seed), 3)
    return points @ q.T, q.T


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.floats(-1.0, 1.0), st.floats(-0.05, 0.05), st.floats(-0.1, 0.1))
def test_a_parabola_is_recovered_from_a_rough_guess_in_space(seed, bow, shift, tilt):
    points, (x, y, _) = turned(seed, parabola(300, bow))
    guess = at(shift * y, np.cos(tilt) * x + np.sin(tilt) * y)
    field = Field(points)
    place = guess
    for _ in range(3):  # each fit corrects the frame of the next
        good, fit = field.fit(place, 0.5, 0.5)
        assert good
        place = fit[:9].copy()
    # The fit's centre is on the curve, its direction the tangent there, its bend the curvature.
    t = fit[:3] @ x
    tangent = (x + bow * t * y) / np.sqrt(1 + (bow * t) ** 2)
    np.testing.assert_allclose(fit[:3], t * x + 0.5 * bow * t * t * y, atol=5e-3)
    assert fit[3:6] @ tangent > np.cos(0.02)
    assert np.linalg.norm(fit[3:6]) == pytest.approx(1.0)
    assert fit[6:9] @ fit[3:6] == pytest.approx(0.0, abs=1e-9)
    curvature = abs(bow) / (1 + (bow * t) ** 2) ** 1.5
    assert np.linalg.norm(fit[6:9]) == pytest.approx(curvature, abs=0.05 + 0.1 * curvature)
    assert fit[SIGMA] < 5e-3


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.floats(-2.0, 2.0))
def test_in_its_own_frame_a_parabola_is_exact(seed, bow):
    points, (x, y, _) = turned(seed, parabola(100, bow))
    good, fit = Field(points).fit(at([0, 0, 0], x), 0.5, 1.5, normals=2)
    assert good
    np.testing.assert_allclose(fit[:3], 0.0, atol=1e-10)
    np.testing.assert_allclose(fit[3:6], x, atol=1e-9)
    np.testing.assert_allclose(fit[6:9], bow * y, atol=1e-8)
    assert fit[SIGMA] < 1e-6


@pytest.mark.parametrize(("dimension", "normals"), [(2, 1), (3, 2)])
@pytest.mark.parametrize("sigma", [0.005, 0.05])
def test_the_noise_is_estimated_per_direction(dimension, normals, sigma):
    points = in_space(line(20_000, sigma, length=4.0, dimension=dimension))
    _, fit = Field(points).fit(at([0.1, 0, 0], [1, 0, 0]), 1.0, 3.0 * sigma, normals=normals)
    assert fit[SIGMA] == pytest.approx(sigma, rel=0.05)
    assert fit[N_ALL] == pytest.approx(20_000 / 4.0 * 2.0, rel=0.05)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.floats(0.1, 1.0), st.floats(0.05, 0.5), st.floats(-0.5, 0.5))
def test_the_strip_holds_what_lies_along_its_bent_axis(seed, r, half, bow):
    rng = np.random.default_rng(seed)
    q = rotation(rng, 3).T
    points = rng.uniform(-1.5, 1.5, size=(400, 3))
    centre = rng.normal(scale=0.3, size=3)
    found, local = Field(points, 0.3).gather(at(centre, q[0], bow * q[1]), r, half)
    t = (points - centre) @ q[0]
    axis = centre + t[:, None] * q[0] + 0.5 * t[:, None] ** 2 * bow * q[1]
    offset = np.linalg.norm(points - axis, axis=1)
    np.testing.assert_array_equal(np.sort(found), np.flatnonzero((np.abs(t) < r) & (offset < half)))
    np.testing.assert_allclose(local[:, 0], t[found], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(local[:, 1:], axis=1), offset[found], atol=1e-12)


def test_a_branch_beside_the_strip_does_not_matter():
    own = parabola(500, 0.4, 0.02)
    other = parabola(500, 0.4, 0.02, seed=1)
    other[:, 1] += 0.3
    place = at([0, 0, 0], [1, 0, 0])
    _, alone = Field(own).fit(place, 0.5, 0.1)
    _, beside = Field(np.concatenate((own, other))).fit(place, 0.5, 0.1)
    np.testing.assert_allclose(beside, alone, rtol=1e-9, atol=1e-12)


def test_a_branch_across_the_strip_turns_it_little():
    own = in_space(line(2000, 0.02, length=2.0))
    other = in_space(line(2000, 0.02, length=2.0, seed=1))[:, [1, 0, 2]]
    _, fit = Field(np.concatenate((own, other))).fit(at([0, 0, 0], [1, 0, 0]), 0.5, 0.06)
    assert fit[3] > np.cos(np.radians(2))
    assert abs(fit[1]) < 0.02


def test_too_few_samples_make_no_fit():
    few = parabola(5, 0.0)
    assert not Field(few).fit(at([0, 0, 0], [1, 0, 0]), 1.0, 0.1)[0]
    assert not Field(parabola(100, 0.0)).fit(at([0, 9, 0], [1, 0, 0]), 1.0, 0.1)[0]
    # Samples at one place, or two, show no direction and no curvature.
    for pile in (np.zeros((50, 3)), np.repeat([[-0.1, 0, 0], [0.1, 0, 0]], 25, axis=0)):
        assert not Field(pile).fit(at([0, 0, 0], [1, 0, 0]), 1.0, 0.1)[0]


def test_owned_samples_are_those_within_reach():
    points = parabola(400, 0.3)
    field = Field(points)
    field.own(at([0, 0, 0], [1, 0, 0], [0, 0.3, 0]), 0.2, 0.5, 0.1, me=3, node=7)
    t = points[:, 0]
    np.testing.assert_array_equal(field.read("owner") == 3, np.abs(t) <= 0.2)
    np.testing.assert_array_equal(field.read("node") == 7, np.abs(t) <= 0.2)
    np.testing.assert_array_equal(field.read("uses"), np.abs(t) < 0.5)
    ways = field.read("way")[np.abs(t) <= 0.2]
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1.0, atol=1e-6)
    # The direction of the pass turns with the curve.
    np.testing.assert_allclose(ways[:, 1] / ways[:, 0], 0.3 * t[np.abs(t) <= 0.2], atol=1e-5)


def test_a_pass_in_the_same_direction_is_known_again_and_one_across_is_not():
    cross = np.concatenate((line(500, 0.01, dimension=3), line(500, 0.01, seed=1, dimension=3)[:, [1, 0, 2]]))
    field = Field(cross)
    field.own(at([0, 0, 0], [1, 0, 0]), 0.5, 0.5, 0.05, me=0)
    for direction, owned in (([1, 0, 0], True), ([-1, 0, 0], True), ([0, 1, 0], False)):
        _, fit = field.fit(at([0, 0, 0], direction), 0.3, 0.05, me=1)
        assert fit[N_AHEAD] > 50
        # Of the strip across only the few samples at the crossing itself were passed, and not this way.
        assert (fit[N_OWNED] > 0.7 * fit[N_AHEAD]) == owned
        _, trail = field.fit(at([0, 0, 0], direction), 0.3, 0.05, me=0)
        assert trail[N_OWNED] == 0  # what it has just passed itself is no stretch met again


def test_used_up_samples_take_no_part():
    field = Field(parabola(300, 0.0, 0.01))
    place = at([0, 0, 0], [1, 0, 0])
    _, fresh = field.fit(place, 0.5, 0.1, most_uses=2)
    field.own(place, 0.5, 0.5, 0.1)
    _, once = field.fit(place, 0.5, 0.1, most_uses=2)
    field.own(place, 0.5, 0.5, 0.1)
    good, twice = field.fit(place, 0.5, 0.1, most_uses=2)
    assert fresh[N_ALL] == once[N_ALL] > 100
    assert twice[N_ALL] == 0
    assert not good
    assert field.fit(place, 0.5, 0.1, most_uses=0)[0]


def test_the_share_of_passed_samples():
    field = Field(parabola(400, 0.0))
    place = at([0, 0, 0], [1, 0, 0])
    assert field.passed(place, 0.5, 0.1) == 0.0
    field.own(place, 0.25, 0.25, 0.1)
    assert field.passed(place, 0.2, 0.1) == 1.0
    assert field.passed(place, 0.5, 0.1) == pytest.approx(0.5, abs=0.1)
