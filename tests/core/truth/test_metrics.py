from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.truth import held_out_names, names, point_set, score
from core.truth.metrics import distances, resample


def truth_of(sample):
    return [(one.vertices, one.closed) for one in sample.curves]


def ring(radius=1.0, count=1000, centre=(0.0, 0.0)):
    angle = np.arange(count) * 2 * np.pi / count
    return np.column_stack((np.cos(angle), np.sin(angle))) * radius + centre, True


@pytest.mark.parametrize("name", [*names(), *held_out_names()])
def test_the_truth_has_no_error_and_its_own_topology(name):
    sample = point_set(name, n=10)
    got = score(truth_of(sample), sample)
    assert got.topology_right
    assert max(got.maximum, got.maximum_back) < 0.01 * sample.sigma  # chords sag
    assert (got.completeness, got.excess) == (1.0, 0.0)


def test_a_larger_circle_is_off_by_the_difference_of_radii_both_ways():
    sample = point_set("circle", n=10)
    got = score([ring(1.02)], sample)
    for value in (got.rms, got.maximum, got.rms_back, got.maximum_back):
        assert value == pytest.approx(0.02, rel=1e-3)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_distances_are_those_of_brute_force(seed):
    rng = np.random.default_rng(seed)
    line, points = rng.normal(size=(6, 2)), rng.normal(size=(20, 2))
    along = np.linspace(0, 1, 2001)[:, None]
    dense = np.concatenate([a + along * (b - a) for a, b in pairwise(line)])
    brute = np.linalg.norm(points[:, None] - dense[None], axis=2).min(axis=1)
    np.testing.assert_allclose(distances(points, [(line, False)]), brute, atol=5e-3)


def test_a_closed_polyline_has_its_closing_edge():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    point = np.array([[0.0, 0.5]])
    assert distances(point, [(square, True)])[0] == pytest.approx(0.0, abs=1e-12)
    assert distances(point, [(square, False)])[0] == pytest.approx(0.5)


def test_resampling_spreads_points_by_length():
    short, long = resample(
        [(np.array([(0, 0), (1, 0)], float), False), (np.array([(0, 1), (3, 1)], float), False)], 400
    )
    assert (len(short), len(long)) == (100, 300)
    np.testing.assert_allclose(np.diff(long[:, 0]), 0.01)


def test_errors_scale_and_move_with_the_curves():
    sample = point_set("ellipse", n=10)
    rng = np.random.default_rng(0)
    rough = sample.curves[0].vertices[::5] + 0.01 * rng.normal(size=(400, 2))
    there = distances(rough, truth_of(sample))
    moved = distances(7 * rough + 100, [(7 * v + 100, c) for v, c in truth_of(sample)])
    np.testing.assert_allclose(moved, 7 * there, atol=1e-9)


def test_an_open_result_of_a_closed_curve_has_a_wrong_flag():
    sample = point_set("circle", n=10)
    got = score([(sample.curves[0].vertices, False)], sample)
    assert not got.flags_right
    assert got.covered


def test_half_of_a_curve_is_half_complete_and_covers_nothing():
    sample = point_set("circle", n=10)
    got = score([(sample.curves[0].vertices[:1001], False)], sample)
    assert got.completeness == pytest.approx(0.5, abs=0.03)
    assert got.excess == 0.0
    assert not got.covered
    assert not got.topology_right


def test_a_curve_in_two_pieces_is_one_too_many():
    sample = point_set("wave", n=10)
    vertices = sample.curves[0].vertices
    got = score([(vertices[:1000], False), (vertices[1000:], False)], sample)
    assert (got.curves, got.true_curves) == (2, 1)
    assert not got.topology_right
    assert got.completeness == 1.0


def test_one_curve_over_two_does_not_stand_for_both():
    sample = point_set("parallel_waves", n=10)
    first, second = (one.vertices for one in sample.curves)
    got = score([(np.vstack((first, second[::-1])), False)], sample)
    assert got.completeness == 1.0
    assert not got.flags_right
    assert not got.covered


def test_a_stray_curve_is_excess():
    sample = point_set("circle", n=10)
    got = score([*truth_of(sample), ring(1.0, centre=(5.0, 0.0))], sample)
    assert got.rms < 1e-5
    assert got.excess == pytest.approx(0.5, abs=0.01)
    assert got.maximum_back == pytest.approx(5.0, abs=0.01)


def test_results_are_matched_in_any_order_and_direction():
    sample = point_set("disjoint", n=10)
    shuffled = [(vertices[::-1], closed) for vertices, closed in truth_of(sample)[::-1]]
    assert score(shuffled, sample).topology_right


