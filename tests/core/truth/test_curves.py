import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe

from core.truth.crossing_families import CROSSING
from core.truth.curves import Term, bezier, chain, cos, harmonic, polar, polygon, power, sin, spline
from core.truth.families import BUILT_IN
from core.truth.held_out import HELD_OUT
from core.truth.held_out_crossings import HELD_OUT_CROSSING

TURN = (0.0, 2 * np.pi)
FAMILIES = (*BUILT_IN, *CROSSING, *HELD_OUT, *HELD_OUT_CROSSING)
CURVES = [(one.name, curve) for one in FAMILIES for curve in one.build(0)]
every_curve = pytest.mark.parametrize("curve", [c for _, c in CURVES], ids=[name for name, _ in CURVES])


def circle(radius=1.0):
    return harmonic([cos(radius)], [sin(radius)], interval=TURN, closed=True)


def test_length_of_a_circle_is_its_circumference():
    assert circle(3.0).length == pytest.approx(6 * np.pi, rel=1e-12)


def test_length_of_an_ellipse_is_the_complete_elliptic_integral():
    ellipse = harmonic([cos(2.5)], [sin(1.0)], interval=TURN, closed=True)
    assert ellipse.length == pytest.approx(4 * 2.5 * ellipe(1 - 1 / 2.5**2), rel=1e-12)


def test_length_of_a_helix_is_that_of_its_unrolled_line():
    helix = harmonic([cos(1.0)], [sin(1.0)], [power(0.5, 1)], interval=(0, 6 * np.pi), closed=False)
    assert helix.length == pytest.approx(6 * np.pi * np.hypot(1, 0.5), rel=1e-12)


def test_length_of_a_parabola_has_a_closed_form():
    parabola = harmonic([power(1.0, 1)], [power(1.0, 2)], interval=(-1.0, 1.0), closed=False)
    assert parabola.length == pytest.approx(np.sqrt(5) + np.arcsinh(2) / 2, rel=1e-12)


def test_a_polar_curve_lies_at_its_radius():
    t = np.linspace(0, 1, 50)
    radius = np.linalg.norm(polar([power(1.0), cos(0.4)], TURN, closed=True).evaluate(t), axis=1)
    np.testing.assert_allclose(radius, 1 + 0.4 * np.cos(2 * np.pi * t), rtol=1e-13)


def test_a_spiral_recedes_by_the_same_pitch_every_turn():
    spiral = polar([power(0.7, 1)], (1.0, 1.0 + 4 * np.pi), closed=False)
    np.testing.assert_allclose(np.diff(np.linalg.norm(spiral.evaluate([0, 0.5, 1]), axis=1)), 1.4 * np.pi)


def test_a_polygon_turns_only_at_its_vertices():
    vertices = np.array([(0, 0), (3, 0), (3, 4)], float)
    triangle = polygon(vertices, closed=True)
    assert triangle.length == pytest.approx(12.0, rel=1e-12)
    np.testing.assert_allclose(triangle.evaluate(triangle.corners), vertices, atol=1e-12)
    assert not triangle.second_derivative(np.linspace(0, 1, 17)).any()


def test_a_bezier_curve_starts_and_ends_on_its_control_polygon():
    control = np.array([(0, 0), (1, 2), (3, 3), (4, 0)], float)
    curve = bezier(control, closed=False)
    np.testing.assert_allclose(curve.evaluate([0.0, 1.0]), control[[0, -1]], atol=1e-14)
    np.testing.assert_allclose(
        curve.derivative(np.array([0.0, 1.0]), 1), 3 * np.diff(control, axis=0)[[0, -1]]
    )


def test_a_closed_spline_is_smooth_across_its_seam():
    angle = np.arange(7) * 2 * np.pi / 7
    curve = spline(np.column_stack((np.cos(angle), 2 * np.sin(angle))), closed=True)
    for order in range(3):
        start, end = curve.derivative(np.array([0.0, 1.0]), order)
        np.testing.assert_allclose(start, end, atol=1e-9)


@given(
    amplitude=st.floats(-3, 3),
    frequency=st.floats(-4, 4),
    phase=st.floats(-4, 4),
    exponent=st.integers(0, 3),
)
def test_the_derivative_of_a_term_is_its_rate_of_change(amplitude, frequency, phase, exponent):
    term, t, h = Term(amplitude, frequency, phase, exponent), np.linspace(0.1, 2, 9), 1e-5
    rate = (term(t + h) - term(t - h)) / (2 * h)
    exact = sum((one(t) for one in term.derivative()), np.zeros_like(t))
    np.testing.assert_allclose(exact, rate, atol=1e-6)


