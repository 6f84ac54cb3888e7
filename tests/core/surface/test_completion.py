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
