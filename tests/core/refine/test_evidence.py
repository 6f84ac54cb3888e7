import numpy as np
import pytest

from core.refine.evidence import bending, description_length, typical_curvature
from core.refine.polyline import Polyline
from tests.core.shapes import arc, in_space, line

SIGMA = 0.02


def ring(radius=1.0, turn=2 * np.pi, centre=0.0):
    closed = turn == 2 * np.pi
    angle = np.linspace(0.0, turn, 200, endpoint=not closed)
    points = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    points[:, 0] += centre
    return Polyline(in_space(points), closed)


def nats(points, *curves, sigma=SIGMA, extent=2.0):
    return description_length(in_space(points), curves, sigma, extent, True)


def test_nothing_explains_nothing():
    assert nats(arc(100, SIGMA)) == np.inf


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_truth_beats_what_is_near_it(seed):
    points = arc(1000, SIGMA, seed=seed)
    truth = nats(points, ring())
    assert truth < nats(points, ring(1.0 + 0.5 * SIGMA))
    assert truth < nats(points, ring(1.0 - 0.5 * SIGMA))
    assert truth < nats(points, ring(turn=5.5))
    assert truth < nats(points, ring(centre=0.5 * SIGMA))


def test_a_curve_twice_is_worse_than_once():
    points = arc(1000, SIGMA)
    assert nats(points, ring()) < nats(points, ring(), ring())


def test_a_curve_in_two_pieces_is_worse_than_in_one():
    points = arc(1000, SIGMA)
    vertices = ring().vertices
    halves = Polyline(vertices[:101], False), Polyline(np.concatenate((vertices[100:], vertices[:1])), False)
    assert nats(points, ring()) < nats(points, *halves)


@pytest.mark.parametrize("gap", [0.5, 1.0])
def test_closing_over_a_true_gap_is_worse_than_leaving_it_open(gap):
    points = arc(1000, SIGMA, turn=2 * np.pi - gap)
    assert nats(points, ring(turn=2 * np.pi - gap)) < nats(points, ring())


def test_two_curves_explain_two_circles_better_than_one():
    one, two = arc(800, SIGMA, seed=1), arc(800, SIGMA, seed=2)
    two[:, 0] += 3.0
    points = np.concatenate((one, two))
    both = nats(points, ring(), ring(centre=3.0), extent=5.0)
    assert both < nats(points, ring(), extent=5.0)
    assert both < nats(points, ring(centre=3.0), extent=5.0)


def test_a_curve_through_empty_space_costs():
    points = arc(1000, SIGMA)
    stick = Polyline(in_space(np.array([(-0.8, 0.0), (0.8, 0.0)])), False)
    assert nats(points, ring()) < nats(points, ring(), stick)


def test_outliers_cost_but_do_not_forbid():
    points = arc(1000, SIGMA)
    stray = np.concatenate((points, [[0.0, 0.0], [0.3, 0.1]]))
    more = nats(stray, ring()) - nats(points, ring())
    assert 0 < more < 30


@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize(("flat", "dimension"), [(True, 2), (False, 3)])
def test_the_choice_does_not_depend_on_the_unit(factor, flat, dimension):
    points = in_space(line(500, SIGMA, dimension=dimension))
    one = Polyline(np.array([(-0.5, 0, 0), (0.5, 0, 0)]), False)
    two = Polyline(np.array([(-0.5, 0.01, 0), (0.5, -0.01, 0)]), False)

    def difference(f):
        scaled = [Polyline(f * c.vertices, False) for c in (one, two)]
        each = [description_length(f * points, [c], f * SIGMA, f * 1.0, flat) for c in scaled]
        return each[1] - each[0]

    assert difference(factor) == pytest.approx(difference(1.0), rel=1e-6)


def test_the_order_of_samples_and_curves_does_not_matter():
    points = np.concatenate((arc(300, SIGMA), arc(300, SIGMA, 2.0)))
    shuffled = np.random.default_rng(0).permutation(points)
    assert nats(shuffled, ring(2.0), ring()) == pytest.approx(nats(points, ring(), ring(2.0)))


def test_curves_of_no_length_are_judged_too():
    dot = Polyline(np.zeros((3, 3)), True)
    assert not np.isnan(nats(arc(100, SIGMA), dot))


def test_given_the_curves_their_number_and_ends_cost_nothing():
    points = in_space(arc(1000, SIGMA))
    vertices = ring().vertices
    halves = Polyline(vertices[:101], False), Polyline(np.concatenate((vertices[100:], vertices[:1])), False)
    whole = [description_length(points, curves, SIGMA, 2.0, True, True) for curves in ([ring()], halves)]
    apart = [description_length(points, curves, SIGMA, 2.0, True) for curves in ([ring()], halves)]
    assert whole[0] == pytest.approx(whole[1], abs=0.5)
    assert apart[1] - whole[1] > apart[0] - whole[0] > 0.0


def test_what_the_curves_themselves_cost_does_not_depend_on_their_course():
    points = in_space(arc(1000, SIGMA))
    costs = [
        description_length(points, [one], SIGMA, 2.0, True)
        - description_length(points, [one], SIGMA, 2.0, True, True)
        for one in (ring(), ring(1.01), ring(centre=0.1))
    ]
    assert costs == pytest.approx([costs[0]] * 3, rel=1e-9)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_given_the_curves_the_truth_still_beats_what_is_near_it(seed):
    points = in_space(arc(1000, SIGMA, seed=seed))
    truth, larger, beside = (
        description_length(points, [one], SIGMA, 2.0, True, True)
        for one in (ring(), ring(1.0 + 0.5 * SIGMA), ring(centre=0.5 * SIGMA))
    )
    assert truth < larger
    assert truth < beside


