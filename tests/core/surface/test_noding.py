import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.linework import Linework, node_keys
from core.surface.noding import noded
from tests.core.surface.contours import inside, lines_of

POINTS = st.tuples(st.integers(-30, 30), st.integers(-30, 30))
LOOPS = st.lists(st.lists(POINTS, min_size=3, max_size=7), min_size=1, max_size=3)
SQUARE = ((0, 0), (1000, 0), (1000, 1000), (0, 1000))


def cross_or_touch(lines):
    """Whether two edges have a point in common that is no end of both: all pairs, exactly."""
    a, b = lines.ends[:, None, 0], lines.ends[:, None, 1]
    c, d = lines.ends[None, :, 0], lines.ends[None, :, 1]

    def turn(p, q, r):
        return (q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]

    def within(p):
        on = (turn(a, b, p) == 0) & np.all((np.minimum(a, b) <= p) & (p <= np.maximum(a, b)), axis=2)
        return on & np.any(p != a, axis=2) & np.any(p != b, axis=2)

    crossing = (np.sign(turn(a, b, c)) * np.sign(turn(a, b, d)) < 0) & (
        np.sign(turn(c, d, a)) * np.sign(turn(c, d, b)) < 0
    )
    return bool(np.any(crossing | within(c) | within(d)))


def degrees(lines, level):
    return np.unique(node_keys(lines.ends[lines.level == level]), return_counts=True)[1]


@settings(max_examples=15, deadline=None)
@given(LOOPS, LOOPS)
def test_edges_meet_at_ends_only_and_borders_pass_once_through_each_node(first, second):
    # Corners some units apart, so that pulling them apart has room.
    loops = [100 * np.array(loop) for loop in (*first, *second)]
    lines = noded(lines_of(*loops, levels=[0] * len(first) + [1] * len(second)))
    assert not cross_or_touch(lines)
    for level in range(2):
        assert np.all(degrees(lines, level) == 2)


def test_contours_that_nearly_coincide_are_noded():
    turn = 2.0 * np.pi * np.arange(100) / 100
    rng = np.random.default_rng(0)
    radius = 100_000.0 + rng.normal(0.0, 30.0, (5, 100))
    loops = np.rint(radius[:, :, None] * np.column_stack((np.cos(turn), np.sin(turn)))).astype(np.int64)
    lines = noded(lines_of(*loops, levels=list(range(5))))
    for level in range(4):
        assert not cross_or_touch(lines.taken((lines.level == level) | (lines.level == level + 1)))
        assert np.all(degrees(lines, level) == 2)


@settings(max_examples=30, deadline=None)
@given(LOOPS, st.integers(0, 2**32 - 1))
def test_the_region_stays_the_same_but_for_the_grid(loops, seed):
    lines = lines_of(*(1000 * np.array(loop) for loop in loops))
    points = np.random.default_rng(seed).uniform(-30_000.0, 30_000.0, (300, 2))
    a, b = lines.ends.astype(float).swapaxes(0, 1)
    along = np.clip(((points[:, None] - a) * (b - a)).sum(2) / ((b - a) ** 2).sum(1), 0.0, 1.0)
    far = (
        np.linalg.norm(points[:, None] - a - along[..., None] * (b - a), axis=2).min(axis=1, initial=1e9)
        > 200.0
    )
    assert np.array_equal(inside(noded(lines), points[far]), inside(lines, points[far]))


def test_crossing_edges_of_neighbouring_levels_share_a_node():
    lines = noded(lines_of(SQUARE, [(x + 500, y + 500) for x, y in SQUARE], levels=[0, 1]))
    for node in ((1000, 500), (500, 1000)):
        for level in range(2):
            assert np.any(np.all(lines.ends[lines.level == level] == node, axis=2))


def test_levels_further_apart_than_the_reach_are_left_alone():
    lines = lines_of(SQUARE, [(x + 500, y + 500) for x, y in SQUARE], levels=[0, 2])
    assert len(noded(lines)) == 8
    assert len(noded(lines, reach=2)) == 12


def test_edges_that_occur_twice_in_a_level_vanish_and_those_of_two_levels_stay():
    assert len(noded(lines_of(SQUARE, SQUARE))) == 0
    assert len(noded(lines_of(SQUARE, SQUARE, levels=[0, 1]))) == 8
    beside = noded(lines_of(SQUARE, [(x + 1000, y) for x, y in SQUARE]))
    assert len(beside) == 6


@pytest.mark.parametrize("count", [2, 3, 5])
def test_gates_pass_on_to_the_pieces_of_an_edge(count):
    lines = lines_of(
        SQUARE,
        *([(x + 100 * k + 1, y + 500) for x, y in SQUARE] for k in range(count)),
        levels=[0, *[1] * count],
    )
    flags = np.zeros((len(lines), 2), np.bool_)
    flags[:4, 1] = True
    out = noded(Linework(lines.ends, lines.level, flags))
    assert np.array_equal(out.gated[:, 1], out.level == 0)
