import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tape.reconnection import READINGS, Approach, approaches, reconnected, rewired
from tests.core.tape.drawings import circle, eight, flat, segment, unit
from tests.core.tape.samples import along, measured

SIGMA = 0.02
SEEDS = st.integers(0, 2**32 - 1)


def vee(side, degrees):
    """Half of two lines that cross: from the tip of one to the origin and out along the other."""
    half = 0.5 * degrees
    tips = side * np.array((unit(half), unit(-half)))
    share = np.linspace(0.0, 1.0, 40)[:, None]
    touch = side * np.array((0.5 * SIGMA, 0.0))
    return flat(np.concatenate([tips[0] + share * (touch - tips[0]), touch + share[1:] * (tips[1] - touch)]))


def bow(side, gap):
    """One half of )( with so much between the halves."""
    y = np.linspace(-1.0, 1.0, 81)
    return flat(np.column_stack((side * (0.5 * gap + 0.5 * y**2), y)))


def samples_of(*curves, n=700, seed=0):
    return measured(np.concatenate([along(c, n, SIGMA, seed + k) for k, c in enumerate(curves)]))


def lengths(curves):
    return sorted(line.length for line in curves)


def kinds(curves):
    """Numbers of closed and open curves."""
    closed = sum(line.closed for line in curves)
    return closed, len(curves) - closed


def tips(line):
    return line.vertices[[0, -1], :2]


def middle(a, b, stations=None):
    """An approach of two curves at their middles, unless told."""
    where = stations or (0.5 * a.length, 0.5 * b.length)
    gap = np.linalg.norm(a.at(np.array(where[:1])) - b.at(np.array(where[1:])))
    return Approach((0, 1), where, float(gap))


@pytest.mark.parametrize("degrees", [60.0, 90.0])
@pytest.mark.parametrize("seed", [0, 10, 20])
def test_vees_of_two_crossing_lines_become_the_lines(degrees, seed):
    lines = [segment(-unit(angle), unit(angle)) for angle in (0.5 * degrees, -0.5 * degrees)]
    sample, scale, extent = samples_of(*lines, seed=seed)
    curves, doubts = reconnected(sample, [vee(1, degrees), vee(-1, degrees)], SIGMA, scale, extent)
    assert kinds(curves) == (0, 2)
    for line in curves:
        # From one side to the other of the origin, straight.
        a, b = tips(line)
        assert a @ b < -0.8
        assert line.length == pytest.approx(2.0, abs=0.1)
    assert len(doubts) == 0


def test_lines_that_cross_already_stay():
    lines = [segment(-unit(angle), unit(angle)) for angle in (30.0, -30.0)]
    sample, scale, extent = samples_of(*lines)
    curves, _ = reconnected(sample, lines, SIGMA, scale, extent)
    assert kinds(curves) == (0, 2)
    assert all(a @ b < -0.8 for a, b in map(tips, curves))


@pytest.mark.parametrize("gap", [5.0, 8.0])
@pytest.mark.parametrize("seed", [0, 10, 20])
def test_bows_some_sigma_apart_stay(gap, seed):
    bows = [bow(side, gap * SIGMA) for side in (-1, 1)]
    sample, scale, extent = samples_of(*bows, seed=seed)
    curves, doubts = reconnected(sample, bows, SIGMA, scale, extent)
    assert kinds(curves) == (0, 2)
    for line in curves:
        assert len(set(np.sign(line.vertices[:, 0]))) == 1
    assert doubts.shape == (0, 3)


def test_a_curve_alone_stays_alone():
    sample, scale, extent = samples_of(circle(), n=800)
    curves, doubts = reconnected(sample, [circle()], SIGMA, scale, extent)
    assert kinds(curves) == (1, 0)
    assert curves[0].length == pytest.approx(2.0 * np.pi, rel=0.02)
    assert len(doubts) == 0


def test_bows_are_closest_at_their_middles():
    bows = [bow(-1, 0.1), bow(1, 0.1)]
    (one,) = approaches(bows, 0.05)
    assert one.curves in ((0, 1), (1, 0))
    assert one.gap == pytest.approx(0.1, rel=0.01)
    for k, station in zip(one.curves, one.stations, strict=True):
        assert station == pytest.approx(0.5 * bows[k].length, abs=0.05)


@pytest.mark.parametrize("degrees", [30.0, 60.0, 90.0])
def test_crossing_lines_approach_once(degrees):
    lines = [segment(-3.0 * unit(angle), 3.0 * unit(angle)) for angle in (0.0, degrees)]
    (one,) = approaches(lines, 0.05)
    assert one.gap < 0.05
    assert one.stations == pytest.approx((3.0, 3.0), abs=0.1)


def test_an_eight_approaches_itself():
    (one,) = approaches([eight()], 0.02)
    assert one.curves == (0, 0)
    s, t = one.stations
    assert abs(s - t) == pytest.approx(0.5 * eight().length, rel=0.02)


def test_curves_far_apart_do_not_approach():
    assert approaches([circle(), circle(3.0)], 0.1) == []


