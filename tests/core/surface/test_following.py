from dataclasses import replace

import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.draft import draft_of
from core.surface.following import FOLLOWED, followed
from surface.stacks import SIGMA, ellipse, slice_of, without_sector

FRAME = axis_frame((0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def around():
    return [draft_of(slice_of([ellipse(z)], z, 3), FRAME) for z in (8.0, 12.0)]


def test_a_slice_between_two_others_gets_their_contours_moved_to_its_samples(around):
    draft = followed(slice_of([ellipse(10.0)], 10.0, 3), FRAME, *around)
    assert draft is not None
    assert draft.method == FOLLOWED
    assert draft.complete
    assert draft.sigma == pytest.approx(SIGMA, rel=0.15)
    (loop,) = draft.loops
    value = np.sum((loop.vertices / np.abs(ellipse(10.0)).max(axis=0)) ** 2, axis=1)
    assert np.sqrt(np.mean((value - 1.0) ** 2)) < 0.003


def test_the_height_between_may_be_anywhere(around):
    for z in (8.2, 11.7):
        assert followed(slice_of([ellipse(z)], z, 3), FRAME, *around) is not None


def test_it_takes_two_neighbours_that_were_seen_whole_and_agree(around):
    below, above = around
    own = slice_of([ellipse(10.0)], 10.0, 3)
    for wrong in (
        replace(above, complete=False),
        replace(above, loops=above.loops * 2),
        replace(above, method="polylines"),
        replace(above, loops=(), method=""),
        replace(above, height=below.height),
    ):
        assert followed(own, FRAME, below, wrong) is None


def test_samples_that_the_neighbours_do_not_tell_of_are_not_followed(around):
    apart = [ellipse(10.0), 0.3 * ellipse(0.0) + np.array([60.0, 0.0])]
    gone = without_sector(slice_of([ellipse(10.0)], 10.0, 3), 1.0, 0.2)
    other = slice_of([1.5 * ellipse(10.0)], 10.0, 3)
    few = slice_of([ellipse(10.0)], 10.0, 3, spacing=12.0)
    for own in (slice_of(apart, 10.0, 3), gone, few):
        assert followed(own, FRAME, *around) is None
    moved = followed(other, FRAME, *around)
    assert moved is None or moved.sigma < 1.3 * SIGMA
