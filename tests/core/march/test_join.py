import numpy as np
import pytest

from core.cloud.sampling import Sample
from core.march.bridge import admissible_bridges
from core.march.join import join_fragments
from tests.core.march.walks import fragment
from tests.core.shapes import arc, distances, in_space, line

SIGMA, RADIUS = 0.01, 0.2


def bow(start, end, radius=1.0):
    angle = np.linspace(start, end, max(3, round(abs(end - start) / 0.1)))
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def stick(start, end, height=0.0):
    x = np.linspace(start, end, 15)
    return np.column_stack((x, np.full(15, height)))


def sampled(*parts):
    return Sample.of(in_space(np.concatenate(parts)))


def march_of(points, sample_size, length, **changes):
    return fragment(points, sigma=SIGMA, density=sample_size / length, radius=RADIUS, **changes)


@pytest.mark.parametrize("turned", [(False, False), (True, False), (False, True), (True, True)])
def test_two_halves_of_a_circle_become_one_closed_curve(turned):
    sample = sampled(arc(3000, SIGMA))
    halves = [bow(0.1, 3.1), bow(3.2, 6.2)]
    parts = [
        march_of(h[::-1] if back else h, 3000, 2 * np.pi) for h, back in zip(halves, turned, strict=True)
    ]
    (curve,) = join_fragments(sample, parts)
    assert curve.closed
    assert distances(in_space(bow(0, 6.28)), curve.vertices, True).max() < SIGMA
    assert curve.length == pytest.approx(2 * np.pi, rel=0.02)


def test_the_ends_of_one_fragment_close_it():
    (curve,) = join_fragments(sampled(arc(3000, SIGMA)), [march_of(bow(0.1, 6.2), 3000, 2 * np.pi)])
    assert curve.closed


def test_closed_fragments_are_done():
    ring = march_of(bow(0.0, 6.2), 3000, 2 * np.pi, closed=True)
    (curve,) = join_fragments(sampled(arc(3000, SIGMA)), [ring])
    assert curve.closed
    np.testing.assert_array_equal(curve.vertices, ring.centres)


def test_pieces_of_a_segment_become_one_open_curve_in_order():
    sample = sampled(line(3000, SIGMA, 3.0))
    pieces = [stick(0.55, 1.45), stick(-0.45, 0.45), stick(-1.45, -0.55)]
    (curve,) = join_fragments(sample, [march_of(p, 3000, 3.0) for p in pieces])
    assert not curve.closed
    x = curve.vertices[:, 0]
    assert np.all(np.diff(x) > 0) or np.all(np.diff(x) < 0)
    assert abs(x).max() > 1.4


@pytest.mark.parametrize("gap", [0.25, 0.6])
def test_a_gap_without_samples_is_not_bridged(gap):
    left, right = line(2000, SIGMA), line(2000, SIGMA, seed=1)
    left[:, 0] -= 0.5 + gap / 2
    right[:, 0] += 0.5 + gap / 2
    parts = [stick(-0.95 - gap / 2, -gap / 2 - 0.02), stick(gap / 2 + 0.02, 0.95 + gap / 2)]
    curves = join_fragments(sampled(left, right), [march_of(p, 2000, 1.0) for p in parts])
    assert [c.closed for c in curves] == [False, False]


def test_an_open_arc_is_not_closed_across_its_opening():
    sample = sampled(arc(3000, SIGMA, turn=5.5))
    (curve,) = join_fragments(sample, [march_of(bow(0.1, 5.4), 3000, 5.5)])
    assert not curve.closed


def test_ends_around_a_corner_are_joined_at_the_corner():
    one = line(1000, SIGMA, 1.0)
    one[:, 0] += 0.5
    two = line(1000, SIGMA, 1.0, seed=1)[:, ::-1] + np.array([0.0, 0.5])
    sample = sampled(one, two)
    parts = [march_of(p, 1000, 1.0) for p in (stick(0.15, 0.95), stick(0.15, 0.95)[:, ::-1])]
    (curve,) = join_fragments(sample, parts)
    assert not curve.closed
    assert distances(np.zeros((1, 3)), curve.vertices, False)[0] < 3 * SIGMA


def test_at_a_crossing_the_straight_ways_are_taken():
    cross = line(2000, SIGMA, 2.0), line(2000, SIGMA, 2.0, seed=1)[:, ::-1]
    arms = [stick(-0.95, -0.06), stick(0.06, 0.95)]
    arms += [a[:, ::-1] for a in arms]
    curves = join_fragments(sampled(*cross), [march_of(a, 2000, 2.0) for a in arms])
    assert len(curves) == 2
    for curve in curves:
        spans = np.ptp(curve.vertices[:, :2], axis=0)
        assert spans.max() > 1.8
        assert spans.min() < 0.1


def test_a_march_that_stopped_early_is_led_on_to_where_the_samples_end():
    sample = sampled(line(3000, SIGMA, 2.0))
    (curve,) = join_fragments(sample, [march_of(stick(-0.9, 0.9), 3000, 2.0)])
    assert abs(curve.vertices[0, 0]) == pytest.approx(1.0, abs=0.06)
    assert abs(curve.vertices[-1, 0]) == pytest.approx(1.0, abs=0.06)


def test_without_fragments_there_are_no_curves():
    assert join_fragments(sampled(arc(50, SIGMA)), []) == []


def test_bridges_come_cheapest_first_and_join_ends():
    sample = sampled(line(3000, SIGMA, 3.0))
    opened = [march_of(p, 3000, 3.0) for p in (stick(-1.4, -0.6), stick(-0.5, 0.5), stick(0.6, 1.4))]
    bridges = admissible_bridges(sample, opened)
    assert len(bridges) >= 2
    costs = [b.cost for b in bridges]
    assert costs == sorted(costs)
    named = [[(e.fragment, e.last) for e in (b.first, b.second)] for b in bridges[:2]]
    pairs = {frozenset(pair) for pair in named}
    assert pairs == {frozenset(((0, True), (1, False))), frozenset(((1, True), (2, False)))}
    for bridge in bridges:
        for end in (bridge.first, bridge.second):
            assert np.linalg.norm(end.outward) == pytest.approx(1.0)
