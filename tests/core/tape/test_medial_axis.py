import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from core.tape.medial_axis import (
    LEAST_SAMPLES,
    MOST_SAMPLES,
    SHAKE,
    SPACING,
    mean_width,
    medial_axis,
    resampled_border,
)

HALF = 0.5
CENTRE = shapely.Point(0.0, 0.0)
RECTANGLE = shapely.box(-3.0, -HALF, 3.0, HALF)
ANNULUS = CENTRE.buffer(2.0 + HALF, quad_segs=64) - CENTRE.buffer(2.0 - HALF, quad_segs=64)
ROD = shapely.LineString([(-3, 0), (3, 0)]).buffer(HALF, quad_segs=64)
TEE = shapely.MultiLineString([[(-5, 0), (5, 0)], [(0, 0), (0, -5)]]).buffer(HALF)
SHAPES = {"rectangle": RECTANGLE, "annulus": ANNULUS, "rod": ROD, "T": TEE}


def axis_of(shape, share=SPACING):
    width = mean_width(shape)
    return medial_axis(shape, resampled_border(shape, share * width), 0.5 * width)


def kept(axis):
    """Places and radii of the axis without hair."""
    on = np.unique(axis.edges)
    return axis.places[on], axis.radius[on]


def degrees(axis):
    return np.bincount(axis.edges.ravel(), minlength=len(axis.places))


def border_of(shape):
    return shapely.union_all(shapely.get_rings(shapely.get_parts(shape)))


def blob(seed):
    """A star-shaped polygon, with a hole or without."""
    rng = np.random.default_rng(seed)
    u = 2.0 * np.pi * np.arange(60) / 60
    radius = 1.0 + 0.3 * np.sin(rng.integers(2, 6) * u + rng.uniform(0.0, 6.0))
    outer = radius[:, None] * np.column_stack((np.cos(u), np.sin(u)))
    return shapely.Polygon(outer, [0.4 * outer] if rng.integers(2) else [])


@pytest.mark.parametrize("name", SHAPES)
def test_discs_touch_the_border_and_hold_none_of_its_samples(name):
    axis = axis_of(SHAPES[name])
    places, radius = kept(axis)
    shaken = 2.0 * SHAKE * HALF
    nearest, _ = cKDTree(axis.border.points).query(places, 3)
    np.testing.assert_allclose(nearest, np.tile(radius[:, None], 3), atol=shaken)


@pytest.mark.parametrize("name", SHAPES)
def test_radii_are_distances_from_the_border(name):
    shape = SHAPES[name]
    places, radius = kept(axis_of(shape, 0.1))
    assert shape.covers(shapely.multipoints(places))
    np.testing.assert_allclose(shapely.distance(shapely.points(places), border_of(shape)), radius, rtol=0.1)


def test_a_rectangle_has_its_middle_line():
    places, radius = kept(axis_of(RECTANGLE, 0.2))
    np.testing.assert_allclose(places[:, 1], 0.0, atol=0.05 * HALF)
    np.testing.assert_allclose(radius, HALF, rtol=0.05)
    # The corners' bisectors, which are hair, meet there.
    np.testing.assert_allclose(
        (places[:, 0].min(), places[:, 0].max()), (HALF - 3, 3 - HALF), atol=0.3 * HALF
    )


def test_an_annulus_has_one_loop():
    axis = axis_of(ANNULUS, 0.1)
    places, radius = kept(axis)
    np.testing.assert_allclose(np.hypot(*places.T), 2.0, rtol=0.02)
    np.testing.assert_allclose(radius, HALF, rtol=0.05)
    assert set(degrees(axis)) <= {0, 2}
    assert len(axis.edges) == len(places)


@pytest.mark.parametrize("count", [50, 200, 1000])
def test_the_hair_of_a_wiggly_border_is_told_from_its_ends(count):
    rng = np.random.default_rng(count)
    x = np.linspace(-3.0, 3.0, count)
    sides = HALF * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, (2, count)))
    ring = np.concatenate([np.column_stack((x, sides[0])), np.column_stack((x, -sides[1]))[::-1]])
    axis = axis_of(shapely.Polygon(ring))
    assert not axis.kept.all()
    tips = axis.places[degrees(axis) == 1]
    assert tips[:, 0].min() == pytest.approx(HALF - 3.0, abs=HALF)
    assert tips[:, 0].max() == pytest.approx(3.0 - HALF, abs=HALF)
    assert np.abs(kept(axis)[0][:, 1]).max() < 0.5 * HALF


