"""Round clumps are told from short curves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.blobs import is_blob, is_small
from core.refine.polyline import Polyline
from tests.core.shapes import in_space


def _clump(seed, count, width, axes=2):
    points = width * np.random.default_rng(seed).normal(size=(count, axes))
    return points if axes == 3 else in_space(points)


def _stick(length, count=15):
    return Polyline(
        in_space(np.column_stack((np.linspace(-0.5, 0.5, count) * length, np.zeros(count)))), False
    )


def _ring(radius):
    angle = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), True)


def _samples(line, count, seed=0):
    """Samples of a curve with noise of standard deviation one."""
    rng = np.random.default_rng(seed)
    points = line.at(rng.uniform(0.0, line.length, count))
    points[:, :2] += rng.normal(size=(count, 2))
    return points


@pytest.mark.parametrize("width", [1.5, 2.5, 4.0])
@pytest.mark.parametrize("axes", [2, 3])
def test_a_course_through_a_round_clump_is_none(width, axes):
    for seed in range(10):
        points = _clump(seed, 40, width, axes)
        # The likeliest course: along the longest axis, as far as most samples lie.
        axis = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        line = Polyline(points.mean(axis=0) + np.linspace(-1.5, 1.5, 12)[:, None] * width * axis, False)
        assert is_blob(points, line, 1.0, axes == 2)


@pytest.mark.parametrize("line", [_stick(16.0), _ring(4.0), _ring(6.0)], ids=["stick", "ring", "wide ring"])
@pytest.mark.parametrize("strays", [0, 10])
def test_short_curves_are_no_clumps(line, strays):
    for seed in range(10):
        points = _samples(line, 80, seed)
        far = in_space(np.random.default_rng(seed).uniform(-15.0, 15.0, (strays, 2)))
        assert not is_blob(np.concatenate((points, far)), line, 1.0, True)


def test_long_curves_are_not_asked():
    line = _stick(100.0)
    assert not is_small(line, 1.0)
    assert not is_blob(_clump(0, 40, 2.0), line, 1.0, True)


def test_a_curve_without_samples_is_no_better_than_a_clump():
    assert is_blob(_clump(0, 40, 1.0) + 100.0, _stick(10.0), 1.0, True)


def test_samples_of_a_passing_curve_say_nothing():
    passing = Polyline(_stick(200.0).vertices + np.array([0.0, 10.0, 0.0]), False)
    points = np.concatenate((_clump(0, 40, 2.0), _samples(passing, 400)))
    assert is_blob(points, _stick(6.0), 1.0, True, [passing])


def test_a_course_along_a_passing_curve_is_left_to_others():
    passing = _stick(200.0)
    assert not is_blob(_samples(passing, 400), _stick(10.0), 1.0, True, [passing])


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.floats(1e-3, 1e3), st.floats(0.0, 6.28))
def test_units_and_directions_do_not_matter(seed, unit, angle):
    c, s = np.cos(angle), np.sin(angle)
    turn = unit * np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    for points, line in ((_clump(seed, 40, 2.0), _stick(6.0)), (_samples(_ring(5.0), 60, seed), _ring(5.0))):
        other = Polyline(line.vertices @ turn, line.closed)
        assert is_blob(points @ turn, other, unit, True) == is_blob(points, line, 1.0, True)
