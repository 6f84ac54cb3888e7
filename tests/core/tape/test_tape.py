import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.small_triangles import Smallness
from core.tape.tape import approximate_tape
from tests.core.shapes import arc, line
from tests.core.tape.drawings import eight
from tests.core.tape.samples import along, measured, thinning

SEEDS = st.integers(0, 2**32 - 1)
SIGMAS = st.floats(0.01, 0.06)


def tape_of(points, **smallness):
    _, scale, extent = measured(points)
    return approximate_tape(
        points, scale.balls, thinning(points), scale.sigma, extent, Smallness(**smallness)
    )


def holes(polygon):
    return sum(len(part.interiors) for part in polygon.geoms)


def share_inside(polygon, points):
    return shapely.contains_xy(polygon, *points.T).mean()


@settings(max_examples=15, deadline=None)
@given(SEEDS, SIGMAS)
def test_the_tape_of_a_ring_has_one_part_with_one_hole(seed, sigma):
    points = arc(1500, sigma, seed=seed)
    polygon = tape_of(points).polygon
    assert polygon.is_valid
    assert (len(polygon.geoms), holes(polygon)) == (1, 1)
    assert share_inside(polygon, points) >= 0.93


@settings(max_examples=15, deadline=None)
@given(SEEDS, SIGMAS)
def test_the_tape_of_an_open_arc_has_no_hole(seed, sigma):
    points = arc(1500, sigma, turn=4.0, seed=seed)
    polygon = tape_of(points).polygon
    assert polygon.is_valid
    assert (len(polygon.geoms), holes(polygon)) == (1, 0)
    assert share_inside(polygon, points) >= 0.93


def test_the_tape_of_an_eight_has_two_holes():
    polygon = tape_of(along(eight(), 1200, 0.02)).polygon
    assert (len(polygon.geoms), holes(polygon)) == (1, 2)


def test_separate_curves_have_separate_parts():
    points = np.concatenate([arc(600, 0.02), arc(600, 0.02, radius=2.0, seed=1)])
    polygon = tape_of(points).polygon
    assert (len(polygon.geoms), holes(polygon)) == (2, 2)


@pytest.mark.parametrize("sigma", [0.02, 0.05])
def test_the_tape_is_as_wide_as_the_noise(sigma):
    polygon = tape_of(arc(1000, sigma)).polygon
    width = polygon.area / (2.0 * np.pi)
    assert 3.0 * sigma < width < 8.0 * sigma
    # The curve runs inside it.
    assert polygon.covers(shapely.Point(0.0, 0.0).buffer(1.0, quad_segs=100).exterior)


def test_a_smaller_scale_makes_a_narrower_tape():
    points = arc(1000, 0.05)
    area = [tape_of(points, level=level).polygon.area for level in (1.0, 0.6, 0.3)]
    assert area[0] > area[1] > area[2]


def test_the_tape_holds_the_triangles_that_it_was_made_from():
    points = arc(600, 0.04)
    tape = tape_of(points)
    corners = tape.mesh.points[tape.mesh.triangles[tape.small.accepted]]
    assert shapely.covers(tape.polygon, shapely.points(corners.mean(axis=1))).mean() > 0.99
    np.testing.assert_array_equal(tape.mesh.points, points)


@pytest.mark.parametrize("degrees", [0.0, 90.0])
def test_collinear_points_have_no_tape(degrees):
    way = np.array((np.cos(np.radians(degrees)), np.sin(np.radians(degrees))))
    assert tape_of(np.linspace(-1.0, 1.0, 200)[:, None] * way) is None


def test_samples_with_hardly_any_noise_still_have_a_tape():
    points = line(400, 1e-7, 2.0)
    polygon = tape_of(points).polygon
    assert polygon.is_valid
    assert len(polygon.geoms) == 1
    assert share_inside(polygon, points) == 1.0