@every_curve
def test_derivatives_agree_with_differences(curve):
    u, h = np.linspace(0.013, 0.987, 40), 1e-5
    for order in (0, 1):
        rate = (curve.derivative(u + h, order) - curve.derivative(u - h, order)) / (2 * h)
        exact = curve.derivative(u, order + 1)
        np.testing.assert_allclose(exact, rate, atol=1e-6 * (1 + np.abs(exact).max()))


@every_curve
def test_closed_curves_close_and_open_ones_do_not(curve):
    start, end = curve.evaluate([0.0, 1.0])
    assert (np.linalg.norm(start - end) < 1e-9 * curve.length) == curve.closed


@every_curve
def test_equal_fractions_are_equal_ways(curve):
    vertices = curve.at(np.linspace(0, 1, 20001))
    steps = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    assert steps.sum() == pytest.approx(curve.length, rel=1e-6)
    turning = steps < (1 - 1e-4) * curve.length / 20000  # a step across a corner is a short cut
    assert turning.sum() <= len(curve.corners)
    assert steps.max() < (1 + 1e-5) * curve.length / 20000


@every_curve
def test_fraction_inverts_parameter(curve):
    fraction = np.linspace(0, 1, 101)
    np.testing.assert_allclose(curve.fraction(curve.parameter(fraction)), fraction, atol=1e-6)


@every_curve
def test_tangents_have_unit_length_and_point_ahead(curve):
    u = np.linspace(0.013, 0.987, 40)
    tangent = curve.tangent(u)
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, rtol=1e-12)
    assert np.all(np.sum(tangent * (curve.evaluate(u + 1e-6) - curve.evaluate(u)), axis=1) > 0)


def test_curvature_of_a_circle_is_the_inverse_of_its_radius():
    np.testing.assert_allclose(circle(4.0).curvature(np.linspace(0, 1, 11)), 0.25, rtol=1e-12)


def test_a_rigid_motion_keeps_lengths_and_curvatures():
    flat, lift = circle(2.0), np.array([(0.6, 0.0), (0.8, 0.0), (0.0, 1.0)])
    moved = flat.moved(lift, [5.0, 6.0, 7.0])
    assert moved.length == pytest.approx(flat.length, rel=1e-12)
    np.testing.assert_allclose(moved.curvature([0.1, 0.7]), 0.5, rtol=1e-12)
    np.testing.assert_allclose(moved.polyline(64).mean(axis=0), [5.0, 6.0, 7.0], atol=1e-12)


def test_a_polyline_holds_the_corners_and_does_not_repeat_the_first_vertex():
    square = polygon([(0, 0), (1, 0), (1, 1), (0, 1)], closed=True)
    vertices = square.polyline(10)  # no multiple of four: the corners are extra
    for corner in [(0, 0), (1, 0), (1, 1), (0, 1)]:
        assert np.min(np.linalg.norm(vertices - corner, axis=1)) < 1e-12
    assert np.linalg.norm(vertices[0] - vertices[-1]) > 0.01


def test_a_chain_of_half_circles_is_a_circle():
    def half(first):
        return harmonic([cos(1.0)], [sin(1.0)], interval=(first, first + np.pi), closed=False)

    whole = chain([half(0.0), half(np.pi)], closed=True)
    assert whole.corners == ()
    assert whole.length == pytest.approx(2 * np.pi, rel=1e-12)
    np.testing.assert_allclose(whole.curvature(np.linspace(0, 1, 33)), 1.0, rtol=1e-9)


def test_a_chain_has_corners_where_its_tangent_jumps():
    def side(start, end):
        return polygon([start, end], closed=False)

    sides = [side((0, 0), (1, 0)), side((1, 0), (3, 0)), side((3, 0), (3, 1))]
    line = chain(sides, closed=False)
    assert line.corners == pytest.approx((0.75,))
    np.testing.assert_allclose(line.evaluate([0.0, 0.25, 0.75, 1.0]), [(0, 0), (1, 0), (3, 0), (3, 1)])
    assert chain([*sides, side((3, 1), (0, 0))], closed=True).corners[0] == 0.0
