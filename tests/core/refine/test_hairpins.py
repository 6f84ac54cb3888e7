import numpy as np
import pytest

from core.refine.hairpins import hairpins, without
from core.refine.polyline import Polyline
from tests.core.shapes import in_space

SIGMA = 0.02


def hairpin(gap, turns=1):
    """Straight branches side by side, joined by half circles."""
    u = np.linspace(-np.pi / 2, np.pi / 2, 40)
    pieces = []
    for k in range(turns + 1):
        x = np.linspace(0.0, 2.0, 200)[:: 1 if k % 2 == 0 else -1]
        pieces.append(np.column_stack([x, np.full(200, k * gap)]))
        if k < turns:
            end = 2.0 if k % 2 == 0 else 0.0
            side = 1.0 if k % 2 == 0 else -1.0
            arc = np.column_stack([end + side * gap / 2 * np.cos(u), (k + 0.5) * gap + gap / 2 * np.sin(u)])
            pieces.append(arc)
    return Polyline(in_space(np.concatenate(pieces)), False)


@pytest.mark.parametrize("sigmas", [4.0, 6.0])
@pytest.mark.parametrize("turns", [1, 2, 3])
def test_each_hairpin_is_found_in_its_middle(sigmas, turns):
    gap = sigmas * SIGMA
    line = hairpin(gap, turns)
    half = np.pi * gap / 2
    middles = [2.0 * (k + 1) + half * (k + 0.5) for k in range(turns)]
    assert hairpins(line, SIGMA) == pytest.approx(middles, abs=2.0 * SIGMA)


@pytest.mark.parametrize("radius", [0.4, 1.0, 5.0])
def test_wide_turns_are_no_hairpins(radius):
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    circle = in_space(radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    assert hairpins(Polyline(circle, True), SIGMA) == []
    assert hairpins(Polyline(circle[:200], False), SIGMA) == []


@pytest.mark.parametrize("degrees", [15.0, 25.0, 36.0])
def test_sharp_tips_are_no_hairpins(degrees):
    half = np.radians(degrees / 2)
    sides = np.array([[np.cos(half), np.sin(half)], [0.0, 0.0], [np.cos(half), -np.sin(half)]])
    assert hairpins(Polyline(in_space(sides), False), 0.01) == []


def test_corners_are_no_hairpins():
    square = Polyline(in_space(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])), True)
    assert hairpins(square, 0.01) == []


@pytest.mark.parametrize("sigma", [0.0, 1e-300, 1e-9, 1.0])
def test_without_noise_or_in_nothing_but_noise_there_are_none(sigma):
    assert hairpins(hairpin(0.1), sigma) == []


def test_cutting_leaves_the_branches():
    line = hairpin(6 * SIGMA, 2)
    pieces = without(line, hairpins(line, SIGMA), SIGMA)
    assert [piece.closed for piece in pieces] == [False] * 3
    for k, piece in enumerate(pieces):
        assert np.abs(piece.vertices[:, 1] - 6 * k * SIGMA).max() < 0.1 * SIGMA
        assert np.ptp(piece.vertices[:, 0]) > 1.85


def test_a_ring_that_is_cut_once_is_one_open_curve():
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    ring = Polyline(in_space(np.column_stack([np.cos(angle), np.sin(angle)])), True)
    (piece,) = without(ring, [1.0], SIGMA)
    assert not piece.closed
    assert piece.length == pytest.approx(ring.length - 10 * SIGMA, rel=1e-3)
    assert without(ring, [], SIGMA) == [ring]
