import numpy as np
import pytest

from core.truth.apart import APART
from core.truth.crossing_families import CROSSING
from core.truth.families import BUILT_IN
from core.truth.hard_families import HARD
from core.truth.held_out import HELD_OUT
from core.truth.held_out_crossings import HELD_OUT_CROSSING
from core.truth.intersections import crossings, separation
from core.truth.junctions import junctions

EVERY = (*BUILT_IN, *CROSSING, *HELD_OUT, *HELD_OUT_CROSSING, *HARD, *APART)
every_family = pytest.mark.parametrize("family", EVERY, ids=[one.name for one in EVERY])
clear = [one for one in (*BUILT_IN, *HELD_OUT) if one.smooth and one.non_crossing]
resolved = [one for one in (*HARD, *APART) if one.smooth and one.non_crossing]


def polylines(family, seed=0, count=500):
    return [(curve.polyline(count), curve.closed) for curve in family.build(seed)]


def diagonal(lines):
    return np.linalg.norm(np.ptp(np.concatenate([vertices for vertices, _ in lines]), axis=0))


def test_names_are_unique():
    assert len({one.name for one in EVERY}) == len(EVERY)


@every_family
def test_the_flags_tell_the_truth(family):
    curves = family.build(0)
    assert family.smooth == (not any(curve.corners for curve in curves))
    lines = polylines(family)
    meet = len(crossings(lines).locations) + len(junctions(lines))
    assert family.non_crossing == (meet == 0)


@every_family
def test_corners_turn_and_nothing_else_does(family):
    for curve in family.build(0):
        vertices = curve.polyline(2000)
        ring = np.vstack((vertices[-1:], vertices, vertices[:1])) if curve.closed else vertices
        edges = np.diff(ring, axis=0)
        edges /= np.linalg.norm(edges, axis=1, keepdims=True)
        turns = np.degrees(np.arccos(np.clip(np.sum(edges[1:] * edges[:-1], axis=1), -1, 1)))
        assert np.sum(turns > 10) == len(curve.corners)


@every_family
def test_the_same_seed_gives_the_same_curves(family):
    for one, other in zip(family.build(3), family.build(3), strict=True):
        np.testing.assert_array_equal(one.polyline(50), other.polyline(50))


@every_family
def test_only_families_that_vary_depend_on_the_seed(family):
    one, other = family.build(0)[0].polyline(50), family.build(1)[0].polyline(50)
    assert np.array_equal(one, other) != family.varies


@pytest.mark.parametrize("family", clear, ids=[one.name for one in clear])
def test_branches_keep_a_nyquist_distance_at_the_largest_noise(family):
    lines = polylines(family)
    assert separation(lines) > 5.0 * 0.02 * diagonal(lines)


@pytest.mark.parametrize("name", ["random_closed", "random_open"])
def test_random_curves_are_clear_of_themselves(name):
    family = next(one for one in HELD_OUT if one.name == name)
    for seed in range(5):
        lines = polylines(family, seed)
        assert len(crossings(lines).locations) == 0
        assert separation(lines) > 0.12 * diagonal(lines)


def test_scans_overlap_and_leave_no_part_of_the_outline_unseen():
    scans = next(one.scans for one in BUILT_IN if one.name == "multi_scan")
    places = np.linspace(0, 1, 1001)
    seen = sum(
        ((places >= first) & (places <= last)) | ((places + 1 >= first) & (places + 1 <= last))
        for first, last in scans.arcs
    )
    assert seen.min() == 1
    assert seen.max() >= 2


@pytest.mark.parametrize("family", resolved, ids=[one.name for one in resolved])
def test_families_resolve_their_detail_at_their_own_noise(family):
    for seed in range(3 if family.varies else 1):
        lines = polylines(family, seed)
        noise = family.sigma * diagonal(lines)
        tightest = max(one.curvature(np.linspace(0, 1, 2000)).max() for one in family.build(seed))
        assert separation(lines) > 6.0 * noise
        assert tightest * noise < 0.5


def test_the_planets_are_of_very_different_size():
    planets = next(one for one in HARD if one.name == "planets").build(0)
    lengths = [one.length for one in planets]
    assert max(lengths) / min(lengths) == pytest.approx(30.0)
    assert {one.closed for one in planets} == {True, False}


def test_families_kept_apart_are_no_others():
    others = {one.name for one in (*BUILT_IN, *CROSSING, *HELD_OUT, *HELD_OUT_CROSSING, *HARD)}
    assert not others & {one.name for one in APART}
    assert sum(one.smooth for one in APART) >= 12
