"""Weighing both methods' curves, component by component."""

from functools import lru_cache

import numpy as np
import pytest

from core.arbiter import arbitrated, overall, weighed
from core.cloud.partition import partition
from core.parameters import ReconstructParameters
from core.prepared import prepared
from core.truth import point_set
from tests.core.shapes import arc, rotation

RING = arc(500, 0.02, seed=3)


@lru_cache
def shaped(name):
    return point_set(name, n=1200, sigma=0.01, seed=0).points


def parts_of(points, parameters):
    parts = partition(points)
    for component in parts.components:
        members = np.flatnonzero(parts.labels == component.label)
        yield prepared(points[members], members, component, parameters)


def found(points, **parameters):
    asked = ReconstructParameters(**parameters)
    (one,) = parts_of(points, asked)
    return weighed(one, asked)


@pytest.mark.parametrize(
    ("name", "shape"), [("ellipse", (1, 0, 0)), ("wave", (0, 1, 0)), ("figure_8", (1, 0, 1))]
)
def test_both_methods_are_weighed_and_the_shorter_description_comes_first(name, shape):
    best, other = found(shaped(name))
    assert {best.method, other.method} == {"pca", "skeleton"}
    assert best.nats <= other.nats
    assert best.shape == shape
    assert best.crossings == shape[2]


def test_the_largest_gap_is_measured_in_mean_distances():
    best, other = found(RING)
    for each in (best, other):
        # Of N independent samples the largest gap is about ln N mean distances.
        assert 2.0 < each.largest_gap < 3.0 * np.log(len(RING))


@pytest.mark.parametrize("method", ["pca", "skeleton"])
def test_only_the_method_that_was_asked_for_is_run(method):
    (only,) = found(RING, method=method)
    assert only.method == method
    assert only.shape == (1, 0, 0)


def test_in_space_only_the_march_is_run():
    (only,) = found(point_set("helix", n=1000, sigma=0.01, seed=0).points)
    assert only.method == "pca"
    assert only.shape == (0, 1, 0)


def test_the_evidence_is_counted_from_the_best():
    asked = ReconstructParameters()
    (one,) = parts_of(RING, asked)
    first, second = arbitrated(one, asked).evidence
    best, other = weighed(one, asked)
    assert (first.method, second.method) == (best.method, other.method)
    assert first.nats == 0.0
    assert second.nats == pytest.approx(other.nats - best.nats)
    assert first.sigma == pytest.approx(0.02, rel=0.15)


def test_the_evidence_does_not_depend_on_frame_or_unit():
    here = found(RING)
    turn = rotation(np.random.default_rng(0), 2)
    there = found(1e3 * RING[::-1] @ turn.T)
    for one, two in zip(here, there, strict=True):
        assert one.method == two.method
        assert one.shape == two.shape
        assert two.nats - there[0].nats == pytest.approx(one.nats - here[0].nats, abs=0.01)
        assert two.largest_gap == pytest.approx(one.largest_gap, rel=1e-4)


def test_the_largest_component_speaks_for_all():
    asked = ReconstructParameters()
    both = np.concatenate([arc(300, 0.01, seed=1), 3.0 * arc(900, 0.01, seed=2) + np.array([10.0, 0.0])])
    solved = [arbitrated(one, asked) for one in parts_of(both, asked)]
    assert len(solved) == 2
    large = max(solved, key=lambda one: len(one.members))
    for order in (solved, solved[::-1]):
        assert overall(order)[0] == large.method
    assert overall([large]) == (large.method, large.evidence[0].reason)
