import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.crossings import crossings
from core.tape.contacts import contacts
from tests.core.tape.drawings import circle, eight, flat, scribble, segment


def endings(curves, touching):
    return contacts(curves, touching)[len(crossings(curves)) :]


def test_crossings_are_contacts():
    (contact,) = contacts([eight()], 0.0)
    np.testing.assert_allclose(contact.place, 0.0, atol=1e-4)
    assert contact.curves == (0, 0)


def test_nothing_meets_nothing():
    assert contacts([], 0.1) == []
    assert contacts([circle(), circle(5.0)], 0.1) == []


@pytest.mark.parametrize("outwards", [True, False])
def test_an_end_near_a_curve_ends_on_it_at_its_foot(outwards):
    stick = segment((1.1, 0.0), (3.0, 0.0)) if outwards else segment((3.0, 0.0), (1.1, 0.0))
    assert endings([circle(), stick], 0.05) == []
    (contact,) = endings([circle(), stick], 0.15)
    np.testing.assert_allclose(contact.place, (1.0, 0.0, 0.0), atol=1e-4)
    assert contact.curves == (1, 0)
    assert contact.stations[0] == pytest.approx(0.0 if outwards else 1.9)


def test_an_end_beyond_a_curve_is_a_crossing_only():
    assert endings([circle(), segment((0.95, 0.0), (3.0, 0.0))], 0.1) == []


def test_an_end_on_a_curve_touches_it_at_any_distance():
    line = flat([(-1, 0), (1, 0)])
    (contact,) = endings([line, flat([(0.25, 0), (0.25, 1)])], 1e-9)
    assert contact.stations == pytest.approx((0.0, 1.25))


def test_a_curve_may_end_on_itself():
    u = np.linspace(0.0, 2.0 * np.pi, 100)
    ring = np.column_stack((np.cos(u), np.sin(u)))
    six = flat([(1.0, 4.0), *ring, (0.0, 0.0)])
    six.vertices[-1, :2] = (0.95, 0.6)
    (contact,) = endings([six], 0.3)
    assert contact.curves == (0, 0)
    assert contact.stations[0] == pytest.approx(six.length)


def test_ends_do_not_end_on_ends():
    assert endings([segment((0, 0), (1, 0)), segment((1.01, 0.0), (2, 1))], 0.1) == []


def test_an_end_does_not_reach_through_its_own_curve():
    # The end turns back behind its own curve, which then lies between it and the other one.
    hook = flat([(-3.0, 0.0), (0.0, 0.0), (0.1, -0.1), (-0.1, -0.15)])
    assert endings([hook, segment((-3.0, 0.1), (3.0, 0.1))], 0.3) == []


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3))
def test_an_end_is_as_near_as_said(seed, touching):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng, closed) for closed in (True, False, False)]
    for contact in endings(curves, touching):
        k, other = contact.curves
        tip, foot = (
            curves[n].at(np.array([s]))[0] for n, s in zip((k, other), contact.stations, strict=True)
        )
        assert not curves[k].closed
        assert np.linalg.norm(tip - foot) <= touching + 1e-9
        np.testing.assert_allclose(foot, contact.place, atol=1e-9)
