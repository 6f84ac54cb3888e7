import numpy as np
import pytest

from core.errors import DegenerateInput, InvalidInput
from core.results import Curve
from core.surface.linework import Grid
from core.surface.regions import regions_of
from tests.core.surface.contours import ring, square, stack

AXES = np.eye(3)


def open_ring(share, count=100):
    """A circle of which a share of the turn is missing."""
    turn = 2.0 * np.pi * (1.0 - share) * np.arange(count) / (count - 1)
    vertices = np.column_stack((np.cos(turn), np.sin(turn)))
    length = float(np.hypot(*np.diff(vertices, axis=0).T).sum())
    return Curve(vertices, False, 0, length, count, 0.0)


def scaled(size):
    """A square too large to have its length computed."""
    return Curve(size * square(0, 0, 1).vertices, True, 0, 4 * size, 4, 0.0)


def test_levels_are_sorted_and_empty_ones_follow_at_both_ends():
    levels = stack([ring(1.0)], [ring(2.0)], [ring(3.0)], heights=(5.0, 1.0, 2.0))
    regions = regions_of(levels, AXES)
    assert regions.heights.tolist() == [0.0, 1.0, 2.0, 5.0, 8.0]
    assert np.unique(regions.lines.level).tolist() == [1, 2, 3]
    widths = [np.ptp(regions.lines.ends[regions.lines.level == k][..., 0]) for k in (1, 2, 3)]
    assert np.allclose(np.array(widths) * regions.grid.pitch, (4.0, 6.0, 2.0), atol=0.02)


def test_points_lie_on_the_grid_within_half_a_pitch():
    points = np.random.default_rng(0).normal(size=(100, 2)) * 7.0 + 1000.0
    grid = Grid.over(points)
    assert np.abs(grid.placed(grid.snapped(points)) - points).max() <= grid.pitch / 2
    assert np.log2(grid.pitch) % 1 == 0
    assert grid.pitch <= 2e-6 * np.ptp(points, axis=0).max()


def test_a_small_gap_is_closed_and_a_wide_one_left_out_with_a_warning():
    regions = regions_of(stack([open_ring(0.02)], [ring(1.0)]), AXES)
    assert [warning.code for warning in regions.warnings] == ["contour-closed"]
    assert np.unique(regions.lines.level).tolist() == [1, 2]
    regions = regions_of(stack([open_ring(0.3)], [ring(1.0)]), AXES)
    assert [warning.code for warning in regions.warnings] == ["open-contour"]
    assert regions.warnings[0].location[2] == 0.0
    assert np.unique(regions.lines.level).tolist() == [2]


def test_contours_in_place_are_taken_to_the_planes_axes():
    axes = np.array([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    flat = [ring(1.0), ring(2.0)]
    lifted = [
        Curve(np.column_stack((np.full(60, z), one.vertices)), True, 0, one.length, 60, 0.0)
        for z, one in enumerate(flat)
    ]
    one, other = (regions_of(stack(*([c] for c in curves)), axes) for curves in (flat, lifted))
    assert np.array_equal(one.lines.ends, other.lines.ends)


def test_what_determines_no_surface():
    for levels in (stack([ring(1.0)]), stack([], []), stack([open_ring(0.5)], [])):
        with pytest.raises(DegenerateInput):
            regions_of(levels, AXES)
    with pytest.raises(InvalidInput, match="heights"):
        regions_of(stack([ring(1.0)], [ring(1.0)], heights=(1.0, 1.0)), AXES)
    with pytest.raises(InvalidInput):
        regions_of(stack([scaled(1e200)], [scaled(1e200)]), AXES)
