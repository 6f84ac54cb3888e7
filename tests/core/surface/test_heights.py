import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.borders import Borders
from core.surface.heights import Places, heights_of
from core.surface.linework import Grid, linework_of
from core.surface.overlay import slab_ends

UNIT = 10_000  # grid units


def discs(*radii):
    """Concentric discs, one a level, and their slabs at heights 0, 1, 2 ...; None for an empty level."""
    turn = 2.0 * np.pi * np.arange(720) / 720
    circle = np.column_stack((np.cos(turn), np.sin(turn)))
    loops = [np.rint(UNIT * r * circle).astype(np.int64) for r in radii if r]
    lines = linework_of(loops, [k for k, r in enumerate(radii) if r])
    return lines, slab_ends(lines, np.arange(float(len(radii))))


def height_at(radius, radii, slab, reached, passes=None):
    lines, slabs = discs(*radii)
    xy = UNIT * np.array([(r, 0.003) for r in np.atleast_1d(radius)])
    count = len(xy)
    number = [each.levels[0] for each in slabs].index(slab)
    places = Places(
        xy,
        np.full(count, number),
        np.zeros(count, np.int64),
        np.repeat(np.array(reached)[:, None], count, axis=1),
    )
    return heights_of(places, Borders.of(lines), slabs, Grid(np.zeros(2), 1.0 / UNIT), passes)


def test_a_cone_stays_straight():
    radius = np.linspace(2.1, 2.9, 5)
    assert height_at(radius, (5.0, 4.0, 3.0, 2.0, 1.0, None), 2, (True, True)) == pytest.approx(
        5.0 - radius, abs=1e-3
    )


def test_a_cup_that_widens_upwards_too():
    radius = np.linspace(3.1, 3.9, 5)
    heights = height_at(radius, (None, 1.0, 2.0, 3.0, 4.0, 5.0, None), 3, (True, True))
    assert heights == pytest.approx(radius, abs=1e-3)


def test_a_paraboloid_is_followed_better_than_by_straight_lines():
    heights = np.arange(5.0)
    radii = np.sqrt(5.0 - heights)
    radius = np.linspace(radii[3] + 0.02, radii[2] - 0.02, 9)
    found = height_at(radius, (*radii, None), 2, (True, True))
    straight = np.interp(radius, radii[[3, 2]], [3.0, 2.0])
    true = 5.0 - radius**2
    assert np.abs(found - true).max() < 0.5 * np.abs(straight - true).max()


@pytest.mark.parametrize("top", [3.3, 3.5, 3.9])
def test_the_cap_of_a_paraboloid(top):
    radii = np.sqrt(top - np.arange(4.0))
    radius = radii[3] * np.array((0.0, 0.3, 0.6, 0.9))
    found = height_at(radius, (*radii, None), 3, (True, False))
    assert found == pytest.approx(top - radius**2, abs=0.01)


def test_a_cap_that_hangs_down_is_the_mirror_image():
    radii = np.sqrt(3.5 - np.arange(4.0))
    radius = radii[3] * np.array((0.0, 0.3, 0.6))
    up = height_at(radius, (*radii, None), 3, (True, False))
    down = height_at(radius, (None, *radii[::-1]), 0, (False, True))
    assert up - 3.0 == pytest.approx(1.0 - down)


def test_a_flat_top_rises_at_45_degrees_half_the_way():
    found = height_at((2.9, 2.7, 2.0, 0.0), (3.0, 3.0, 3.0, None), 2, (True, False))
    assert found == pytest.approx((2.1, 2.3, 2.5, 2.5), abs=1e-3)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.5, 5.0), min_size=4, max_size=4), st.floats(0.001, 0.999))
def test_heights_stay_inside_the_slab_and_rise_with_the_distance(radii, share):
    low, high = radii[1], radii[2]
    if abs(high - low) < 1e-2:
        return
    radius = low + np.array((share, min(1.0, share + 0.05))) * (high - low)
    first, second = height_at(radius, (*radii, None), 1, (True, True))
    assert 1.0 < first < 2.0
    assert first <= second + 1e-6


def told(height):
    """A surface that is at one height everywhere, when it is between where it is sought."""

    def passes(places, start, end):
        within = (np.minimum(start, end) < height) & (height < np.maximum(start, end))
        return np.where(within, height, np.nan) + 0.0 * places[:, 0]

    return passes


def test_a_flat_top_is_as_high_as_is_shown_far_from_its_border():
    radius, radii = np.array([0.5, 2.0, 4.9]), (5.0, 5.0, 5.0, None)
    shown = height_at(radius, radii, 2, (True, False), told(2.2))
    alone = height_at(radius, radii, 2, (True, False))
    assert shown[:2] == pytest.approx(2.2, abs=1e-6)
    assert shown[2] == alone[2]  # the border lies in the plane
    assert alone[:2] == pytest.approx(2.5, abs=1e-6)


def test_what_is_shown_elsewhere_changes_nothing():
    radius, radii = np.array([0.5, 2.0, 4.9]), (5.0, 5.0, 5.0, None)
    shown = height_at(radius, radii, 2, (True, False), told(7.0))
    assert np.array_equal(shown, height_at(radius, radii, 2, (True, False)))


def test_a_floor_is_sought_downwards():
    radius, radii = np.array([0.5, 2.0]), (None, 5.0, 5.0, 5.0)
    assert height_at(radius, radii, 0, (False, True), told(0.7)) == pytest.approx(0.7, abs=1e-6)
