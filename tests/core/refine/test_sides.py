import numpy as np
import pytest

from core.refine.polyline import Polyline
from core.refine.sides import (
    STEP,
    Nodes,
    Strokes,
    evidence,
    fit_strokes,
    line_nodes,
    straight_enough,
    strokes_along,
)
from tests.core.shapes import in_space, rotation

SIGMA = 0.01


def wedge(degrees, n=1500, seed=0):
    """Samples of two strokes of length 0.3 that turn by so many degrees in the origin, and their line."""
    rng = np.random.default_rng(seed)
    angle = np.radians(degrees)
    ends = 0.3 * np.array([(-1.0, 0.0), (0.0, 0.0), (np.cos(angle), np.sin(angle))])
    t = rng.uniform(-1.0, 1.0, n)
    points = np.where(t[:, None] < 0, -t[:, None] * ends[0], t[:, None] * ends[2])
    return in_space(points + SIGMA * rng.normal(size=points.shape)), Polyline(in_space(ends), False)


def fitted(points, line, start=None):
    knots = np.array([0.05, 0.3, 0.55])
    beyond = line_nodes(line, 0.0, 0.05, SIGMA).joined(line_nodes(line, 0.55, 0.6, SIGMA))
    strokes = strokes_along(line if start is None else start, knots, False, SIGMA)
    return fit_strokes(points, strokes, beyond, SIGMA), beyond


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("degrees", [40, 90, 127, 150])
def test_strokes_find_the_corner_from_a_rounded_course(degrees, seed):
    points, line = wedge(degrees, seed=seed)
    rounded = Polyline(line.at(np.linspace(0.0, 0.6, 61)), False).vertices
    weights = np.hanning(9)[:, None]
    for _ in range(2):
        inside = np.stack([np.sum(weights * rounded[k : k + 9], axis=0) for k in range(53)]) / weights.sum()
        rounded = np.concatenate([rounded[:4], inside, rounded[-4:]])
    (strokes, _), _ = fitted(points, line, Polyline(rounded, False))
    half = np.radians(0.5 * degrees)  # gentle corners slide along, acute ones up and down
    assert np.linalg.norm(strokes.control[2]) < 0.4 * SIGMA / min(np.sin(half), np.cos(half))


def test_the_fit_climbs():
    points, line = wedge(90)
    moved = Polyline(line.vertices + np.array([[0.0, 0.5 * SIGMA, 0.0]]), False)
    (strokes, level), beyond = fitted(points, line, moved)
    start = strokes_along(moved, np.array([0.05, 0.3, 0.55]), False, SIGMA)
    assert level > evidence(points, start.nodes().joined(beyond), SIGMA) + 10.0
    assert level == pytest.approx(evidence(points, strokes.nodes().joined(beyond), SIGMA))


def test_the_true_course_is_likelier_than_others():
    points, line = wedge(90)
    truth = evidence(points, line_nodes(line, 0.0, 0.6, SIGMA), SIGMA)
    for shift in (-0.5, 0.5):
        moved = Polyline(line.vertices + shift * SIGMA * np.array([1.0, 1.0, 0.0]), False)
        assert evidence(points, line_nodes(moved, 0.0, 0.6, SIGMA), SIGMA) < truth


def test_evidence_does_not_depend_on_the_frame():
    points, line = wedge(60)
    turn = rotation(np.random.default_rng(1), 3).T
    turned = Polyline(line.vertices @ turn, False)
    here = evidence(points, line_nodes(line, 0.0, 0.6, SIGMA), SIGMA)
    assert evidence(points @ turn, line_nodes(turned, 0.0, 0.6, SIGMA), SIGMA) == pytest.approx(here)
    order = np.random.default_rng(2).permutation(len(points))
    assert evidence(points[order], line_nodes(line, 0.0, 0.6, SIGMA), SIGMA) == pytest.approx(here)


def test_straight_sides_are_made_straight_and_bent_ones_are_not():
    points, line = wedge(90)
    (strokes, _), beyond = fitted(points, line)
    straight = straight_enough(strokes)
    assert not straight.bent.any()
    again = fit_strokes(points, straight, beyond, SIGMA)[0]
    middle = 0.5 * (again.control[0] + again.control[2])
    assert np.linalg.norm(again.control[1] - middle) < 0.01 * SIGMA
    bend = np.array([[0.0, 0.0, 0.0]]) + np.outer(
        1.0 - (points[:, 0] / 0.15 + 1.0) ** 2, [0.0, 3 * SIGMA, 0.0]
    )
    lifted = points + np.where((points[:, 0] < -0.02)[:, None], bend, 0.0)
    (curved, _), _ = fitted(lifted, line)
    assert straight_enough(curved).bent[0]


def test_standard_errors_cover_the_scatter_of_the_corner():
    places, errors = [], []
    for seed in range(40):
        points, line = wedge(90, n=600, seed=seed)
        (strokes, _), _ = fitted(points, line)
        places.append(strokes.control[2, :2])
        errors.append(strokes.error_at(0, np.array([1.0]), True)[0])
    scatter = np.std(np.array(places)[:, 1])
    assert 0.5 < np.mean(errors) / scatter < 2.0


def test_nodes_stand_for_the_length_of_their_strokes():
    control = in_space(np.array([(0.0, 0.0), (0.5, 0.5), (1.0, 0.0), (1.5, 0.0), (2.0, 0.0)]))
    strokes = Strokes.of(control, [40, 40], False)
    nodes = strokes.nodes()
    assert nodes.weight.sum() == pytest.approx(strokes.length(0) + strokes.length(1), rel=1e-3)
    assert nodes.weight[40:].sum() == pytest.approx(1.0)
    none = Nodes.none()
    assert len(none.joined(nodes).weight) == len(nodes.weight)


def test_an_arc_takes_the_corner_away_and_keeps_the_rest():
    control = in_space(np.array([(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 0.5), (1.0, 1.0)]))
    strokes = Strokes.of(control, [50, 50], False)
    arc = strokes.rounded(0.7, 0.3, STEP * SIGMA).nodes()
    assert np.linalg.norm(arc.place - control[2], axis=1).min() > 0.1
    assert arc.weight.sum() == pytest.approx(1.4 + 0.3 * 1.6232, rel=1e-3)
    straight = (arc.place[:, 0] < 0.7) | (arc.place[:, 1] > 0.3)
    on = np.minimum(np.abs(arc.place[:, 1]), np.abs(arc.place[:, 0] - 1.0))
    assert on[straight].max() < 1e-12


def test_a_ring_closes():
    square = Polyline(in_space(np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])), True)
    ring = strokes_along(square, np.arange(5.0), True, 0.05)
    assert ring.count == 4
    assert len(ring.control) == 8
    np.testing.assert_allclose(ring.at(3, np.array([1.0])), ring.at(0, np.array([0.0])))
    assert ring.nodes().weight.sum() == pytest.approx(4.0)
