import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.polyline import Polyline
from tests.core.shapes import arc, distances, in_space

SQUARE = in_space(np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float))


def random_line(seed, closed):
    rng = np.random.default_rng(seed)
    return Polyline(np.cumsum(rng.normal(size=(rng.integers(3, 12), 3)), axis=0), closed)


def test_the_closing_edge_counts():
    assert Polyline(SQUARE, True).length == pytest.approx(4.0)
    assert Polyline(SQUARE, False).length == pytest.approx(3.0)
    np.testing.assert_allclose(Polyline(SQUARE, True).stations, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(Polyline(SQUARE, False).stations, [0, 1, 2, 3])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_segments_are_consecutive_and_as_long_as_the_line(seed, closed):
    line = random_line(seed, closed)
    heads, tails = line.segments()
    np.testing.assert_array_equal(tails[:-1], heads[1:])
    assert len(heads) == len(line.vertices) - (not closed)
    assert np.linalg.norm(tails - heads, axis=1).sum() == pytest.approx(line.length)
    assert np.array_equal(tails[-1], heads[0]) == closed


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_arc_length_leads_to_the_vertices(seed, closed):
    line = random_line(seed, closed)
    np.testing.assert_allclose(line.at(line.stations[: len(line.vertices)]), line.vertices, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-20.0, 20.0))
def test_a_closed_line_is_periodic(seed, s):
    line = random_line(seed, True)
    turns = s + np.arange(-2, 3) * line.length
    np.testing.assert_allclose(line.at(turns), np.tile(line.at(np.array([s])), (5, 1)), atol=1e-9)


def test_an_open_line_ends_at_its_ends():
    line = Polyline(SQUARE, False)
    np.testing.assert_array_equal(line.at(np.array([-1.0, 9.0])), SQUARE[[0, -1]])


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.floats(0.001, 0.3))
def test_resampling_stays_on_the_course(seed, closed, share):
    line = random_line(seed, closed)
    spacing = share * line.length
    fine = line.resampled(spacing)
    assert fine.closed == closed
    assert distances(fine.vertices, line.vertices, closed).max() < 1e-9 * line.length
    if not closed:
        np.testing.assert_allclose(fine.vertices[[0, -1]], line.vertices[[0, -1]], atol=1e-12)
    # Equidistant along the line: chords are no longer than the wished spacing, corners are cut.
    steps = np.linalg.norm(np.diff(fine.ring, axis=0), axis=1)
    assert steps.max() <= spacing * (1 + 1e-9)
    assert fine.length <= line.length * (1 + 1e-12)
    assert len(steps) * spacing < line.length + 8 * spacing + 1e-9


def test_resampling_a_smooth_line_keeps_its_length():
    angle = np.arange(500) * 2 * np.pi / 500
    circle = Polyline(in_space(np.column_stack((np.cos(angle), np.sin(angle)))), True)
    for spacing in (0.02, 0.05, 0.1):
        assert circle.resampled(spacing).length == pytest.approx(2 * np.pi, rel=spacing**2)


def test_resampling_has_at_least_the_number_of_pieces_asked_for():
    line = Polyline(SQUARE, False)
    assert len(line.resampled(100.0, 3).vertices) == 4
    assert len(Polyline(SQUARE, True).resampled(100.0, 3).vertices) == 3


def test_the_order_of_vertices_is_the_direction():
    line = Polyline(in_space(arc(10, 0.1)), False)
    back = Polyline(line.vertices[::-1], False)
    s = np.linspace(0, line.length, 7)
    np.testing.assert_allclose(back.at(line.length - s), line.at(s), atol=1e-12)
