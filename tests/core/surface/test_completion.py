import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.results import Curve
from core.surface.completion import completed_loops
from core.surface.draft import Draft

TURN = np.linspace(0.0, 2 * np.pi, 300, endpoint=False)
NOTHING = np.zeros((0, 2))


def arc(radius, share=1.0, centre=(0.0, 0.0)):
    """A circle, or an open share of it."""
    turn = TURN[: int(share * len(TURN))]
    return np.asarray(centre) + radius * np.stack((np.cos(turn), np.sin(turn)), axis=1)


def curve(vertices, closed=True):
    return Curve(vertices, closed, 0, 1.0, len(vertices), 0.0)


def whole(height, *lines):
    return Draft(height, tuple(curve(one) for one in lines), complete=True, samples=300)


def lost(height, *loose):
    return Draft(height, (), tuple(curve(one, closed=False) for one in loose), 0.001, 0.02, samples=300)


@settings(max_examples=6, deadline=None)
@given(st.floats(0.1, 0.9), st.floats(0.5, 2.0))
def test_a_level_without_samples_gets_what_lies_between(share, high):
    (loop,) = completed_loops(Draft(share), NOTHING, [whole(0.0, arc(1.0))], [whole(1.0, arc(high))])
    wanted = (1.0 - share) + share * high
    assert np.linalg.norm(loop, axis=1) == pytest.approx(np.full(len(loop), wanted), abs=0.01)


def test_without_neighbours_nothing_is_known():
    assert completed_loops(lost(0.5, arc(1.0, 0.5)), arc(1.0, 0.5), [], []) == []


def test_beyond_the_last_complete_level_contours_go_on_where_most_of_them_was_seen():
    for share, known in ((0.7, 1), (0.3, 0)):
        seen = arc(0.97, share)
        loops = completed_loops(lost(1.0, seen), seen, [whole(0.98, arc(1.0))], [])
        assert len(loops) == known
    assert completed_loops(Draft(1.0), NOTHING, [whole(0.0, arc(1.0))], []) == []


def test_where_the_level_was_seen_its_own_curve_holds_and_elsewhere_the_neighbours():
    # the own half circle is 0.03 larger than what lies between the neighbours
    seen = arc(1.03, 0.5)
    neighbours = [whole(-0.05, arc(0.98))], [whole(0.05, arc(1.02))]
    (loop,) = completed_loops(lost(0.0, seen), seen, *neighbours)
    radius, turn = np.linalg.norm(loop, axis=1), np.mod(np.arctan2(loop[:, 1], loop[:, 0]), 2 * np.pi)
    inner = (turn > 0.4) & (turn < np.pi - 0.4)
    far = (turn > np.pi + 1.2) & (turn < 2 * np.pi - 1.2)
    assert radius[inner] == pytest.approx(np.full(np.count_nonzero(inner), 1.03), abs=2e-3)
    assert radius[far] == pytest.approx(np.ones(np.count_nonzero(far)), abs=2e-3)
    assert np.all((radius > 0.99) & (radius < 1.04))


def test_curves_of_something_else_are_passed_over():
    away, across = arc(0.3, 0.6), np.stack((np.linspace(0.9, 1.1, 40), np.zeros(40)), axis=1)
    neighbours = [whole(-0.05, arc(0.98))], [whole(0.05, arc(1.02))]
    (loop,) = completed_loops(lost(0.0, away, across), np.vstack((away, across)), *neighbours)
    assert np.linalg.norm(loop, axis=1) == pytest.approx(np.ones(len(loop)), abs=5e-3)


