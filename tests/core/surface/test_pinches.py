import numpy as np
import pytest

from core.surface.linework import node_keys
from core.surface.noding import noded
from core.surface.pinches import cut_apart
from tests.core.surface.contours import inside, lines_of

LOWER, UPPER = ((0, 0), (100, 0), (100, 100), (0, 100)), ((100, 100), (200, 100), (200, 200), (100, 200))


def passes(lines):
    return np.unique(node_keys(lines.ends), return_counts=True)[1]


def test_squares_that_touch_at_a_corner_lose_it():
    lines, new = cut_apart(lines_of(LOWER, UPPER), 0)
    assert new.any()
    assert np.all(passes(lines) == 2)
    assert not inside(lines, [(100.3, 99.6), (99.6, 100.3), (99.9, 99.8), (100.1, 100.2)]).any()
    assert inside(lines, [(90.1, 89.9), (110.1, 110.2)]).all()


def test_holes_that_touch_are_joined():
    around = ((-50, -50), (250, -50), (250, 250), (-50, 250))
    lines, _ = cut_apart(lines_of(around, LOWER, UPPER), 0)
    assert not inside(lines, [(100.2, 100.3)])[0]
    assert np.all(passes(lines) == 2)


def test_other_levels_stay():
    lines, new = cut_apart(lines_of(LOWER, UPPER, LOWER, levels=[0, 0, 1]), 0)
    assert np.count_nonzero(lines.level[~new] == 1) == 4
    assert np.all(lines.level[new] == 0)


def test_borders_that_touch_nowhere_stay():
    lines, new = cut_apart(lines_of(LOWER, [(x + 200, y) for x, y in LOWER]), 0)
    assert not new.any()
    assert len(lines) == 8


@pytest.mark.parametrize("count", [2, 3, 5, 8])
def test_many_wedges_at_one_point(count):
    turn = 2.0 * np.pi * np.arange(count) / count
    wedge = [
        np.array([(0.0, 0.0), (np.cos(t - 0.1), np.sin(t - 0.1)), (np.cos(t + 0.1), np.sin(t + 0.1))])
        for t in turn
    ]
    lines = noded(lines_of(*(np.rint(5000 * each) for each in wedge)))
    assert np.all(passes(lines) == 2)
    assert inside(lines, [100.3 * each[1:].mean(axis=0) for each in wedge]).all()


@pytest.mark.parametrize("width", [1, 2, 5])
def test_wedges_however_narrow(width):
    lines = noded(
        lines_of(
            [(0, 0), (200_000, -width), (200_000, width)], [(0, 0), (-200_000, width), (-200_000, 90_000)]
        )
    )
    assert np.all(passes(lines) == 2)
    assert inside(lines, [(-150_000.5, 30_000.5)])[0]
