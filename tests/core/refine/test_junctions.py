import numpy as np
import pytest

from core.refine.branches import near_branches
from core.refine.ends import prolonged
from core.refine.junctions import meeting
from core.refine.polyline import Polyline
from tests.core.refine.test_branches import CUT, SIGMA, straight
from tests.core.shapes import in_space

BY = 3.0 * SIGMA
BAR = straight()


def end_of(stem, bar=BAR):
    """Where the first end of a stem belongs, as a distance from where it is."""
    line = prolonged(stem, BY)
    lines = [bar, line]
    branches = near_branches(lines, np.full(2, SIGMA), CUT)
    ends = np.array([(-np.inf, np.inf), (BY, BY + stem.length)])
    if branches is None:
        return None
    station = meeting(line, 1, BY, branches, ends)
    return None if station is None else station - BY


def stem(short, degrees=90.0, x=0.0, z=0.0):
    """A segment that stops ``short`` of the bar on its way to (x, 0); negative: beyond it."""
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    places = np.linspace(short, 0.5, 40)[:, None] * way + (x, 0.0)
    return Polyline(in_space(places) + np.array([0.0, 0.0, z]), False)


@pytest.mark.parametrize("degrees", [40.0, 90.0, 130.0])
@pytest.mark.parametrize("short", [-1.8, -0.5, 0.0, 0.5, 1.8])
def test_an_end_beside_a_curve_is_on_it(short, degrees):
    assert end_of(stem(short * SIGMA, degrees)) == pytest.approx(-short * SIGMA, abs=0.02 * SIGMA)


@pytest.mark.parametrize("short", [-2.5, 2.5, 6.0, 30.0])
def test_an_end_farther_away_stays_where_it_is(short):
    assert end_of(stem(short * SIGMA)) is None


@pytest.mark.parametrize("degrees", [0.0, 5.0, 20.0])
def test_curves_that_run_side_by_side_have_no_meeting(degrees):
    assert end_of(stem(0.0, degrees)) is None


def test_an_end_over_a_curve_in_space_is_not_on_it():
    assert end_of(stem(0.5 * SIGMA, z=2.0 * SIGMA)) is None
    assert end_of(stem(0.5 * SIGMA, z=0.2 * SIGMA)) == pytest.approx(-0.5 * SIGMA, abs=0.05 * SIGMA)


def test_beyond_the_other_curves_end_there_is_nothing_to_meet():
    bar = prolonged(straight(half=0.2), BY)
    line = prolonged(stem(0.0, x=0.2 + 0.5 * BY), BY)
    branches = near_branches([bar, line], np.full(2, SIGMA), CUT)
    ends = np.array([(BY, BY + 0.4), (BY, BY + 0.5)])
    assert meeting(line, 1, BY, branches, ends) is None
    inside = prolonged(stem(0.0, x=0.2 - 0.5 * BY), BY)
    branches = near_branches([bar, inside], np.full(2, SIGMA), CUT)
    assert meeting(inside, 1, BY, branches, ends) == pytest.approx(BY, abs=0.02 * SIGMA)
