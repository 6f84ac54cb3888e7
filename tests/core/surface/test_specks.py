from dataclasses import replace

import numpy as np
import pytest

from core.results import Curve
from core.surface.axis import axis_frame
from core.surface.results import ContourLevel
from core.surface.specks import without_specks

AXIS = (0.0, 3.0, 4.0)
FRAME = axis_frame(AXIS)
TURN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def circle(height, x=0.0, radius=10.0, samples=1000):
    flat = np.column_stack((x + radius * np.cos(TURN), radius * np.sin(TURN)))
    return Curve(FRAME.lift(flat, height), True, 0, 2.0 * np.pi * radius, samples, 0.1)


def stack(extra, count=9):
    """A cylinder of levels one apart, with further contours: level -> list."""
    return [
        ContourLevel(float(k), (circle(float(k)), *(make(float(k)) for make in extra.get(k, []))))
        for k in range(count)
    ]


def crumb(height):
    return circle(height, 30.0, 0.5, 12)


def numbers(levels):
    return [len(one.curves) for one in levels]


@pytest.mark.parametrize("places", [(4,), (4, 5), (0,), (8,)])
def test_a_crumb_beside_the_object_is_left_out_and_told(places):
    found = without_specks(stack({k: [crumb] for k in places}), FRAME)
    assert numbers(found) == [1] * 9
    assert [k for k, one in enumerate(found) if one.warnings] == list(places)
    assert {warning.code for one in found for warning in one.warnings} == {"speck"}
    assert all("12 samples" in one.warnings[0].message for one in found if one.warnings)


def test_what_goes_on_for_many_levels_is_a_part():
    found = without_specks(stack({k: [crumb] for k in range(2, 8)}), FRAME)
    assert numbers(found) == [1, 1, *[2] * 6, 1]
    assert not any(one.warnings for one in found)


def test_the_tip_of_something_larger_stays():
    def arm(height):
        return circle(height, 30.0, 4.0, 300)

    found = without_specks(stack({3: [crumb], 4: [arm], 5: [arm]}), FRAME)
    assert numbers(found) == [1, 1, 1, 2, 2, 2, 1, 1, 1]


def test_a_hole_in_one_level_alone_is_a_bubble():
    def hole(samples):
        return lambda height: circle(height, 0.0, 2.0, samples)

    assert numbers(without_specks(stack({4: [hole(50)]}), FRAME)) == [1] * 9
    assert numbers(without_specks(stack({4: [hole(300)]}), FRAME))[4] == 2


def test_a_bubble_that_was_only_guessed_goes_too():
    levels = stack({4: [lambda height: circle(height, 0.0, 2.0, 0)]})
    guessed = [*levels[:4], replace(levels[4], completed=True), *levels[5:]]
    assert numbers(without_specks(guessed, FRAME)) == [1] * 9


def test_contours_without_samples_are_not_judged():
    def given(height):
        return circle(height, 30.0, 0.5, 0)

    assert numbers(without_specks(stack({4: [given]}), FRAME))[4] == 2
    assert without_specks([], FRAME) == ()


def test_a_hole_that_is_open_above_and_below_is_closed():
    """Two posts that a stray patch joins in one level, with a hole between."""
    posts = [ContourLevel(float(k), (circle(float(k), -12.0), circle(float(k), 12.0))) for k in range(9)]
    joined = (circle(4.0, 0.0, 24.0, 2000), circle(4.0, 0.0, 1.5, 12))
    found = without_specks([*posts[:4], ContourLevel(4.0, joined), *posts[5:]], FRAME)
    assert numbers(found) == [2, 2, 2, 2, 1, 2, 2, 2, 2]
    assert [one.code for one in found[4].warnings] == ["speck"]
    larger = (joined[0], circle(4.0, 0.0, 1.5, 300))
    kept = without_specks([*posts[:4], ContourLevel(4.0, larger), *posts[5:]], FRAME)
    assert numbers(kept)[4] == 2


def test_a_pit_stays():
    def hole(height):
        return circle(height, 0.0, 2.0, 12)

    assert numbers(without_specks(stack({k: [hole] for k in (6, 7, 8)}), FRAME)) == [1] * 6 + [2] * 3
