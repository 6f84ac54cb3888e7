import numpy as np
import pytest

from core.diagnosis.branches import LEAST_GAP, branch_gaps
from core.refine.polyline import Polyline
from core.truth import point_set
from tests.core.shapes import in_space

SIGMA = 0.01


def ring(radius=1.0, centre=(0.0, 0.0), count=400):
    angle = np.arange(count) * 2 * np.pi / count
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle))) + centre), True)


def stick(start, end, count=50):
    return Polyline(in_space(np.linspace(start, end, count)), False)


def hairpin(gap):
    """Two parallel strokes joined by a half circle of diameter ``gap``."""
    bend = np.linspace(-np.pi / 2, np.pi / 2, 30)
    turn = np.column_stack((gap / 2 * np.cos(bend), gap / 2 * np.sin(bend)))
    back, there = np.linspace((-1.0, -gap / 2), turn[0], 200), np.linspace(turn[-1], (-1.0, gap / 2), 200)
    return Polyline(in_space(np.concatenate((back[:-1], turn, there[1:]))), False)


@pytest.mark.parametrize("gap", [0.03, 0.1, 0.2])
def test_the_distance_between_two_curves(gap):
    gaps = branch_gaps([ring(), ring(1.0 - gap)], SIGMA)
    place, distance = gaps[0]
    assert distance == pytest.approx(gap, rel=0.05)
    assert np.linalg.norm(place) == pytest.approx(1.0 - gap / 2, abs=0.02)


@pytest.mark.parametrize("gap", [0.04, 0.1])
def test_the_distance_between_branches_of_one_curve(gap):
    gaps = branch_gaps([hairpin(gap)], SIGMA)
    assert gaps
    assert gaps[0][1] == pytest.approx(gap, rel=0.1)


def test_neighbours_along_a_curve_are_no_branches():
    assert branch_gaps([ring()], SIGMA) == []
    assert branch_gaps([stick((0.0, 0.0), (3.0, 1.0))], SIGMA) == []
    assert branch_gaps([ring(0.2)], SIGMA) == []


@pytest.mark.parametrize("name", ["circle", "ellipse", "bean", "egg", "spiral", "wave"])
def test_smooth_curves_with_wide_branches_have_no_gap_to_report(name):
    (curve,) = point_set(name).curves
    diagonal = np.linalg.norm(np.ptp(curve.vertices, axis=0))
    line = Polyline(in_space(curve.exact.polyline(500)), curve.closed)
    assert branch_gaps([line], 0.002 * diagonal) == []


def test_it_looks_as_far_as_told():
    curves = [stick((0.0, 0.0), (1.0, 0.0)), stick((0.0, 0.2), (1.0, 0.2))]
    assert branch_gaps(curves, SIGMA, look=15.0) == []
    assert branch_gaps(curves, SIGMA, look=25.0)[0][1] == pytest.approx(0.2)


def test_the_closest_comes_first_and_one_stretch_counts_once():
    bars = [stick((0.0, 0.0), (1.0, 0.0)), stick((0.0, 0.05), (1.0, 0.05)), stick((0.0, -0.12), (1.0, -0.12))]
    gaps = branch_gaps(bars, SIGMA)
    distances = [distance for _, distance in gaps]
    assert distances == sorted(distances)
    assert distances[0] == pytest.approx(0.05)
    # A place stands for all within ten sigma of it.
    places = np.array([place for place, _ in gaps])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(places), 1)]
    assert np.all(apart > 5 * SIGMA)


def test_the_unit_does_not_matter():
    for factor in (1e-6, 1e6):
        curves = [Polyline(factor * c.vertices, c.closed) for c in (ring(), ring(0.9))]
        assert branch_gaps(curves, factor * SIGMA)[0][1] == pytest.approx(0.1 * factor, rel=0.05)


def test_without_curves_or_noise_there_is_nothing_to_compare():
    assert branch_gaps([], SIGMA) == []
    assert branch_gaps([ring()], 0.0) == []
    assert branch_gaps([ring()], float("nan")) == []


def test_noise_up_to_two_sigma_stays_on_its_own_side():
    assert LEAST_GAP >= 2 * 2.0


@pytest.mark.parametrize("sigma", [1e-12, 1e-3, 1e3, 1e12])
def test_any_noise_is_answered_in_time(sigma):
    gaps = branch_gaps([ring(), ring(0.5)], sigma)
    assert len(gaps) <= 20
    assert all(np.isfinite(place).all() and distance > 0 for place, distance in gaps)
