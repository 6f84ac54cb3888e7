import numpy as np

from core.diagnosis.turns import sharp_turns
from core.refine.polyline import Polyline
from tests.core.diagnosis.drawings import around, beside
from tests.core.shapes import in_space


def test_gentle_curves_have_no_sharp_turns():
    for radius in (4.0, 10.0, 50.0):
        assert sharp_turns(around(radius, 2000, 1.0, 1)) == []


def test_a_bump_that_the_curve_passes_by_is_told_where_it_is():
    rng = np.random.default_rng(0)
    x = rng.uniform(0.0, 300.0, 6000)
    y = rng.normal(size=6000) + 2.0 * np.exp(-0.5 * ((x - 100.0) / 2.0) ** 2)
    (turn,) = sharp_turns(beside(x, y, sigma=1.0))
    assert abs(turn.station - 100.0) < 3.0
    assert 1.0 < turn.height < 4.5


def test_a_corner_is_no_turn():
    side = np.linspace(0.0, 100.0, 200)
    corner = np.concatenate(
        (np.column_stack((side, 0 * side)), np.column_stack((0 * side[1:] + 100.0, side[1:])))
    )
    rng = np.random.default_rng(2)
    points = corner[rng.integers(0, len(corner), 3000)] + rng.normal(size=(3000, 2))
    line = Polyline(in_space(corner), False)
    assert sharp_turns(beside(*points.T, sigma=1.0, line=line)) == []


def test_without_noise_nothing_is_too_sharp():
    x = np.linspace(0.0, 100.0, 500)
    assert sharp_turns(beside(x, 0 * x, sigma=0.0)) == []
