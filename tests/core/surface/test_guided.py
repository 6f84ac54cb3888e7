import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.guided import GUIDED, guided
from core.surface.results import Slice

FRAME = axis_frame((0.0, 0.0, 1.0))
SIGMA = 0.01
HEIGHT = 3.0


def circle(count, radius=1.0, centre=(0.0, 0.0)):
    t = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.asarray(centre) + radius * np.stack([np.cos(t), np.sin(t)], axis=1)


def sampled(count, radius=1.0, centre=(0.0, 0.0), seed=0, most=2.0 * np.pi):
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0.0, most, count))
    points = radius * np.stack([np.cos(t), np.sin(t)], axis=1) + SIGMA * rng.normal(size=(count, 2))
    return np.asarray(centre) + points


def slice_of(*parts):
    flat = np.concatenate(parts)
    return Slice(HEIGHT, np.column_stack([flat, np.full(len(flat), HEIGHT)]))


def radius_of(loop, centre=(0.0, 0.0)):
    return np.linalg.norm(loop.vertices - np.asarray(centre), axis=1)


def test_every_contour_becomes_the_one_of_its_samples():
    far = (5.0, 1.0)
    draft = guided(
        slice_of(sampled(900), sampled(500, 0.6, far, seed=1)),
        FRAME,
        [circle(80, 1.02), circle(50, 0.59, far)],
    )
    assert draft.complete
    assert draft.method == GUIDED
    assert draft.height == HEIGHT
    assert [loop.samples for loop in draft.loops] == [900, 500]
    assert draft.samples == 1400
    assert draft.left == 0.0
    assert np.abs(radius_of(draft.loops[0]) - 1.0).max() < SIGMA
    assert np.abs(radius_of(draft.loops[1], far) - 0.6).max() < SIGMA
    assert draft.sigma == pytest.approx(SIGMA, rel=0.1)


def test_the_method_is_the_callers():
    assert guided(slice_of(sampled(400)), FRAME, [circle(80)], "so").method == "so"


def test_a_small_contour_that_the_guess_has_not_is_found_among_the_rest():
    small = (3.0, 0.0)
    draft = guided(slice_of(sampled(900), sampled(150, 0.2, small, seed=2)), FRAME, [circle(80, 1.01)])
    assert draft.complete
    assert len(draft.loops) == 2
    assert np.abs(radius_of(draft.loops[1], small) - 0.2).max() < 2.0 * SIGMA
    assert draft.left < 0.01


def test_few_strays_far_away_are_passed_over():
    strays = np.random.default_rng(4).uniform(2.0, 4.0, (8, 2))
    draft = guided(slice_of(sampled(900), strays), FRAME, [circle(80, 1.01)])
    assert draft.complete
    assert len(draft.loops) == 1
    assert np.abs(radius_of(draft.loops[0]) - 1.0).max() < SIGMA
    assert draft.left == pytest.approx(8 / 908)


def test_much_that_is_far_from_the_guess_says_that_it_is_wrong():
    away = sampled(900, 1.0, (6.0, 0.0), seed=3, most=3.0)
    assert guided(slice_of(sampled(900), away), FRAME, [circle(80)]) is None


def test_contours_that_cross_are_none():
    other = (1.2, 0.0)
    slice_ = slice_of(sampled(900), sampled(900, 1.0, other, seed=1))
    assert guided(slice_, FRAME, [circle(80), circle(80, 1.0, other)]) is None


def test_a_gap_leaves_the_draft_incomplete():
    draft = guided(slice_of(sampled(900, most=4.5)), FRAME, [circle(80)])
    assert not draft.complete
    assert len(draft.loops) == 1
    assert draft.gap > 100.0
    assert np.abs(radius_of(draft.loops[0]) - 1.0).max() < 4.0 * SIGMA


def test_without_a_guess_or_enough_samples_there_is_nothing():
    assert guided(slice_of(sampled(900)), FRAME, []) is None
    assert guided(slice_of(sampled(15)), FRAME, [circle(80)]) is None


def test_contours_without_samples_stay_the_guess_and_are_incomplete():
    draft = guided(slice_of(sampled(900)), FRAME, [circle(80), circle(20, 0.2, (9.0, 0.0))])
    assert draft is None or not draft.complete