def test_a_round_cap_ends_at_its_centre():
    places, _ = kept(axis_of(ROD, 0.1))
    np.testing.assert_allclose((places[:, 0].min(), places[:, 0].max()), (-3.0, 3.0), atol=0.3 * HALF)


def test_arms_of_a_t_meet_in_one_fork():
    count = np.bincount(degrees(axis_of(TEE)))
    assert count[3] - count[1] == -2  # a tree with three ends has one fork more than that


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, SPACING))
def test_the_axis_has_a_loop_for_each_hole(seed, share):
    shape = blob(seed)
    axis = axis_of(shape, share)
    assert axis.raw.shape == (len(axis.kept), 2)
    assert axis.raw.max() < len(axis.places) == len(axis.radius)
    on, ends = np.unique(axis.edges, return_inverse=True)
    links = coo_array((np.ones(len(axis.edges)), ends.reshape(-1, 2).T), shape=(len(on), len(on)))
    pieces = connected_components(links, directed=False)[0]
    assert len(axis.edges) - len(on) + pieces == len(shape.interiors)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.005, 3.0))
def test_border_samples_are_equidistant_and_on_their_ring(seed, spacing):
    shape = blob(seed)
    border = resampled_border(shape, spacing)
    rings = shapely.get_rings(shape)
    assert set(border.ring.tolist()) == set(range(len(rings)))
    for k, ring in enumerate(rings):
        points = border.points[border.ring == k]
        way = shapely.line_locate_point(ring, shapely.points(points))
        assert shapely.distance(ring, shapely.points(points)).max() < 1e-12
        steps = np.diff(np.append(way, way[0] + ring.length)) % ring.length
        np.testing.assert_allclose(steps, ring.length / len(points), rtol=1e-6)
        assert len(points) >= LEAST_SAMPLES
        assert steps.max() <= spacing * (1.0 + 1e-6) or len(points) == LEAST_SAMPLES


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.005, 1.0))
def test_stations_grow_along_a_ring_and_chords_are_no_longer_than_arcs(seed, spacing):
    shape = blob(seed)
    border = resampled_border(shape, spacing)
    for k, ring in enumerate(shapely.get_rings(shape)):
        station = border.station[border.ring == k]
        assert station[0] == 0.0
        assert np.all(np.diff(station) > 0.0)
        assert station[-1] < border.lengths[k] <= ring.length * (1.0 + 1e-12)


def test_long_chords_pass_by_wiggles():
    x = np.linspace(0.0, 10.0, 2001)
    ring = np.concatenate([np.column_stack((x, 1.0 + 0.05 * np.sin(100.0 * x))), [(10, 0), (0, 0)]])
    shape = shapely.Polygon(ring)
    fine, coarse = (resampled_border(shape, 0.01, chord).lengths[0] for chord in (0.01, 0.5))
    assert fine == pytest.approx(shape.length, rel=0.02)
    assert coarse == pytest.approx(22.0, rel=0.05)


def test_samples_are_never_too_many():
    assert len(resampled_border(ANNULUS, 1e-9).points) <= MOST_SAMPLES + 2


def test_the_mean_width_is_twice_the_area_over_the_border():
    assert mean_width(ANNULUS) == pytest.approx(2.0 * HALF, rel=0.03)
    assert mean_width(RECTANGLE) == pytest.approx(2.0 * 6.0 / 14.0, rel=0.03)


def test_a_rough_border_is_as_wide_as_a_smooth_one():
    rng = np.random.default_rng(0)
    x = np.linspace(0.0, 10.0, 3000)
    top, bottom = 1.0 + 0.05 * rng.uniform(-1, 1, (2, len(x)))
    ring = np.concatenate([np.column_stack((x, top)), np.column_stack((x, -bottom))[::-1]])
    shape = shapely.Polygon(ring)
    assert 2.0 * shape.area / shape.length < 0.5  # most of its border are wiggles
    assert mean_width(shape) == pytest.approx(40.0 / 24.0, rel=0.15)


@pytest.mark.parametrize("exponent", [-30, 20])
def test_the_unit_of_length_changes_nothing(exponent):
    factor = 2.0**exponent
    one, other = axis_of(TEE), axis_of(shapely.transform(TEE, lambda xy: factor * xy))
    np.testing.assert_array_equal(one.raw, other.raw)
    np.testing.assert_array_equal(one.kept, other.kept)
    np.testing.assert_allclose(factor * kept(one)[0], kept(other)[0], atol=1e-9 * factor)
