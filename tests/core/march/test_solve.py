import numpy as np
import pytest

from core.march.solve import solve_march
from core.truth import point_set
from tests.core.march.walks import scene
from tests.core.shapes import arc


@pytest.mark.parametrize("name", ["circle", "ellipse", "s_shape", "wave", "nested", "star"])
def test_the_curves_of_a_family(name):
    sample = point_set(name, seed=4)
    marched = solve_march(*scene(sample.points))
    assert sorted(c.closed for c in marched.curves) == sorted(c.closed for c in sample.curves)
    length = sum(c.length for c in marched.curves)
    assert length == pytest.approx(sum(c.length for c in sample.curves), rel=0.1)


def test_the_description_length_is_that_of_the_best_hypothesis():
    points = arc(1000, 0.02)
    free = solve_march(*scene(points))
    short = solve_march(*scene(points, radius=0.06))
    assert np.isfinite(free.nats)
    assert free.nats < short.nats + 10.0


def test_the_fragments_are_those_of_the_curves():
    marched = solve_march(*scene(arc(1000, 0.02)))
    vertices = {tuple(v) for c in marched.curves for v in c.vertices.tolist()}
    centres = {tuple(v) for f in marched.fragments for v in f.centres.tolist()}
    assert len(centres & vertices) > 0.8 * len(centres)


def test_a_given_radius_is_not_varied():
    sample, pace = scene(arc(1000, 0.02), radius=0.3)
    one, two = solve_march(sample, pace), solve_march(sample, pace)
    np.testing.assert_array_equal(one.curves[0].vertices, two.curves[0].vertices)
    assert {round(float(r), 12) for f in one.fragments for r in f.nodes[:, -2]} == {0.3}


@pytest.mark.parametrize("seed", range(3))
def test_scattered_points_come_to_an_end(seed):
    points = np.random.default_rng(seed).normal(size=(400, 2))
    sample, pace = scene(points)
    if pace.scale is not None:
        marched = solve_march(sample, pace)
        assert all(np.isfinite(c.vertices).all() for c in marched.curves)


@pytest.mark.parametrize("seed", range(3))
def test_outliers_line_up_to_no_curves(seed):
    sample = point_set("spiral", n=1000, sigma=0.01, outliers=0.2, seed=seed)
    assert len(solve_march(*scene(sample.points)).curves) == 1
