import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.march.chain import MOST_SAMPLES, chain_neighbours
from tests.core.shapes import arc, in_space, line, rotation


def on_circle(n, shuffled=True, turn=2 * np.pi):
    angle = np.linspace(0.0, turn, n, endpoint=turn < 6.28)
    points = in_space(np.column_stack((np.cos(angle), np.sin(angle))))
    return np.random.default_rng(n).permutation(points) if shuffled else points


@pytest.mark.parametrize("n", [8, 12, 40, 200])
def test_even_samples_of_a_circle_are_linked_once_around(n):
    (curve,) = chain_neighbours(on_circle(n))
    assert curve.closed
    assert len(curve.vertices) == n
    assert curve.length == pytest.approx(2 * n * np.sin(np.pi / n))


@pytest.mark.parametrize("turn", [1.0, 4.0])
def test_even_samples_of_an_arc_are_linked_from_end_to_end(turn):
    (curve,) = chain_neighbours(on_circle(30, turn=turn))
    assert not curve.closed
    assert curve.length == pytest.approx(2 * 29 * np.sin(turn / 58))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_every_sample_is_a_vertex_once_in_any_frame(seed):
    rng = np.random.default_rng(seed)
    points = 10.0 ** rng.integers(-6, 7) * (on_circle(25) @ rotation(rng, 3).T + rng.normal(size=3))
    (curve,) = chain_neighbours(points)
    assert sorted(map(tuple, curve.vertices.tolist())) == sorted(map(tuple, points.tolist()))


def test_repeated_samples_count_once():
    (curve,) = chain_neighbours(np.repeat(on_circle(20), 3, axis=0))
    assert len(curve.vertices) == 20


def test_two_chains():
    far = on_circle(20)
    curves = chain_neighbours(np.concatenate((far, on_circle(30, turn=4.0) + np.array([5.0, 0.0, 0.0]))))
    assert sorted(c.closed for c in curves) == [False, True]


@pytest.mark.parametrize("seed", range(5))
def test_noise_makes_no_chain(seed):
    rng = np.random.default_rng(seed)
    assert chain_neighbours(in_space(rng.normal(size=(100, 2)))) is None
    assert chain_neighbours(in_space(arc(300, 0.05, seed=seed))) is None
    assert chain_neighbours(in_space(line(200, 0.05, seed=seed))) is None


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_too_few_samples_make_no_chain(n):
    assert chain_neighbours(on_circle(max(n, 2), turn=1.0)[:n]) is None


def test_many_samples_are_not_for_chains():
    assert chain_neighbours(on_circle(MOST_SAMPLES + 1)) is None


def test_coincident_samples_make_no_chain():
    assert chain_neighbours(np.ones((30, 3))) is None
