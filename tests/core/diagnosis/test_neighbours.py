import numpy as np
import pytest

from core.diagnosis.neighbours import approaches
from core.methods import diagnose
from core.refine.polyline import Polyline
from tests.core.diagnosis.drawings import ring
from tests.core.shapes import in_space


def bar(start, end):
    return Polyline(in_space(np.linspace(start, end, 50)), False)


@pytest.mark.parametrize("gap", [3.0, 12.0])
def test_the_distance_of_two_components(gap):
    found = approaches([ring(50.0), ring(50.0 + gap)], [0, 1], [1.0, 1.0])
    assert found[0].gap == pytest.approx(gap, rel=0.05)
    assert np.linalg.norm(found[0].place) == pytest.approx(50.0 + gap / 2, abs=0.5)


def test_curves_of_one_component_are_not_compared():
    assert approaches([ring(50.0), ring(53.0)], [0, 0], [1.0, 1.0]) == []


def test_the_larger_noise_counts():
    (found, *_) = approaches([ring(50.0), ring(58.0)], [0, 1], [0.1, 2.0])
    assert found.sigma == 2.0


def test_ends_in_line_are_a_gap_rather_than_branches():
    in_line = [bar((0.0, 0.0), (50.0, 0.0)), bar((55.0, 0.0), (100.0, 0.0))]
    assert all(each.gap > 5.5 for each in approaches(in_line, [0, 1], [1.0, 1.0]))
    beside = [bar((0.0, 0.0), (50.0, 0.0)), bar((0.0, 5.0), (50.0, 5.0))]
    assert approaches(beside, [0, 1], [1.0, 1.0])[0].gap == pytest.approx(5.0, rel=0.05)


def test_without_noise_nothing_is_near():
    assert approaches([ring(50.0), ring(53.0)], [0, 1], [0.0, 0.0]) == []
    assert approaches([], [], []) == []


def test_components_count_for_the_margin():
    rng = np.random.default_rng(0)
    angle, radius = rng.uniform(0.0, 2 * np.pi, 4000), rng.choice([100.0, 112.0], 4000)
    points = np.column_stack((radius * np.cos(angle), radius * np.sin(angle))) + rng.normal(size=(4000, 2))
    sampling = diagnose(points).sampling
    assert len(sampling.components) == 2
    assert sampling.nyquist.compliant
    assert sampling.nyquist.margin_sigmas == pytest.approx(12.0, rel=0.1)
    assert np.linalg.norm(sampling.nyquist.margin_location) == pytest.approx(106.0, abs=2.0)
