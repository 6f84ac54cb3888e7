import numpy as np
import pytest

from core.refine.evidence import description_length
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
