import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.borders import Borders
from core.surface.inner_points import inner_points
from core.surface.noding import noded
from core.surface.overlay import slab_ends
from core.surface.regions import regions_of
from core.truth.stacks import random_stack
from tests.core.surface.contours import inside, ring, stack


def found(levels):
    regions = regions_of(levels, np.eye(3))
    lines = noded(regions.lines)
    slabs = slab_ends(lines, regions.heights)
    return lines, slabs, inner_points(lines, Borders.of(lines), slabs, regions.grid.pitch)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_they_lie_where_one_region_only_is_solid(seed):
    lines, slabs, points = found(random_stack(seed))
    assert sum(map(len, points)) <= 2 * len(lines)
    for slab, mine in zip(slabs, points, strict=True):
        places = np.add(mine, (0.003, 0.001))  # off the heights of vertices
        assert np.all(inside(lines, places, slab.levels[0]) != inside(lines, places, slab.levels[1]))


def test_narrow_sheets_get_none_and_caps_do():
    _, _, points = found(stack([ring(10.0)], [ring(9.9)], [ring(9.8)]))
    assert [len(mine) > 0 for mine in points] == [True, False, False, True]


def test_a_flange_has_them_nearer_to_its_borders_than_its_contours_are_fine():
    lines, _, points = found(stack(*([ring(radius, count=64)] for radius in (20.0, 20.0, 40.0, 40.0))))
    assert [len(mine) > 0 for mine in points] == [True, False, True, False, True]
    radius = np.ptp(lines.ends.reshape(-1, 2), axis=0).max() / 2.0  # in grid units
    centre = lines.ends.reshape(-1, 2).mean(axis=0)
    away = 40.0 / radius * np.linalg.norm(points[2] - centre, axis=1)
    assert np.minimum(away - 20.0, 40.0 - away).min() < 6.0  # three edges are 12 long
