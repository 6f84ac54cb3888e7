"""Clumps at the ends of a straight course with noise of standard deviation one."""

import numpy as np
import pytest

from core.refine.clumped_ends import clumped

LENGTH, CUT = 200.0, 4.0


def _course(rng, normals=1, density=5.0, width=1.0):
    """Samples along the x-axis."""
    points = np.zeros((round(density * LENGTH), 3))
    points[:, 0] = rng.uniform(0.0, LENGTH, len(points))
    points[:, 1 : 1 + normals] = width * rng.normal(size=(len(points), normals))
    return points


def _clump(rng, x, width, normals=1, count=40):
    points = np.zeros((count, 3))
    points[:, : 1 + normals] = width * rng.normal(size=(count, 1 + normals))
    return points + np.array([x, 0.0, 0.0])


def _found(points, low=0.0, high=LENGTH, normals=1):
    """Which samples within the cut of the course from ``low`` to ``high`` are in clumps."""
    distance = np.linalg.norm(points[:, 1:], axis=1)
    near = (distance < CUT) & (points[:, 0] >= low) & (points[:, 0] <= high)
    out = np.zeros(len(points), bool)
    out[near] = clumped(points[near], points[near, 0], distance[near], (low, high), 1.0, CUT, normals)
    return out


@pytest.mark.parametrize("normals", [1, 2])
@pytest.mark.parametrize("strays", [0, 60])
def test_a_course_without_clumps_keeps_its_samples(normals, strays):
    for seed in range(30):
        rng = np.random.default_rng(seed)
        far = np.zeros((strays, 3))
        far[:, :2] = rng.uniform([0.0, -CUT], [LENGTH, CUT], (strays, 2))
        assert not _found(np.concatenate((_course(rng, normals), far)), normals=normals).any()


@pytest.mark.parametrize("normals", [1, 2])
@pytest.mark.parametrize("last", [False, True])
@pytest.mark.parametrize("width", [2.5, 4.0])
def test_a_clump_that_a_course_runs_into_is_not_its(normals, last, width):
    left_out = 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        own = _course(rng, normals)
        x = LENGTH + 3.0 * width if last else -3.0 * width
        clump = _clump(rng, x, width, normals, 100)
        low, high = (0.0, LENGTH + 5.0 * width) if last else (-5.0 * width, LENGTH)
        out = _found(np.concatenate((own, clump)), low, high, normals)
        inner = np.abs(own[:, 0] - (LENGTH if last else 0.0)) > 8.0
        assert not out[: len(own)][inner].any()
        core = np.linalg.norm(clump - np.array([x, 0.0, 0.0]), axis=1) < width
        left_out += np.mean(out[len(own) :][core]) > 0.9
    assert left_out >= 8


def test_a_course_that_goes_on_through_a_clump_keeps_its_samples():
    for seed in range(10):
        rng = np.random.default_rng(seed)
        points = np.concatenate((_course(rng, density=10.0), _clump(rng, 12.0, 4.0, count=30)))
        assert not _found(points).any()


def test_samples_that_a_course_has_missed_are_no_clump():
    rng = np.random.default_rng(0)
    points = _course(rng)
    points[points[:, 0] < 20.0, 1] += 2.0
    assert not _found(points).any()


def test_a_course_noisy_all_along_has_no_clumps_once_its_noise_is_known():
    points = _course(np.random.default_rng(1), width=3.0) / 3.0
    assert not _found(points, high=LENGTH / 3.0).any()


def test_few_samples_show_nothing():
    assert not clumped(np.zeros((3, 3)), np.zeros(3), np.full(3, 3.9), (0.0, 1.0), 1.0, CUT, 1).any()
