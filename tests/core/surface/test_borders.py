import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.borders import Borders, signed_distances
from core.surface.linework import linework_of
from tests.core.surface.contours import inside


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_signed_distances_are_those_of_all_edges(seed):
    rng = np.random.default_rng(seed)
    loops = [rng.integers(-50, 50, (size, 2)) for size in rng.integers(3, 40, 8)]
    lines = linework_of(loops, rng.integers(0, 4, 8).tolist())
    xy = rng.uniform(-80.0, 80.0, (60, 2))
    level = rng.integers(0, 5, 60)
    found = signed_distances(xy, level, Borders.of(lines))
    for k in range(5):
        mine = level == k
        sides = shapely.multilinestrings(shapely.linestrings(lines.ends[lines.level == k].astype(float)))
        expected = shapely.distance(sides, shapely.points(xy[mine]))
        expected = np.where(np.isnan(expected), np.inf, expected)
        expected = np.where(inside(lines, xy[mine], k), expected, -expected)
        assert found[mine] == pytest.approx(expected, rel=1e-9)


def test_signed_distances_of_a_square():
    lines = linework_of([np.array([(0, 0), (10, 0), (10, 10), (0, 10)])], [1])
    xy = np.array([(5.0, 5.0), (1.0, 5.0), (-3.0, 5.0), (13.0, 14.0), (5.0, 5.0), (5.0, 5.0)])
    level = np.array([1, 1, 1, 1, 0, -1])
    found = signed_distances(xy, level, Borders.of(lines))
    assert found.tolist() == [5.0, 1.0, -3.0, -5.0, -np.inf, -np.inf]
