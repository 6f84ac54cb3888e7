import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.truth.intersections import crossings, separation


def ring(radius=1.0, centre=(0.0, 0.0), count=200):
    angle = np.arange(count) * 2 * np.pi / count
    return np.column_stack((np.cos(angle), np.sin(angle))) * radius + centre, True


def test_two_circles_cross_where_both_have_their_radius():
    found = crossings([ring(), ring(centre=(1.0, 0.0))])
    assert len(found.locations) == 2
    np.testing.assert_allclose(sorted(found.locations[:, 1]), [-np.sqrt(0.75), np.sqrt(0.75)], atol=1e-3)
    np.testing.assert_allclose(found.locations[:, 0], 0.5, atol=1e-3)
    assert found.curves.tolist() == [[0, 1], [0, 1]]


def test_a_bow_tie_crosses_itself_once():
    bow = np.array([(0, 0), (2, 2), (2, 0), (0, 2)], float)
    found = crossings([(bow, True)])
    np.testing.assert_allclose(found.locations, [[1.0, 1.0]])
    assert len(crossings([(bow[:3], False)]).locations) == 0


def test_a_crossing_at_a_common_vertex_counts_once():
    across = np.array([(-1, 0), (0, 0), (1, 0)], float)
    assert len(crossings([(across, False), (across[:, ::-1], False)]).locations) == 1


@pytest.mark.parametrize("first", range(4))
def test_a_self_crossing_at_a_vertex_counts_once_wherever_the_curve_starts(first):
    bow = np.roll([(0, 0), (1, 1), (2, 2), (2, 0), (1, 1), (0, 2)], -first, axis=0).astype(float)
    np.testing.assert_allclose(crossings([(bow, True)]).locations, [[1.0, 1.0]])


@settings(max_examples=30)
@given(st.floats(0.0, 6.28), st.integers(0, 5))
def test_curves_that_touch_at_a_vertex_do_not_cross(angle, first):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    lobe = np.array([(0, 0), (2, 1), (3, 0), (3, -1), (2, -1), (1, -0.6)]) @ turn
    pair = (lobe, True), (np.roll(lobe * (-1, -1), first, axis=0), True)
    assert len(crossings(pair).locations) == 0
    inner = np.array([(0, 0), (1, 0.2), (2, 0), (1, -0.2)]) @ turn
    assert len(crossings([(lobe, True), (np.roll(inner, first, axis=0), True)]).locations) == 0


def test_a_curve_that_touches_itself_at_a_vertex_does_not_cross():
    pinched = np.array([(0, 0), (1, 1), (2, 0), (2, 2), (1, 1), (0, 2)], float)
    assert len(crossings([(pinched, True)]).locations) == 0


@settings(max_examples=30)
@given(st.floats(-0.9, 0.9))
def test_a_curve_that_ends_on_another_does_not_cross_it(at):
    bar = np.array([(-1, 0), (0, 0), (1, 0)], float)
    stem = np.array([(at, 0.0), (0.2, 1.0)])
    assert len(crossings([(bar, False), (stem, False)]).locations) == 0


def test_positions_lead_to_the_location():
    one = np.array([(0, 0), (1, 0), (2, 0), (3, 0)], float)
    other = np.array([(2.25, -1), (2.25, 3)], float)
    assert crossings([(one, False), (other, False)]).positions.tolist() == [[2.25, 0.25]]


def test_smooth_rings_and_curves_in_space_have_no_crossings():
    assert len(crossings([ring(), ring(0.5)]).locations) == 0
    bow = np.array([(0, 0, 0), (2, 2, 0), (2, 0, 0), (0, 2, 0)], float)
    assert crossings([(bow, True)]).locations.shape[0] == 0
    assert crossings([]).locations.shape[0] == 0


@given(st.integers(2, 9), st.randoms(use_true_random=False))
def test_chords_of_a_circle_cross_as_their_ends_interleave(count, random):
    angles = sorted(random.sample(range(360), 2 * count))
    random.shuffle(angles)
    pairs = [tuple(sorted(angles[2 * k : 2 * k + 2])) for k in range(count)]
    lines = [
        (np.array([(np.cos(np.radians(a)), np.sin(np.radians(a))) for a in pair]), False) for pair in pairs
    ]
    interleaved = sum(
        a < c < b < d or c < a < d < b for i, (a, b) in enumerate(pairs) for c, d in pairs[i + 1 :]
    )
    assert len(crossings(lines).locations) == interleaved


def test_separation_of_rings_is_the_gap_and_of_one_ring_its_diameter():
    assert separation([ring(), ring(0.6)]) == pytest.approx(0.4, abs=1e-3)
    waist = np.array([(0, 0), (4, 0.9), (8, 0), (8, 2), (4, 1.1), (0, 2)], float)
    fine = np.vstack(
        [np.linspace(a, b, 40, endpoint=False) for a, b in zip(waist, np.roll(waist, -1, 0), strict=True)]
    )
    assert separation([(fine, True)]) == pytest.approx(0.2, abs=0.01)
