from dataclasses import replace

import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.contours import consistent
from core.surface.draft import draft_of
from core.surface.levelwise import contour_levels
from core.surface.parameters import ContourParameters
from core.surface.results import Slice
from surface.stacks import ellipse, rms, slice_of, without_sector

FRAME = axis_frame((0.0, 0.0, 1.0))
HEIGHTS = np.arange(-9.0, 9.5, 1.5)


@pytest.fixture(scope="module")
def stack():
    """Noisy slices of an ellipsoid, and what each says by itself."""
    slices = [slice_of([ellipse(z)], float(z), 4) for z in HEIGHTS]
    return slices, [draft_of(one, FRAME) for one in slices]


def levels_of(stack, changed):
    """The levels when some slices are replaced by others."""
    slices, drafts = (list(one) for one in stack)
    for k, one in changed.items():
        slices[k], drafts[k] = one, draft_of(one, FRAME)
    return consistent(slices, drafts)


def test_every_level_has_its_closed_contour_in_place(stack):
    levels = levels_of(stack, {})
    for z, one in zip(HEIGHTS, levels, strict=True):
        assert one.height == z
        assert not one.completed
        assert one.warnings == ()
        assert [curve.closed for curve in one.curves] == [True]
        assert one.curves[0].vertices[:, 2] == pytest.approx(np.full(len(one.curves[0].vertices), z))
        assert rms(one) < 0.06


@pytest.mark.parametrize("share", [0.1, 0.4, 0.8])
@pytest.mark.parametrize("start", [0.3, 3.0])
def test_a_level_with_a_gap_is_completed_nearly_as_well_as_its_neighbours_are_seen(stack, share, start):
    levels = levels_of(stack, {6: without_sector(stack[0][6], start, share)})
    assert [one.completed for one in levels] == [k == 6 for k in range(len(levels))]
    assert [one.code for one in levels[6].warnings] == ["completed-level"]
    assert [curve.closed for curve in levels[6].curves] == [True]
    assert rms(levels[6]) <= 1.5 * (rms(levels[5]) + rms(levels[7])) / 2


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("empty", [True, False])
def test_adjacent_levels_are_completed_across(stack, count, empty):
    lost = range(5, 5 + count)
    changed = {k: without_sector(stack[0][k], 2.0 + k, 1.0 if empty else 0.5) for k in lost}
    levels = levels_of(stack, changed)
    assert [k for k, one in enumerate(levels) if one.completed] == list(lost)
    around = (rms(levels[4]) + rms(levels[5 + count])) / 2
    for k in lost:
        assert len(levels[k].curves) == 1
        assert rms(levels[k]) <= (1.5 if count < 3 else 2.5) * around


def test_where_nothing_lies_beyond_a_level_its_one_neighbour_completes_it(stack):
    levels = levels_of(stack, {0: without_sector(stack[0][0], 1.0, 0.3)})
    assert levels[0].completed
    assert rms(levels[0]) < 0.5


def test_empty_levels_at_the_ends_stay_empty(stack):
    slices, drafts = stack
    nothing = [Slice(z, np.zeros((0, 3))) for z in (-50.0, 50.0)]
    levels = consistent([*slices, *nothing], [*drafts, *(draft_of(one, FRAME) for one in nothing)])
    assert levels[0].curves == levels[-1].curves == ()
    assert not levels[0].completed
    assert levels[0].warnings == ()


def test_many_levels_without_samples_are_empty_space(stack):
    empty = {k: Slice(float(HEIGHTS[k]), np.zeros((0, 3))) for k in range(4, 8)}
    levels = levels_of(stack, empty)
    assert [k for k, one in enumerate(levels) if not one.curves] == [4, 5, 6, 7]
    assert not any(one.completed for one in levels)


def test_ends_are_completed_from_level_to_level_as_far_as_they_were_seen(stack):
    changed = {k: without_sector(stack[0][k], 1.0, 0.3) for k in (0, 1, 11, 12)}
    changed[0] = without_sector(stack[0][0], 1.0, 0.8)
    levels = levels_of(stack, changed)
    assert [k for k, one in enumerate(levels) if one.completed] == [1, 11, 12]
    assert [one.code for one in levels[0].warnings] == ["incomplete-level"]
    assert rms(levels[12]) < 0.5


def test_incomplete_levels_are_left_so_on_request(stack):
    slices, drafts = (list(one) for one in stack)
    slices[6] = without_sector(slices[6], 1.0, 0.4)
    drafts[6] = draft_of(slices[6], FRAME)
    level = consistent(slices, drafts, ContourParameters(complete=False))[6]
    assert not level.completed
    assert [one.code for one in level.warnings] == ["incomplete-level"]


def test_levels_without_a_complete_neighbour_are_incomplete():
    slices = [without_sector(slice_of([ellipse(z)], z, 1), 1.0, 0.5) for z in (0.0, 1.5)]
    for one in contour_levels(slices, ContourParameters()):
        assert not one.completed
        assert [warning.code for warning in one.warnings] == ["incomplete-level"]


