import numpy as np
import pytest

from core.results import Curve
from core.surface.draft import Draft
from core.surface.evidence import Evidence, explained, refined

TURN = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
CIRCLE = np.stack((np.cos(TURN), np.sin(TURN)), axis=1)


def draft_of(*loops, sigma=0.001, residual=0.0):
    curves = [Curve(one, True, k, 2 * np.pi, len(one), residual) for k, one in enumerate(loops)]
    return Draft(0.0, tuple(curves), (), sigma, 0.015, samples=400)


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_samples_are_explained_by_contours_near_them(share):
    points = np.where(np.arange(400)[:, None] < 400 * share, CIRCLE, 3.0 * CIRCLE)
    assert explained([CIRCLE], draft_of(CIRCLE), points) == pytest.approx(share)


def test_contours_explain_nothing_where_there_are_none():
    assert explained([], draft_of(CIRCLE), CIRCLE) == 0.0


@pytest.mark.parametrize(
    ("samples", "draft", "noise", "whole"),
    [
        (CIRCLE, draft_of(CIRCLE), 0.0, True),
        (CIRCLE[:350], draft_of(CIRCLE), 0.0, False),  # a gap
        (CIRCLE, draft_of(CIRCLE, residual=0.3), 0.1, False),  # a band of samples, not a line of them
        (CIRCLE, draft_of(CIRCLE * np.array([1.0, 0.01]), sigma=0.01), 0.0, False),  # both sides of one line
    ],
)
def test_a_loop_was_seen_whole_where_samples_lie_all_along_it(samples, draft, noise, whole):
    assert Evidence(draft, samples, noise).whole == [whole]


@pytest.mark.parametrize("gap", [0, 80])
def test_refined_contours_run_through_the_samples_and_stay_in_gaps(gap):
    rng = np.random.default_rng(1)
    samples = np.repeat(CIRCLE[gap:], 5, axis=0)
    samples = samples + 0.01 * rng.normal(size=samples.shape)
    guess = CIRCLE * (1.0 + 0.006 * np.sin(5.0 * TURN))[:, None]
    (loop,) = refined([guess], Evidence(draft_of(guess, sigma=0.01), samples))
    turn = np.mod(np.arctan2(loop[:, 1], loop[:, 0]), 2 * np.pi)
    seen = (turn > TURN[gap] + 0.2) | (gap == 0)
    off = np.linalg.norm(loop, axis=1) - 1.0
    assert np.sqrt(np.mean(off[seen] ** 2)) < 0.002
    assert np.abs(off).max() < 0.015