def bent(*degrees, length=10.0):
    """A polyline that turns by each angle, a length after the last, back in the plane."""
    way = np.radians(np.concatenate(([30.0], 30.0 + np.cumsum(degrees))))
    steps = length * np.column_stack((np.cos(way), np.sin(way)))
    return Polyline(in_space(np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))), False)


@pytest.mark.parametrize("radius", [0.1, 1.0, 30.0])
def test_a_circle_of_typical_curvature_costs_pi(radius):
    assert bending([ring(radius)], SIGMA * radius, 1.0 / radius) == pytest.approx(np.pi, rel=0.02)


def test_an_arc_costs_its_share_of_the_circle():
    half = bending([ring(turn=np.pi)], SIGMA, 1.0)
    assert half == pytest.approx(0.5 * np.pi, rel=0.05)


def test_a_circle_bent_twice_as_much_costs_twice_as_much():
    assert bending([ring(0.5)], SIGMA, 1.0) == pytest.approx(2.0 * np.pi, rel=0.02)


def test_a_straight_line_costs_nothing():
    assert bending([bent(0.0, 0.0)], SIGMA, 1.0) == pytest.approx(0.0, abs=1e-9)


def test_curves_add_up():
    each = [bending([one], SIGMA, 1.0) for one in (ring(), bent(40.0))]
    assert bending([ring(), bent(40.0)], SIGMA, 1.0) == pytest.approx(sum(each))
    assert bending([], SIGMA, 1.0) == 0


def test_sharper_turns_cost_more():
    costs = [bending([bent(degrees)], SIGMA, 1.0) for degrees in (0.0, 10.0, 45.0, 90.0, 150.0)]
    assert np.all(np.diff(costs) > 0.0)


def test_one_sharp_turn_costs_more_than_many_gentle_ones():
    gentle = bent(*[9.0] * 10, length=1.0)
    assert bending([gentle], SIGMA, 1.0) < bending([bent(90.0, length=5.5)], SIGMA, 1.0)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_bending_does_not_depend_on_the_unit_or_the_direction(factor):
    line = bent(20.0, -70.0, 130.0)
    scaled = Polyline(factor * line.vertices, False)
    back = Polyline(line.vertices[::-1], False)
    cost = bending([line], SIGMA, 1.0)
    assert bending([scaled], factor * SIGMA, 1.0 / factor) == pytest.approx(cost, rel=1e-6)
    assert bending([back], SIGMA, 1.0) == pytest.approx(cost, rel=1e-6)


def test_wiggles_within_the_noise_cost_less_than_beyond_it():
    x = np.linspace(0.0, 10.0, 2001)
    wiggles = Polyline(in_space(np.column_stack((x, 0.02 * np.sin(2 * np.pi * x / 0.1)))), False)
    assert bending([wiggles], 0.2, 1.0) < 0.1 * bending([wiggles], 0.002, 1.0)


@pytest.mark.parametrize("strays", [0, 20, 200])
def test_any_share_of_outliers_leaves_the_truth_the_best(strays):
    rng = np.random.default_rng(strays)
    points = np.concatenate((arc(1000, SIGMA), rng.uniform(-2.0, 2.0, (strays, 2))))
    through = Polyline(in_space(np.column_stack((np.linspace(-2.0, 2.0, 50), np.full(50, 1.5)))), False)
    truth = nats(points, ring())
    assert truth < nats(points, ring(turn=5.5))
    assert truth < nats(points, ring(), through)


def test_outliers_cost_as_much_as_their_share_makes_them_likely():
    """With a tenth of outliers each costs the logarithm of a tenth of the background."""
    rng = np.random.default_rng(0)
    points = np.concatenate((arc(9000, SIGMA), rng.uniform(-2.0, 2.0, (1000, 2))))
    beyond = rng.uniform(-2.0, 2.0, (1000, 2)) * [0.1, 1.0] + [1.7, 0.0]
    more = nats(np.concatenate((points, beyond)), ring()) - nats(points, ring())
    # The share rises from 10 to 18 %: what was on the curve before loses a little too.
    share = 2000 / 11000
    own = -1000 * np.log(share / 4.0**2) - 9000 * np.log((1 - share) / 0.9) - 1000 * np.log(share / 0.1)
    assert more == pytest.approx(own, rel=0.03)


def test_uneven_density_is_no_reason_to_leave_a_sparse_stretch():
    """Half a ring has a tenth of the samples: the whole ring must tell them better than the dense half."""
    dense, sparse = arc(1000, SIGMA, turn=np.pi, seed=1), -arc(100, SIGMA, turn=np.pi, seed=2)
    points = in_space(np.concatenate([dense, sparse]))
    whole, half = (
        description_length(points, [c], SIGMA, 2.0, True, True, True) for c in (ring(), ring(turn=np.pi))
    )
    assert whole < half - 100.0
    assert whole < description_length(points, [ring()], SIGMA, 2.0, True, True) - 100.0


def test_even_density_is_told_as_well_with_stretches():
    points = in_space(arc(2000, SIGMA, seed=3))
    even, uneven = (description_length(points, [ring()], SIGMA, 2.0, True, True, u) for u in (False, True))
    assert abs(even - uneven) < 25.0  # what a dozen free densities gain by chance


@pytest.mark.parametrize("radius", [0.5, 1.0, 4.0])
def test_the_typical_curvature_of_circles(radius):
    assert typical_curvature([ring(radius)], SIGMA) == pytest.approx(1.0 / radius, rel=0.02)


def test_a_few_sharp_turns_are_not_typical():
    square = Polyline(in_space(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])), True)
    assert typical_curvature([square], 0.005) == pytest.approx(0.0, abs=1e-9)