@pytest.mark.parametrize("curve", [circle(), segment((0, 0), (3, 1))])
def test_neighbouring_places_of_one_curve_are_no_approach(curve):
    assert approaches([curve], 0.05) == []


def test_parallel_lines_approach_once_a_stretch():
    unit_length = 0.05
    found = approaches([segment((0, 0), (6, 0)), segment((0, 0.1), (6, 0.1))], unit_length)
    assert len(found) > 1
    at = np.sort([one.stations[0] for one in found])
    assert np.diff(at).min() >= 12.0 * unit_length


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_approaches_tell_the_gap_of_their_places_and_come_in_order(seed):
    rng = np.random.default_rng(seed)
    curves = [segment(*rng.uniform(-1.0, 1.0, (2, 2))) for _ in range(3)] + [
        circle(*rng.uniform(-1, 1, 2), 0.5)
    ]
    found = approaches(curves, 0.03)
    for one in found:
        a, b = (curves[k].at(np.array([s]))[0] for k, s in zip(one.curves, one.stations, strict=True))
        assert np.linalg.norm(a - b) == pytest.approx(one.gap, abs=1e-9)
    assert [one.gap for one in found] == sorted(one.gap for one in found)


def test_readings_pair_four_arms_in_all_ways():
    pairs = {frozenset(map(frozenset, reading)) for reading in READINGS}
    assert len(pairs) == len(READINGS) == 3
    assert all(sorted(a for pair in reading for a in pair) == [0, 1, 2, 3] for reading in READINGS)


@pytest.mark.parametrize("reading", range(3))
def test_arms_are_joined_as_the_reading_says(reading):
    a, b = segment((-2, 0), (2, 0)), segment((0, -1), (0, 1))
    # Arms 0 and 1 before and after on the first curve, 2 and 3 on the second.
    arms = {(-2, 0): 0, (2, 0): 1, (0, -1): 2, (0, 1): 3}
    out = rewired([a, b], middle(a, b), reading, 0.1)
    assert kinds(out) == (0, 2)
    joined = {
        frozenset(arms[tuple(tip)] for tip in np.round(tips(line)).astype(int).tolist()) for line in out
    }
    assert joined == set(map(frozenset, READINGS[reading]))


EIGHT = eight()
CASES = {
    "open, open": ([segment((-1, 0), (1, 0)), segment((-1, 0.1), (1, 0.1))], (0, 1), [(0, 2)] * 3),
    "closed, closed": ([circle(), circle(2.1)], (0, 1), [(2, 0), (1, 0), (1, 0)]),
    "open, closed": ([segment((-1.05, -1), (-1.05, 1)), circle()], (0, 1), [(1, 1), (0, 1), (0, 1)]),
    "closed on itself": ([EIGHT], (0, 0), [(1, 0), (2, 0), (1, 0)]),
    "open on itself": (
        [flat([(-2, -0.05), (0, 0), (1, 1), (2, 0), (1, -1), (0, -0.1), (-2, 0.2)])],
        (0, 0),
        [(0, 1), (1, 1), (0, 1)],
    ),
}


@pytest.mark.parametrize("reading", range(3))
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("swapped", [False, True])
def test_rewired_curves_are_closed_or_open_as_the_reading_has_it(name, reading, swapped):
    curves, pair, expected = CASES[name]
    one = next(found for found in approaches(curves, 0.05) if set(found.curves) == set(pair))
    if swapped:
        one = Approach(one.curves[::-1], one.stations[::-1], one.gap)
    assert kinds(rewired(curves, one, reading, 0.02)) == expected[reading]


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(0, 2), st.floats(0.001, 0.1))
def test_length_is_kept_but_for_the_cuts(seed, reading, cut):
    rng = np.random.default_rng(seed)
    shapes = [segment((-1, 0), (1, 0.2)), segment((0.1, -1), (0, 1)), circle(0.9), eight()]
    i, j = rng.choice(4, 2, replace=False)
    curves = [shapes[i], shapes[j]]
    stations = tuple(float(rng.uniform(0.2, 0.8) * line.length) for line in curves)
    one = middle(*curves, stations)
    total = sum(lengths(curves))
    left = sum(lengths(rewired(curves, one, reading, cut)))
    # Each of the two joins bridges two cuts and the gap at most.
    assert total - 4.0 * cut - 1e-9 <= left <= total + 2.0 * one.gap + 1e-9


def test_other_curves_are_left_alone():
    a, b, other = segment((-1, 0), (1, 0)), segment((0, -1), (0, 1)), circle(5.0)
    out = rewired([a, b, other], middle(a, b), 1, 0.05)
    assert other in out
    assert len(out) == 3


@pytest.mark.parametrize("cut", [0.4, 2.0])
def test_curves_too_short_for_the_cuts_are_not_rewired(cut):
    long, short = segment((-3, 0), (3, 0)), segment((0, -0.3), (0, 0.3))
    assert rewired([long, short], middle(long, short), 1, cut) is None
    assert rewired([long, short], middle(long, short), 1, 0.1) is not None
