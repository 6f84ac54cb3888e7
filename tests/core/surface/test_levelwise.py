"""Stacks whose contours are fitted to first guesses, in one piece and in parts."""

import pickle

import numpy as np
import pytest

from core.surface import levelwise
from core.surface.axis import axis_frame
from core.surface.drafts import drafts_of
from core.surface.guided import GUIDED
from core.surface.parameters import ContourParameters
from surface.stacks import RADII, ellipse, rms, slice_of
from tests.core.test_division import assert_same

FRAME = axis_frame((0.0, 0.0, 1.0))
HEIGHTS = np.linspace(-30.0, 30.0, 40).tolist()
PARAMETERS = ContourParameters()


@pytest.fixture(scope="module")
def slices():
    return [slice_of([ellipse(z)], z, 5, spacing=0.5) for z in HEIGHTS]


@pytest.fixture(scope="module")
def shown():
    """Ellipses that are off by more than the noise."""
    return tuple((ellipse(z)[::10] * (1.0 + 0.3 / RADII[:2]),) for z in HEIGHTS)


def test_slices_that_bear_out_what_is_shown_are_fitted_to_it(slices, shown):
    drafts = drafts_of(slices, FRAME, shown)
    assert {one.method for one in drafts} == {GUIDED}
    levels = levelwise.contour_levels(slices, PARAMETERS, shown)
    assert not any(one.warnings for one in levels)
    assert np.mean([rms(one) for one in levels]) < 0.03  # of a noise of 0.1


def test_what_is_shown_cannot_talk_the_samples_down(slices, shown):
    elsewhere = [(one[0] + 200.0,) if k % 3 == 0 else one for k, one in enumerate(shown)]
    levels = levelwise.contour_levels(slices, PARAMETERS, tuple(elsewhere))
    assert [len(one.curves) for one in levels] == [1] * len(HEIGHTS)
    assert max(rms(one) for one in levels) < 0.1


def test_a_stack_that_is_fitted_is_not_worth_dividing_and_one_that_is_not_is(slices, shown):
    assert levelwise.parts_of(slices, PARAMETERS, shown) == ()
    empty = tuple(() for _ in slices)
    parts = levelwise.parts_of(slices, PARAMETERS, empty)
    assert len(parts) > 1
    assert sorted(one.first for part in parts for one in part.groups) == [0, 17, 34]


def test_parts_take_what_is_shown_with_them(slices, shown):
    mixed = tuple(one if k < 20 else () for k, one in enumerate(shown))
    parts = levelwise.parts_of(slices, PARAMETERS, mixed)
    solved = [levelwise.solve(pickle.loads(pickle.dumps(part)), None) for part in parts[::-1]]  # noqa: S301 # ours
    whole = levelwise.contour_levels(slices, PARAMETERS, mixed)
    assert_same(levelwise.contour_levels(slices, PARAMETERS, mixed, drafts=solved), whole)
    methods = [draft.method for part in solved for k, draft in part if k < 20]
    assert set(methods) == {GUIDED}
