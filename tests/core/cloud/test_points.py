import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from core.cloud.points import Normalisation, as_points, bounds, centred
from core.errors import InvalidPoints
from tests.core.cloud import brute

FINITE = st.floats(allow_nan=False, allow_infinity=False)
CLOUDS = hnp.arrays(np.float64, st.tuples(st.integers(1, 30), st.sampled_from([2, 3])), elements=FINITE)
MODERATE = hnp.arrays(
    np.float64, st.tuples(st.integers(1, 30), st.sampled_from([2, 3])), elements=st.floats(-1e3, 1e3)
)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16, np.int64, np.uint8])
def test_real_numbers_of_any_type_are_taken(kind):
    points = as_points(np.arange(6).reshape(3, 2).astype(kind))
    assert points.dtype == np.float64
    assert points.flags.c_contiguous
    np.testing.assert_array_equal(points, [[0, 1], [2, 3], [4, 5]])


def test_lists_are_taken():
    np.testing.assert_array_equal(as_points([[1, 2.5, 3]]), [[1.0, 2.5, 3.0]])


def test_a_sound_array_is_not_copied():
    points = np.zeros((10, 3))
    assert as_points(points) is points


@pytest.mark.parametrize(
    "view", [np.zeros((3, 10)).T, np.zeros((10, 6))[:, ::2], np.asfortranarray(np.ones((5, 2)))]
)
def test_views_become_contiguous(view):
    points = as_points(view)
    assert points.flags.c_contiguous
    np.testing.assert_array_equal(points, view)


@pytest.mark.parametrize(
    ("bad", "kind"),
    [
        ([], "wrong-shape"),
        (5.0, "wrong-shape"),
        ([1.0, 2.0], "wrong-shape"),
        ([[1.0], [2.0]], "wrong-shape"),
        ([[1.0, 2.0, 3.0, 4.0]], "wrong-shape"),
        ([[[1.0, 2.0]]], "wrong-shape"),
        ([[1.0, 2.0], [1.0, 2.0, 3.0]], "wrong-shape"),
        (np.zeros((0, 2)), "too-few-points"),
        ([[True, False]], "wrong-type"),
        ([["1", "2"]], "wrong-type"),
        ([[1j, 2.0]], "wrong-type"),
        ([[None, 1.0]], "wrong-type"),
        (None, "wrong-type"),
        ([[10**400, 1.0]], "wrong-type"),
        (np.array([[1, 2]], dtype="datetime64[s]"), "wrong-type"),
    ],
)
def test_what_is_no_point_set_is_refused(bad, kind):
    with pytest.raises(InvalidPoints) as caught:
        as_points(bad)
    assert caught.value.kind == kind
    assert caught.value.loc == ("points",)


@given(CLOUDS, st.data())
@settings(deadline=None)
def test_the_first_value_that_is_not_finite_is_named(points, data):
    flat = points.ravel()
    places = data.draw(st.lists(st.integers(0, flat.size - 1), min_size=1, max_size=4))
    flat[places] = data.draw(st.sampled_from([np.nan, np.inf, -np.inf]))
    with pytest.raises(InvalidPoints) as caught:
        as_points(points)
    assert caught.value.loc == ("points", *divmod(min(places), points.shape[1]))
    assert caught.value.kind == "not-finite"


def test_numbers_beyond_the_range_of_doubles_are_not_finite():
    huge = np.array([[1, 2], [3, 4]], dtype=np.longdouble)
    huge[1, 0] = np.finfo(np.longdouble).max
    with pytest.raises(InvalidPoints) as caught:
        as_points(huge)
    assert caught.value.loc == ("points", 1, 0)


@given(CLOUDS)
@settings(deadline=None)
def test_normalising_is_undone_for_all_doubles(points):
    unit, way = centred(points)
    low, high = bounds(points)
    assert np.isfinite(unit).all()
    assert way.scale > 0
    # Two roundings at the size of the extent, and one of the sum; subnormal numbers have steps of their own.
    steps = 8 * np.finfo(np.float64).eps
    tolerance = steps * np.max(high / 2 - low / 2) + steps * np.abs(points) + 1e-322
    assert (np.abs(way.restore(unit) / 2 - points / 2) <= tolerance).all()


@given(MODERATE)
@settings(deadline=None)
def test_normalised_points_have_mean_zero_and_unit_spread(points):
    unit, way = centred(points)
    if np.ptp(points, axis=0).max() < 1e-9:
        return
    np.testing.assert_allclose(unit.mean(axis=0), 0.0, atol=1e-6)
    assert np.mean(unit**2) == pytest.approx(1.0)
    np.testing.assert_allclose(way.apply(points), unit)


def test_an_offset_of_ten_million_extents_costs_only_the_rounding_of_the_input():
    generator = np.random.default_rng(4)
    points = generator.normal(size=(500, 3))
    offset = 1e7 * np.array([1.0, -2.0, 0.5])
    moved = points + offset
    rounded = moved - offset
    unit, _ = centred(rounded)
    unit_of_moved, way = centred(moved)
    # The centre itself is rounded to the grid of the moved coordinates.
    np.testing.assert_allclose(unit_of_moved - unit_of_moved.mean(axis=0), unit, atol=1e-14)
    np.testing.assert_array_equal(way.restore(unit_of_moved), moved)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_scale_is_the_same_in_every_frame(dimension):
    generator = np.random.default_rng(5)
    points = generator.normal(size=(200, dimension)) * ([5.0, 1.0, 0.1][:dimension])
    turned = points @ brute.rotation(generator, dimension).T + 3.0
    assert centred(turned)[1].scale == pytest.approx(centred(points)[1].scale, rel=1e-14)
    assert centred(7 * points)[1].scale == pytest.approx(7 * centred(points)[1].scale, rel=1e-14)


def test_coincident_points_have_scale_one():
    unit, way = centred(np.full((5, 2), 1e9))
    assert way.scale == 1.0
    np.testing.assert_array_equal(unit, 0.0)


def test_a_normalisation_is_a_similarity():
    way = Normalisation(np.array([1.0, 2.0]), 4.0)
    np.testing.assert_array_equal(way.apply(np.array([[5.0, 2.0]])), [[1.0, 0.0]])
    np.testing.assert_array_equal(way.restore(np.array([[1.0, 0.0]])), [[5.0, 2.0]])
