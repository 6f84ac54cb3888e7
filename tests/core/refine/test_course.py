from dataclasses import replace

import numpy as np
import pytest

from core.refine.course import Rules, fit_course
from tests.core.shapes import in_space

FLAT = Rules(1, 4.0, None)


def bow(n, sigma, turn=3.0, seed=0):
    """Samples of an arc of radius 1, the stations of their feet on it, and their distances."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, turn, n)
    radius = 1.0 + sigma * rng.normal(size=n)
    points = in_space(radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle))))
    return points, angle, np.abs(radius - 1.0)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("sigma", [0.005, 0.05])
def test_samples_along_an_arc_give_the_arc(sigma, closed):
    turn = 2 * np.pi if closed else 3.0
    points, station, distance = bow(4000, sigma, turn)
    course = fit_course(points, station, distance, turn, closed, sigma, FLAT)
    radius = np.linalg.norm(course.vertices, axis=1)
    assert np.abs(radius - 1.0).max() < sigma / 2
    assert course.noise == pytest.approx(sigma, rel=0.05)
    assert len(course.error) == len(course.vertices)
    # The errors are those that the errors say.
    assert 0.2 < np.mean((radius - 1.0) ** 2) / np.mean(course.error**2) < 5.0


def test_an_open_course_runs_from_end_to_end_and_a_closed_one_around():
    points, station, distance = bow(4000, 0.01)
    course = fit_course(points, station, distance, 3.0, False, 0.01, FLAT)
    angle = np.arctan2(course.vertices[:, 1], course.vertices[:, 0])
    assert angle[0] == pytest.approx(0.0, abs=0.01)
    assert angle[-1] == pytest.approx(3.0, abs=0.01)
    points, station, distance = bow(4000, 0.01, 2 * np.pi)
    course = fit_course(points, station, distance, 2 * np.pi, True, 0.01, FLAT)
    gap = np.linalg.norm(course.vertices[0] - course.vertices[-1])
    assert gap == pytest.approx(2 * np.pi / len(course.vertices), rel=0.1)


@pytest.mark.parametrize("spacing", [0.03, 0.2, 10.0])
def test_the_spacing_of_the_vertices(spacing):
    points, station, distance = bow(2000, 0.01)
    course = fit_course(points, station, distance, 3.0, False, 0.01, Rules(1, 4.0, spacing))
    steps = np.linalg.norm(np.diff(course.vertices, axis=0), axis=1)
    assert steps.max() < 1.02 * spacing


def test_more_samples_err_less():
    errors = []
    for n in (500, 5000, 50_000):
        points, station, distance = bow(n, 0.05)
        errors.append(np.median(fit_course(points, station, distance, 3.0, False, 0.05, FLAT).error))
    assert errors[0] > errors[1] > errors[2]


@pytest.mark.parametrize(("final", "least"), [(False, 8.0), (True, 5.0)])
@pytest.mark.parametrize("sigma", [0.01, 0.05, 0.2])
def test_a_bandwidth_of_a_few_sigma_is_never_taken(sigma, final, least):
    # Below, wiggles reinforce themselves when samples are projected again.
    points, station, distance = bow(3000, sigma)
    course = fit_course(points, station, distance, 3.0, False, sigma, replace(FLAT, final=final))
    assert min(course.bandwidths.inside, course.bandwidths.ends) > 0.99 * least * sigma


def test_the_last_pass_follows_a_bend_that_wide_windows_cut():
    # So many samples allow windows of less than eight sigma.
    sigma, frequency, length, rng = 0.25, 1.5, 12.0, np.random.default_rng(0)
    x, noise = rng.uniform(0.0, length, 60_000), sigma * rng.normal(size=60_000)
    points = np.column_stack((x, np.sin(frequency * x) + noise, 0 * x))
    far = {}
    for final in (False, True):
        rules = replace(FLAT, final=final, spacing=0.05)
        course = fit_course(points, x, np.abs(noise), length, False, sigma, rules)
        x_fit, y_fit, _ = course.vertices.T
        # The samples' places are known: the correction for the blur of feet does not belong here.
        y_fit = y_fit / (1.0 - 0.5 * (frequency * sigma) ** 2)
        inside = (x_fit > 3.0) & (x_fit < 9.0)
        far[final] = np.sqrt(np.mean((y_fit - np.sin(frequency * x_fit))[inside] ** 2))
    assert far[True] < 0.6 * far[False]


@pytest.mark.parametrize("final", [False, True])
def test_standard_errors_are_known_of_the_last_pass_only(final):
    points, station, distance = bow(1000, 0.02)
    course = fit_course(points, station, distance, 3.0, False, 0.02, replace(FLAT, final=final))
    assert len(course.error) == len(course.vertices)
    assert np.all(np.isfinite(course.error) == final)
    assert np.isfinite(course.noise_error) == final


@pytest.mark.parametrize("n", [2, 3, 8, 20])
def test_few_samples_have_a_finite_course(n):
    points, station, distance = bow(n, 0.01)
    course = fit_course(points, station, distance, 3.0, False, 0.01, FLAT)
    assert np.isfinite(course.vertices).all()
    assert np.isfinite(course.error).all()
    assert np.isfinite(course.noise)


def test_half_of_each_of_twice_the_samples_gives_the_same_course():
    points, station, distance = bow(2000, 0.02)
    once = fit_course(points, station, distance, 3.0, False, 0.02, FLAT)
    halves = fit_course(
        np.tile(points, (2, 1)), np.tile(station, 2), np.tile(distance, 2), 3.0, False, 0.02, FLAT,
        weight=np.full(4000, 0.5),
    )  # fmt: skip
    assert halves.noise == pytest.approx(once.noise, rel=1e-9)
    np.testing.assert_allclose(halves.vertices, once.vertices, atol=1e-9)


def test_samples_that_are_mostly_another_curves_hardly_count():
    points, station, distance = bow(3000, 0.01)
    once = fit_course(points, station, distance, 3.0, False, 0.01, FLAT)
    shifted = points * 1.03  # as samples of a neighbour would be
    course = fit_course(
        np.concatenate((points, shifted)), np.tile(station, 2), np.append(distance, distance + 0.03), 3.0,
        False, 0.01, FLAT, weight=np.append(np.ones(3000), np.full(3000, 0.005)),
    )  # fmt: skip
    radius = np.linalg.norm(course.vertices, axis=1).mean() - np.linalg.norm(once.vertices, axis=1).mean()
    assert radius == pytest.approx(0.03 * 0.005, abs=5e-5)
