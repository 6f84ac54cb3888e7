import numpy as np
import pytest

from core.cloud.linkage import components
from core.cloud.plateau import Witnesses, clearest, least_component_size


def segment(length, count, start=(0.0, 0.0), way=(1.0, 0.0)):
    """Equidistant points of a segment."""
    return np.array(start) + np.linspace(0, length, count)[:, None] * np.array(way)


def count(points, epsilon):
    return len(np.unique(components(points, epsilon)))


def all_of(points):
    return Witnesses(np.arange(len(points)), np.ones(len(points)))


def test_segments_side_by_side_are_kept_apart_over_a_narrow_range():
    points = np.concatenate((segment(100, 101), segment(100, 101, (0.0, 1.6))))
    assert count(points, clearest(points, 1.01, all_of(points))) == 2


def test_segments_end_to_end_are_joined_over_the_same_range():
    points = np.concatenate((segment(100, 101), segment(100, 101, (101.6, 0.0))))
    assert count(points, clearest(points, 1.01, all_of(points))) == 1


def test_segments_end_to_end_but_far_apart_are_two():
    points = np.concatenate((segment(100, 101), segment(100, 101, (105.0, 0.0))))
    assert count(points, clearest(points, 1.01, all_of(points))) == 2


def test_a_long_part_of_few_samples_is_not_given_up():
    dense, sparse = segment(100, 2001), segment(100, 26, (104.0, 0.0))
    points = np.concatenate((dense, sparse))
    length = np.concatenate((np.full(2001, 0.05), np.full(26, 4.0)))
    at = Witnesses(np.arange(len(points)), length)
    assert clearest(points, 1.5, at) > 4.0
    assert clearest(points, 1.5, Witnesses.none()) < 4.0


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_the_unit_of_length_makes_no_difference(scale):
    points = np.concatenate((segment(100, 101), segment(100, 101, (0.0, 1.6)))) * scale
    witnesses = Witnesses(np.arange(len(points)), np.full(len(points), scale))
    assert clearest(points, 1.01 * scale, witnesses) == pytest.approx(
        scale * clearest(points / scale, 1.01, all_of(points))
    )


def test_nobody_witnesses_no_length():
    assert len(Witnesses.none().index) == len(Witnesses.none().length) == 0


def test_the_least_size_of_one_point_is_one():
    assert least_component_size(1) == 1
