import numpy as np
import pytest

from core.truth import Conditions, clearance, held_apart_names, point_set


def test_the_turns_of_a_spiral_are_a_pitch_apart():
    sample = point_set("spiral", n=500, sigma=0.01)
    assert clearance(sample).separation * sample.sigma == pytest.approx(2 * np.pi, rel=0.02)


def test_a_circle_has_one_branch_and_its_own_radius():
    sample = point_set("circle", n=500, sigma=0.01)
    room = clearance(sample)
    assert room.separation == np.inf
    assert room.radius * sample.sigma == pytest.approx(1.0)


def test_curves_beside_each_other_are_as_far_apart_as_they_are():
    sample = point_set("parallel_arcs", n=500, sigma=0.01)
    assert clearance(sample).separation * sample.sigma == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("name", ["figure_8", "two_circles", "t_junction", "y_junction", "trochoid_loops"])
def test_branches_that_meet_are_not_near_for_it(name):
    sample = point_set(name, n=500)
    assert clearance(sample).separation * sample.sigma > 0.1


def test_corners_have_no_radius():
    assert clearance(point_set("star", n=500)).radius == 0.0


def test_lengths_are_in_units_of_the_noise():
    one, other = (clearance(point_set("wasp_waist", n=500, sigma=s)) for s in (0.01, 0.02))
    assert one.separation == pytest.approx(2 * other.separation)
    assert one.radius == pytest.approx(2 * other.radius)
    assert one.gap == other.gap


def test_gaps_of_independent_samples_grow_like_the_logarithm():
    gaps = [clearance(point_set("ellipse", n=4000, seed=s)).gap for s in range(20)]
    assert np.mean(gaps) == pytest.approx(np.log(4000) + 0.577, abs=1.0)


def test_a_gap_is_in_mean_spacings():
    sample = point_set("wave", n=2000, conditions=Conditions(spacing="even"))
    assert 1.0 < clearance(sample).gap < 2.01


def test_one_sample_leaves_everything_open():
    assert clearance(point_set("circle", n=1)).gap == np.inf


@pytest.mark.parametrize("name", held_apart_names())
def test_families_kept_apart_leave_room_at_their_own_noise(name):
    assert clearance(point_set(name)).separation > 8.0