def test_a_curve_without_samples_was_not_seen():
    bridged = np.vstack((arc(1.0, 0.7), [[1.0, 0.0]]))  # its last edge cuts across the gap
    draft = Draft(0.0, (curve(bridged),), (), 0.001, 0.02, 90.0, samples=210)
    neighbours = [whole(-0.05, arc(0.99))], [whole(0.05, arc(1.01))]
    (loop,) = completed_loops(draft, arc(1.0, 0.7), *neighbours)
    assert np.linalg.norm(loop, axis=1) == pytest.approx(np.ones(len(loop)), abs=5e-3)


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.9))
def test_contours_never_cross(seed, share):
    rng = np.random.default_rng(seed)
    low, high = (
        [
            arc(rng.uniform(0.3, 1.0), 1.0, rng.uniform(-0.5, 0.5, 2) + np.array([2.5 * k, 0.0]))
            for k in range(2)
        ]
        for _ in range(2)
    )
    own = [arc(rng.uniform(0.3, 1.0), rng.uniform(0.2, 0.9), (2.5 * k, 0.0)) for k in range(2)]
    loops = completed_loops(lost(share, *own), np.vstack(own), [whole(0.0, *low)], [whole(1.0, *high)])
    if loops:
        assert shapely.MultiLineString([np.vstack((one, one[:1])) for one in loops]).is_simple


def radii(loop, centre=(0.0, 0.0)):
    return np.linalg.norm(loop - np.asarray(centre), axis=1)


def test_a_loop_that_was_seen_whole_stays_where_the_guide_knows_nothing_of_it():
    seen, apart = arc(1.0, 0.8), arc(0.3, centre=(3.0, 0.0))
    draft = Draft(0.0, (curve(apart),), (curve(seen, closed=False),), 0.001, 0.02, samples=540)
    neighbours = [whole(-0.05, arc(0.99))], [whole(0.05, arc(1.01))]
    loops = completed_loops(draft, np.vstack((seen, apart)), *neighbours)
    assert len(loops) == 2
    large, small = sorted(loops, key=lambda one: -np.ptp(one[:, 0]))
    assert radii(large) == pytest.approx(np.ones(len(large)), abs=5e-3)
    assert radii(small, (3.0, 0.0)) == pytest.approx(np.full(len(small), 0.3), abs=5e-3)


@pytest.mark.parametrize("near", [True, False])
def test_loops_that_were_seen_apart_stay_apart_where_the_guide_joins_them(near):
    pair = [arc(1.0, centre=(-1.03, 0.0)), arc(1.0, centre=(1.03, 0.0))]
    joined = np.array(shapely.union_all([shapely.Polygon(one).buffer(0.08) for one in pair]).exterior.coords)
    third = arc(1.0, 0.7, (0.0, 4.0))
    draft = Draft(0.0, tuple(map(curve, pair)), (curve(third, closed=False),), 0.001, 0.02, samples=810)
    circle = arc(1.0, 1.0, (0.0, 4.0))
    below = whole(-0.05, *(pair if near else [joined[:-1]]), circle)
    above = whole(0.05, joined[:-1], circle)
    loops = completed_loops(draft, np.vstack((*pair, third)), [below], [above])
    assert len(loops) == 3
    centres = [(-1.03, 0.0), (0.0, 4.0), (1.03, 0.0)]
    for one, centre in zip(sorted(loops, key=lambda one: one[:, 0].mean()), centres, strict=True):
        assert radii(one, centre) == pytest.approx(np.ones(len(one)), abs=0.01)


def test_what_was_seen_of_a_contour_that_ends_above_is_completed_from_below():
    # what lies between the neighbours has lost the contour on the right already
    kept, ends = arc(1.0), arc(0.4, 0.9, (5.0, 0.0))
    draft = Draft(0.05, (curve(kept),), (curve(ends, closed=False),), 0.001, 0.02, samples=570)
    below, above = whole(0.0, arc(1.0), arc(0.5, 1.0, (5.0, 0.0))), whole(0.1, arc(1.0))
    loops = completed_loops(draft, np.vstack((kept, ends)), [below], [above])
    assert len(loops) == 2
    right = max(loops, key=lambda one: one[:, 0].mean())
    assert radii(right, (5.0, 0.0)) == pytest.approx(np.full(len(right), 0.4), abs=0.02)


