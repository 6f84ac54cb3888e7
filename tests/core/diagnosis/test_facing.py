import numpy as np
import pytest

from core.diagnosis.facing import facing_ends
from core.refine.polyline import Polyline
from tests.core.diagnosis.drawings import ring
from tests.core.shapes import in_space


def bars(gap, turn=0.0):
    """Two bars of length 100 in line, or the second one turned."""
    x = np.linspace(0.0, 100.0, 200)
    one = np.column_stack((x - 100.0 - gap / 2, 0 * x))
    other = np.column_stack((np.cos(turn) * x + gap / 2, np.sin(turn) * x))
    return [Polyline(in_space(one), False), Polyline(in_space(other), False)]


def test_ends_over_a_gap_face_each_other():
    (found,) = facing_ends(bars(20.0), [100, 100], 0.1, 200)
    assert found.gap == pytest.approx(20.0)
    assert found.spacings == pytest.approx(20.0)
    np.testing.assert_allclose(found.place, 0.0, atol=1e-9)


@pytest.mark.parametrize("gap", [2.0, 80.0])
def test_chance_leaves_short_gaps_and_far_ends_are_ends(gap):
    assert facing_ends(bars(gap), [100, 100], 0.1, 200) == []


def test_ends_that_look_elsewhere_do_not_face_each_other():
    assert facing_ends(bars(20.0, np.radians(70.0)), [100, 100], 0.1, 200) == []


def test_closed_curves_have_no_ends():
    assert facing_ends([ring(1.0), ring(2.0)], [100, 100], 0.1, 200) == []


def test_an_arc_faces_itself():
    angle = np.linspace(0.2, 2 * np.pi, 300)
    arc = Polyline(in_space(np.column_stack((np.cos(angle), np.sin(angle)))), False)
    (found,) = facing_ends([arc], [600], 0.005, 600)
    assert found.gap == pytest.approx(2 * np.sin(0.1), rel=0.01)
