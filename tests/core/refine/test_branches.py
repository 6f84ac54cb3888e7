import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.branches import near_branches
from core.refine.polyline import Polyline
from tests.core.shapes import in_space, rotation

SIGMA, CUT = 0.01, 4.0


def found(*lines, sigma=SIGMA):
    return near_branches(lines, np.full(len(lines), sigma), CUT)


def straight(y=0.0, angle=0.0, half=0.5):
    way = np.linspace(-half, half, 60)
    return Polyline(in_space(np.column_stack((way * np.cos(angle), y + way * np.sin(angle)))), False)


def ring(radius, count=300):
    angle = 2 * np.pi * np.arange(count) / count
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), True)


def figure_8(count=800):
    t = 2 * np.pi * np.arange(count) / count
    return Polyline(in_space(np.column_stack((np.cos(t), 0.5 * np.sin(2 * t)))), True)


def hairpin(gap, leg=0.5):
    """Two legs and the half circle that joins them."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, 60)
    way = np.linspace(-leg, 0.0, 60, endpoint=False)
    low = np.column_stack((way, np.full(60, -gap / 2)))
    bend = gap / 2 * np.column_stack((np.cos(turn), np.sin(turn)))
    return Polyline(in_space(np.concatenate((low, bend, low[::-1] * (1, -1)))), False)


@pytest.mark.parametrize("gap", [0.0, 2.0, 5.0, 7.9])
def test_curves_within_twice_the_cut_are_near(gap):
    assert found(straight(), straight(gap * SIGMA)) is not None
    assert found(ring(1.0), ring(1.0 + gap * SIGMA)) is not None
    assert found(hairpin(max(gap, 2.0) * SIGMA)) is not None


@pytest.mark.parametrize("gap", [11.0, 20.0])
def test_curves_farther_apart_are_not(gap):
    assert found(straight(), straight(gap * SIGMA)) is None
    assert found(ring(1.0), ring(1.0 + gap * SIGMA)) is None
    assert found(hairpin(gap * SIGMA)) is None


@pytest.mark.parametrize("radius", [0.1, 0.3, 1.0])
def test_a_circle_has_one_branch(radius):
    assert found(ring(radius)) is None


@pytest.mark.parametrize("angle", [0.1, 0.5, np.pi / 2])
def test_nodes_about_a_crossing_know_each_other(angle):
    branches = found(straight(), straight(angle=angle))
    some = np.diff(branches.starts) > 0
    away = np.linalg.norm(branches.place, axis=1)
    apart = 2 * away * np.sin(angle / 2)
    assert np.all(some[apart < 8.0 * SIGMA])
    assert not np.any(some[away * np.sin(angle) > 10.0 * SIGMA])
    np.testing.assert_allclose(branches.nearest[~some], np.inf)


def test_only_the_crossing_of_a_curve_with_itself_is_found():
    branches = found(figure_8())
    some = np.diff(branches.starts) > 0
    away = np.linalg.norm(branches.place, axis=1)
    assert some[away < 5.0 * SIGMA].all()
    assert not some[away > 10.0 * SIGMA].any()


def test_partners_are_mutual():
    branches = found(figure_8(), straight(0.02))
    own = np.repeat(np.arange(len(branches.place)), np.diff(branches.starts))
    pairs = set(zip(own.tolist(), branches.partners.tolist(), strict=True))
    assert pairs
    assert pairs == {(j, i) for i, j in pairs}


def test_without_noise_no_sample_is_in_doubt():
    assert found(straight(), straight(angle=1.0), sigma=0.0) is None


def test_a_curve_of_one_place_is_no_trouble():
    dot = Polyline(np.zeros((3, 3)), False)
    assert found(dot) is None
    branches = found(dot, straight())
    assert np.all(np.isfinite(branches.place))
    assert np.all(branches.step > 0.0)


@pytest.mark.parametrize("sigma", [1e-5, 1e-3])
def test_nodes_stay_few_when_the_noise_is_small(sigma):
    branches = found(straight(), straight(angle=0.7), sigma=sigma)
    assert len(branches.place) < 2100
    assert np.any(np.diff(branches.starts) > 0)


def meander(rng):
    """A random closed curve of a few harmonics, some of them tangled."""
    angle = np.outer(2 * np.pi * np.arange(400) / 400, np.arange(1, 5))
    waves = np.hstack((np.cos(angle), np.sin(angle)))
    return Polyline(in_space(waves @ (rng.normal(size=(8, 2)) / np.tile(np.arange(1, 5), 2)[:, None])), True)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.002, 0.05))
def test_no_place_with_another_branch_nearby_is_missed(seed, sigma):
    rng = np.random.default_rng(seed)
    curve = meander(rng)
    curve = Polyline(curve.vertices @ rotation(rng, 3).T, True)
    place, station = curve.vertices, curve.stations[:-1]
    chord = np.linalg.norm(place[:, None] - place, axis=2)
    way = np.abs(station[:, None] - station)
    way = np.minimum(way, curve.length - way)
    # Nodes are 1.5 sigma apart: their own chord and way differ by as much from those of the places.
    apart = (chord < 2 * CUT * sigma) & (way > 11.0 * sigma) & (way > 2.0 * chord + 4.5 * sigma)
    branches = found(curve, sigma=sigma)
    if branches is None:
        assert not apart.any()
        return
    node = np.rint(station / branches.step[0]).astype(int) % len(branches.place)
    assert np.all(np.diff(branches.starts)[node[apart.any(axis=1)]] > 0)
