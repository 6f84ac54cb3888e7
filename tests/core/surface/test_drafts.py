import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.draft import METHODS
from core.surface.drafts import GROUP, drafts_of
from core.surface.following import FOLLOWED
from core.surface.parameters import SliceParameters
from core.surface.results import Slice
from core.surface.slicing import slices_of
from core.truth import reference_mesh, solid
from surface.stacks import ellipse, slice_of, without_sector

FRAME = axis_frame((0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def slices():
    return [slice_of([ellipse(z)], float(z), 8) for z in np.linspace(-12.0, 12.0, GROUP)]


@pytest.fixture(scope="module")
def drafts(slices):
    return drafts_of(slices, FRAME)


def test_the_ends_are_found_and_most_slices_between_are_followed(drafts):
    methods = [one.method for one in drafts]
    assert len(drafts) == GROUP
    assert methods[0] in METHODS
    assert methods[-1] in METHODS
    assert methods.count(FOLLOWED) > GROUP / 2


def test_contours_that_were_followed_are_as_near_to_the_truth(drafts):
    errors = {True: [], False: []}
    for one in drafts:
        (loop,) = one.loops
        true = ellipse(one.height)
        size = float(np.abs(true[:, 0]).max())
        value = np.sum((loop.vertices / np.abs(true).max(axis=0)) ** 2, axis=1) - 1.0
        errors[one.method == FOLLOWED].append(np.sqrt(np.mean(value**2)) * size / 2)
    assert np.mean(errors[True]) < 1.3 * np.mean(errors[False])


def test_every_draft_is_of_its_slice(slices, drafts):
    for one, draft in zip(slices, drafts, strict=True):
        assert draft.height == one.height
        assert draft.samples == len(one.points)
        assert draft.complete


@pytest.mark.parametrize("lost", [2, 4])
def test_what_was_not_seen_whole_is_not_followed_nor_hides_it(slices, lost):
    changed = [without_sector(one, 1.0, 0.3) if k == lost else one for k, one in enumerate(slices[:5])]
    drafts = drafts_of(changed, FRAME)
    assert [k for k, one in enumerate(drafts) if not one.complete] == [lost]


def test_a_contour_that_appears_between_is_found(slices):
    island = [ellipse(slices[2].height), 0.3 * ellipse(0.0) + np.array([50.0, 0.0])]
    changed = [slice_of(island, one.height, 8) if k == 2 else one for k, one in enumerate(slices[:5])]
    assert [len(one.loops) for one in drafts_of(changed, FRAME)] == [1, 1, 2, 1, 1]


def test_clean_slices_are_taken_as_they_are():
    clean = slices_of([reference_mesh(solid("fork"), 24)], SliceParameters(levels=GROUP))
    assert {one.method for one in drafts_of(clean, FRAME)} == {"polylines"}


@pytest.mark.parametrize("count", [0, 1, 2])
def test_any_number_of_slices_will_do(slices, count):
    empty = [Slice(float(k), np.zeros((0, 3))) for k in range(count)]
    assert len(drafts_of(slices[:count], FRAME)) == count
    assert [one.samples for one in drafts_of(empty, FRAME)] == [0] * count


def test_progress_ascends(slices):
    told = []
    drafts_of(slices[:5], FRAME, progress=lambda share, _: told.append(share))
    assert told == sorted(told)
    assert told[0] == 0.0
    assert told[-1] < 1.0
