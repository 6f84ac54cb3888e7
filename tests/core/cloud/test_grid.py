import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cloud.grid import build_grid, cell_range


def scattered(seed, flat=False):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(rng.integers(1, 200), 3)) * 10.0 ** rng.integers(-3, 4)
    if flat:
        points[:, 2] = 0.0
    return points


def cells_of(grid):
    """Index triples of the cell in which the grid keeps each of its points."""
    number = np.repeat(np.arange(len(grid.starts) - 1), np.diff(grid.starts))
    return np.column_stack(np.unravel_index(number, grid.shape))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 3.0), st.booleans())
def test_every_point_is_in_the_cell_that_its_coordinates_say(seed, cell, flat):
    points = scattered(seed, flat)
    grid = build_grid(points, cell * max(float(np.ptp(points)), 1e-3))
    np.testing.assert_array_equal(np.sort(grid.order), np.arange(len(points)))
    np.testing.assert_array_equal(grid.points, points[grid.order])
    assert grid.starts[0] == 0
    assert grid.starts[-1] == len(points)
    low = grid.origin + cells_of(grid) * grid.cell
    slack = 1e-9 * grid.cell
    assert np.all(grid.points >= low - slack)
    assert np.all(grid.points <= low + grid.cell + slack)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 1.0))
def test_the_cells_over_a_box_hold_every_point_in_the_box(seed, cell):
    points = scattered(seed)
    size = max(float(np.ptp(points)), 1e-3)
    grid = build_grid(points, cell * size)
    rng = np.random.default_rng(seed)
    corners = np.sort(rng.normal(scale=size / 2, size=(2, 3)) + points.mean(axis=0), axis=0)
    ranges = [
        cell_range(corners[0, k], corners[1, k], grid.origin[k], grid.cell, grid.shape[k]) for k in range(3)
    ]
    here = cells_of(grid)
    visited = np.all(
        [(first <= i) & (i <= last) for (first, last), i in zip(ranges, here.T, strict=True)], axis=0
    )
    inside = np.all((grid.points >= corners[0]) & (grid.points <= corners[1]), axis=1)
    assert np.all(visited[inside])


def test_a_range_beside_the_grid_is_empty():
    first, last = cell_range(10.0, 11.0, 0.0, 1.0, 5)
    assert last < first
    first, last = cell_range(-3.0, -2.0, 0.0, 1.0, 5)
    assert last < first


def test_a_range_over_the_whole_grid_is_all_of_it():
    assert cell_range(-1e9, 1e9, 0.0, 1.0, 5) == (0, 4)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("extent", [1e3, 1e9, 1e15])
def test_a_huge_extent_costs_no_memory(extent, dimension):
    rng = np.random.default_rng(0)
    points = np.zeros((500, 3))
    points[:, :dimension] = rng.uniform(0.0, extent, size=(500, dimension))
    grid = build_grid(points, 1e-3)
    assert len(grid.starts) < 10_000
    assert grid.cell >= 1e-3


@pytest.mark.parametrize("far", [1e6, 1e12])
def test_one_stray_point_costs_no_memory(far):
    points = np.zeros((100, 3))
    points[:, 0] = np.linspace(0.0, 1.0, 100)
    points[-1] = far
    grid = build_grid(points, 0.01)
    assert len(grid.starts) < 10_000
    np.testing.assert_array_equal(np.sort(grid.order), np.arange(100))


def test_the_wished_cell_is_taken_where_it_is_affordable():
    points = np.random.default_rng(0).uniform(size=(1000, 3)) * [1, 1, 0]
    grid = build_grid(points, 0.1)
    assert grid.cell == 0.1
    assert grid.shape.tolist() == [10, 10, 1]


def test_coincident_points_share_one_cell():
    grid = build_grid(np.full((20, 3), 7.0), 0.5)
    assert grid.starts.tolist() == [0, 20]
    assert grid.shape.tolist() == [1, 1, 1]