def test_a_missing_loop_is_a_missing_crossing():
    sample = point_set("figure_8", n=10, sigma=0.01)
    vertices = sample.curves[0].vertices
    sides = [vertices[vertices[:, 0] > 0.02], vertices[vertices[:, 0] < -0.02]]
    got = score([(side, True) for side in sides], sample)
    assert (got.crossings, got.true_crossings) == (0, 1)
    assert not got.topology_right


def test_no_curve_at_all_is_infinitely_far():
    sample = point_set("circle", n=10)
    got = score([], sample)
    assert got.rms == float("inf")
    assert got.completeness == 0.0
    assert not got.topology_right


# --- junctions ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("passing", [(0, 1), (1, 2), (2, 0)])
def test_any_two_arms_of_a_star_may_be_one_curve(passing):
    sample = point_set("y_junction", n=10)
    arms = [one.vertices for one in sample.curves]
    one, other = passing
    (third,) = {0, 1, 2} - set(passing)
    got = score([(np.vstack((arms[one][:0:-1], arms[other])), False), (arms[third], False)], sample)
    assert got.topology_right
    assert (got.curves, got.true_curves) == (2, 2)


def test_a_star_is_not_one_curve_nor_four():
    sample = point_set("y_junction", n=10)
    arms = [one.vertices for one in sample.curves]
    whole = np.vstack((arms[0][:0:-1], arms[1], arms[2][::-1]))
    assert not score([(whole, False)], sample).topology_right
    halves = [(arms[0][:1000], False), (arms[0][1000:], False), (arms[1], False), (arms[2], False)]
    assert not score(halves, sample).topology_right


def test_the_bar_of_a_t_goes_straight_on():
    sample = point_set("t_junction", n=10)
    bar, stem = (one.vertices for one in sample.curves)
    foot = np.argmin(np.linalg.norm(bar - stem[0], axis=1))
    assert not score([(bar[:foot], False), (bar[foot:], False), (stem, False)], sample).flags_right
    assert not score([(bar[:foot], False), (np.vstack((bar[:foot:-1], stem)), False)], sample).covered


@pytest.mark.parametrize(("sigmas", "count"), [(1.0, 0), (25.0, 1)])
def test_an_end_crosses_only_where_it_runs_far_past_its_junction(sigmas, count):
    sample = point_set("t_junction", n=10)
    bar, stem = (one.vertices for one in sample.curves)
    beyond = stem[:1] + np.array([[0.0, (sigmas + 1.0) * sample.sigma]])
    raised = bar + np.array([0.0, sigmas * sample.sigma])
    got = score([(raised, False), (np.vstack((beyond, stem)), False)], sample)
    assert got.crossings == count


# --- readings without crossings -----------------------------------------------------------------------


def lobes(sample):
    vertices = sample.curves[0].vertices
    return [(vertices[vertices[:, 0] > 0.01], True), (vertices[vertices[:, 0] < -0.01], True)]


def test_two_lobes_are_a_split_figure_8_and_nothing_else():
    sample = point_set("figure_8", n=10)
    assert score(lobes(sample), sample, "split").topology_right
    assert not score(lobes(sample), sample, "waist").topology_right
    assert not score(lobes(sample), sample).topology_right


def test_one_lobe_turned_round_makes_a_waist():
    sample = point_set("figure_8", n=10)
    first, second = (vertices for vertices, _ in lobes(sample))
    first = np.roll(first, -np.argmax(np.linalg.norm(np.diff(first, axis=0), axis=1)) - 1, axis=0)
    outline = [(np.vstack((first, second[::-1])), True)]
    got = score(outline, sample, "waist")
    assert (got.curves, got.crossings, got.topology_right) == (1, 0, True)


def test_what_crosses_is_no_reading_without_crossings():
    sample = point_set("figure_8", n=10)
    for reading in ("split", "waist"):
        got = score(truth_of(sample), sample, reading)
        assert (got.crossings, got.true_crossings) == (1, 0)
        assert not got.topology_right


def test_a_split_that_lacks_a_lobe_does_not_cover():
    sample = point_set("figure_8", n=10)
    right = lobes(sample)[0]
    got = score([right, right], sample, "split")
    assert got.flags_right
    assert not got.covered


def test_open_curves_have_no_reading_without_crossings():
    sample = point_set("ribbon", n=10)
    with pytest.raises(ValueError, match="closed"):
        score(truth_of(sample), sample, "split")
