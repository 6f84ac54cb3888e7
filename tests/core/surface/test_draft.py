import pickle

import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.draft import METHODS, attempt, draft_of
from core.surface.parameters import SliceParameters
from core.surface.results import Slice
from core.surface.slicing import slices_of
from core.truth import reference_mesh, solid
from surface.stacks import SIGMA, ellipse, slice_of, without_sector

FRAME = axis_frame((0.0, 0.0, 1.0))


@pytest.mark.parametrize("seed", range(3))
def test_a_contour_seen_whole_is_one_closed_curve(seed):
    draft = draft_of(slice_of([ellipse(5.0)], 5.0, seed), FRAME)
    assert draft.complete
    assert len(draft.loops) == 1
    assert draft.loose == ()
    assert draft.sigma == pytest.approx(SIGMA, rel=0.2)
    assert draft.spacing == pytest.approx(0.25, rel=0.1)
    assert draft.height == 5.0


def test_nested_contours_and_several_are_told_apart():
    lines = [ellipse(0.0), 0.5 * ellipse(0.0), 0.4 * ellipse(0.0) + np.array([60.0, 0.0])]
    draft = draft_of(slice_of(lines, 0.0, 1), FRAME)
    assert draft.complete
    lengths = [np.linalg.norm(np.roll(one, -1, axis=0) - one, axis=1).sum() for one in lines]
    assert sorted(one.length for one in draft.loops) == pytest.approx(sorted(lengths), rel=0.01)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("method", METHODS)
def test_a_contour_with_a_gap_is_incomplete_by_every_method(share, method):
    draft = attempt(without_sector(slice_of([ellipse(3.0)], 3.0, 2), 1.0, share), FRAME, method)
    assert draft is not None
    assert not draft.complete
    assert draft.loose or draft.gap > 20.0


def test_the_gap_is_told_in_mean_distances_between_samples():
    draft = attempt(without_sector(slice_of([ellipse(3.0)], 3.0, 2), 1.0, 0.02), FRAME, "skeleton")
    assert draft is not None
    length = draft.loops[0].length
    assert draft.gap * draft.spacing == pytest.approx(0.02 * length, rel=0.35)


def test_closed_polylines_of_a_mesh_are_the_contours_already():
    (one,) = slices_of([reference_mesh(solid("torus"), 40)], SliceParameters(heights=(3.0,)))
    draft = draft_of(one, FRAME)
    assert draft.complete
    assert draft.method == "polylines"
    for loop, line in zip(draft.loops, one.polylines, strict=True):
        np.testing.assert_array_equal(loop.vertices, line[:, :2])


def test_polylines_that_cross_are_samples():
    one, other = (ellipse(0.0) * size + np.array([x, 0.0]) for size, x in ((1.0, 0.0), (1.0, 0.4)))
    lines = tuple(np.column_stack((line, np.zeros(len(line)))) for line in (one, other))
    draft = draft_of(Slice(0.0, np.vstack(lines), lines, (True, True)), FRAME)
    assert draft.method in METHODS


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_samples_say_nothing(count):
    draft = draft_of(Slice(1.0, np.arange(3.0 * count).reshape(count, 3)), FRAME)
    assert draft.samples == count
    assert draft.loops == draft.loose == ()
    assert not draft.complete


def test_drafts_cross_the_border_of_a_process():
    draft = draft_of(slice_of([ellipse(5.0)], 5.0, 0), FRAME)
    again = pickle.loads(pickle.dumps(draft))  # noqa: S301 # our own bytes
    np.testing.assert_array_equal(again.loops[0].vertices, draft.loops[0].vertices)
    assert again.complete