def test_of_contours_within_each_other_none_comes_alone():
    kept, outer = arc(1.0), arc(0.5, 0.8, (5.0, 0.0))
    draft = Draft(0.05, (curve(kept),), (curve(outer, closed=False),), 0.001, 0.02, samples=540)
    below = whole(0.0, arc(1.0), arc(0.5, 1.0, (5.0, 0.0)), arc(0.1, 1.0, (5.0, 0.0)))
    loops = completed_loops(draft, np.vstack((kept, outer)), [below], [whole(0.1, arc(1.0))])
    assert len(loops) == 1


def test_what_is_shown_completes_a_level_without_neighbours():
    seen = arc(1.03, 0.5)
    (loop,) = completed_loops(lost(0.0, seen), seen, [], [], [arc(1.0)])
    turn = np.mod(np.arctan2(loop[:, 1], loop[:, 0]), 2 * np.pi)
    inner = (turn > 0.4) & (turn < np.pi - 0.4)
    far = (turn > np.pi + 1.2) & (turn < 2 * np.pi - 1.2)
    assert radii(loop)[inner] == pytest.approx(np.full(np.count_nonzero(inner), 1.03), abs=2e-3)
    assert radii(loop)[far] == pytest.approx(np.ones(np.count_nonzero(far)), abs=2e-3)


@pytest.mark.parametrize("points", [NOTHING, arc(1.0, 0.02)])
def test_what_is_shown_is_all_there_is_where_hardly_anything_was_seen(points):
    loops = completed_loops(Draft(0.0, samples=len(points)), points, [], [], [arc(1.0), arc(0.5)])
    assert [radii(one).mean() for one in loops] == pytest.approx([1.0, 0.5], abs=1e-3)


def test_what_is_shown_with_crossings_is_not_used():
    seen, crossing = arc(1.0, 0.6), [arc(1.0), arc(1.0, 1.0, (0.5, 0.0))]
    (loop,) = completed_loops(
        lost(0.0, seen), seen, [whole(-0.1, arc(1.0))], [whole(0.1, arc(1.0))], crossing
    )
    assert radii(loop) == pytest.approx(np.ones(len(loop)), abs=2e-3)


def test_samples_decide_over_curves_that_run_less_well_through_them():
    rng = np.random.default_rng(0)
    samples = np.repeat(arc(1.0, 0.8), 4, axis=0) + 0.01 * rng.normal(size=(960, 2))
    own = arc(1.0, 0.8) * (1.0 + 0.008 * np.sin(40.0 * TURN[:240]))[:, None]
    draft = Draft(0.0, (), (curve(own, closed=False),), 0.01, 0.005, samples=960)
    (loop,) = completed_loops(draft, samples, [whole(-0.1, arc(1.0))], [whole(0.1, arc(1.0))])
    assert np.sqrt(np.mean((radii(loop) - 1.0) ** 2)) < 0.6 * np.sqrt(np.mean((radii(own) - 1.0) ** 2))


def test_contours_do_not_cross_where_the_curves_that_the_level_has_seen_do():
    # the own arcs, open on the outer sides, overlap between the centres
    turned = arc(1.15, 0.8) @ np.array([[np.cos(0.63), np.sin(0.63)], [-np.sin(0.63), np.cos(0.63)]])
    centre = np.array([1.1, 0.0])
    own = [turned * np.array([-1.0, 1.0]) - centre, turned + centre]
    own = [one * np.array([-1.0, 1.0]) for one in own]
    below, above = ([arc(radius, 1.0, side * centre) for side in (-1, 1)] for radius in (0.87, 1.09))
    loops = completed_loops(lost(0.0, *own), np.vstack(own), [whole(-0.1, *below)], [whole(0.1, *above)])
    assert len(loops) == 2
    assert shapely.MultiLineString([np.vstack((one, one[:1])) for one in loops]).is_simple
    for one, side in zip(sorted(loops, key=lambda one: one[:, 0].mean()), (-1, 1), strict=True):
        upper = np.abs(one[:, 0] - side * 1.1) < 0.2
        assert radii(one, side * centre)[upper] == pytest.approx(np.full(upper.sum(), 1.15), abs=0.02)