def test_a_level_unlike_its_neighbours_asks_another_method(stack):
    slices, drafts = (list(one) for one in stack)
    doubled = replace(drafts[6], loops=drafts[6].loops * 2)
    noisier = replace(drafts[6], sigma=3 * drafts[6].sigma)
    for wrong in (doubled, noisier):
        level = consistent(slices, [*drafts[:6], wrong, *drafts[7:]])[6]
        assert len(level.curves) == 1
        assert level.curves[0].vertices.shape != drafts[6].loops[0].vertices.shape
        assert rms(level) < 0.06


def test_the_order_of_slices_does_not_matter(stack):
    slices, drafts = stack
    order = np.random.default_rng(0).permutation(len(slices))
    one = consistent(slices, drafts)
    other = consistent([slices[k] for k in order], [drafts[k] for k in order])
    for a, b in zip(one, other, strict=True):
        assert a.height == b.height
        np.testing.assert_array_equal(a.curves[0].vertices, b.curves[0].vertices)


def test_contours_join_across_an_incomplete_level():
    def lines(z):
        return [ellipse(0.0) * 0.4 + np.array([side * (9.0 + z), 0.0]) for side in (-1, 1)]

    whole = [ellipse(0.0) * np.array([0.85, 0.4])]
    slices = [slice_of(lines(z) if z > 4.5 else whole, z, 3) for z in (0.0, 1.5, 3.0, 6.0, 7.5, 9.0)]
    slices.insert(3, Slice(4.5, np.zeros((0, 3))))
    levels = contour_levels(slices, ContourParameters())
    assert [len(one.curves) for one in levels[:3]] == [1, 1, 1]
    assert [len(one.curves) for one in levels[4:]] == [2, 2, 2]
    assert levels[3].completed
    assert all(curve.closed for curve in levels[3].curves)


def test_slices_across_any_axis_give_contours_in_place():
    axis = (1.0, -2.0, 0.5)
    frame = axis_frame(axis)
    slices = [slice_of([ellipse(z)], z, 5, axis) for z in (1.0, 2.0)]
    for one in contour_levels(slices, ContourParameters(axis=axis)):
        (curve,) = one.curves
        assert frame.heights(curve.vertices) == pytest.approx(np.full(len(curve.vertices), one.height))
        flat = frame.to_plane(curve.vertices)
        assert (
            rms(replace(one, curves=(replace(curve, vertices=np.insert(flat, 2, one.height, axis=1)),)))
            < 0.06
        )


def test_progress_ascends_to_its_end():
    told = []
    contour_levels(
        [slice_of([ellipse(z)], z, 6) for z in (0.0, 1.0, 2.0)],
        ContourParameters(),
        progress=lambda share, what: told.append((share, what)),
    )
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert "slice 1 of 3" in [what for _, what in told]


def test_no_slices_have_no_contours():
    assert contour_levels([], ContourParameters()) == ()


def shown_of(stack, factor=1.01):
    """Ellipses beside the true ones."""
    return [[factor * ellipse(one.height)] for one in stack[0]]


def with_shown(stack, changed, shown):
    slices, drafts = (list(one) for one in stack)
    for k, one in changed.items():
        slices[k], drafts[k] = one, draft_of(one, FRAME)
    return consistent(slices, drafts, shown=shown)


def test_many_incomplete_levels_in_a_row_are_completed_by_what_is_shown(stack):
    changed = {k: without_sector(stack[0][k], 1.0, 0.4) for k in range(2, 11)}
    levels = with_shown(stack, changed, shown_of(stack))
    assert [k for k, one in enumerate(levels) if one.completed] == list(range(2, 11))
    assert all("all scans" in one.warnings[0].message for one in levels[2:11])
    assert all(rms(levels[k]) < 0.2 for k in range(2, 11))


def test_near_neighbours_complete_better_than_what_is_shown(stack):
    changed = {6: without_sector(stack[0][6], 1.0, 0.4)}
    one, other = with_shown(stack, changed, shown_of(stack, 1.03))[6], levels_of(stack, changed)[6]
    np.testing.assert_array_equal(one.curves[0].vertices, other.curves[0].vertices)


def test_ends_of_the_stack_are_completed_by_what_is_shown(stack):
    changed = {0: without_sector(stack[0][0], 1.0, 0.8)}
    assert not levels_of(stack, changed)[0].completed
    level = with_shown(stack, changed, shown_of(stack))[0]
    assert level.completed
    assert rms(level) < 0.3


def test_what_is_shown_fills_levels_without_samples_between_others_and_none_beyond(stack):
    empty = {k: Slice(float(HEIGHTS[k]), np.zeros((0, 3))) for k in (0, 4, 5, 6, 7)}
    levels = with_shown(stack, empty, shown_of(stack))
    assert [k for k, one in enumerate(levels) if not one.curves] == [0]
    assert [k for k, one in enumerate(levels) if one.completed] == [4, 5, 6, 7]


def test_what_is_shown_elsewhere_is_passed_over(stack):
    changed = {6: without_sector(stack[0][6], 1.0, 0.4)}
    astray = [[ellipse(0.0) * 0.1 + 200.0]] * len(HEIGHTS)
    levels = with_shown(stack, changed, astray)
    assert rms(levels[6]) < 0.1


def test_complete_levels_take_no_notice_of_what_is_shown(stack):
    for one, other in zip(with_shown(stack, {}, shown_of(stack)), levels_of(stack, {}), strict=True):
        np.testing.assert_array_equal(one.curves[0].vertices, other.curves[0].vertices)
