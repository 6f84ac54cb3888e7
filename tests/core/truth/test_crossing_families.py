import numpy as np
import pytest
from scipy.spatial.distance import cdist, pdist

from core.truth.crossing_families import CROSSING, looped_polygon
from core.truth.held_out_crossings import HELD_OUT_CROSSING
from core.truth.intersections import arc_lengths, crossings
from core.truth.junctions import apart, diagonal, junctions

EVERY = (*CROSSING, *HELD_OUT_CROSSING)
RANDOM = [one for one in HELD_OUT_CROSSING if one.varies]
every_family = pytest.mark.parametrize("family", EVERY, ids=[one.name for one in EVERY])
random_family = pytest.mark.parametrize("family", RANDOM, ids=[one.name for one in RANDOM])


def polylines(curves, count=500):
    return [(curve.polyline(count), curve.closed) for curve in curves]


def angles(curves):
    """Crossing angles in degrees."""
    lines = polylines(curves, 2000)
    found = crossings(lines)
    proper = apart(found.locations, junctions(lines), 1e-3 * diagonal(lines))
    result = []
    for pair, places in zip(found.curves[proper], found.positions[proper], strict=True):
        first, second = (
            curves[k].tangent(curves[k].parameter([at / (2000 - (not curves[k].closed))]))[0]
            for k, at in zip(pair, places, strict=True)
        )
        result.append(np.degrees(np.arccos(min(1.0, abs(first @ second)))))
    return result


@every_family
def test_branches_cross_at_forty_degrees_or_more(family):
    assert min(angles(family.build(0)), default=90.0) >= 40.0


@every_family
def test_crossings_keep_apart_from_each_other_and_from_ends(family):
    lines = polylines(family.build(0))
    places = crossings(lines).locations
    places = places[apart(places, junctions(lines), 1e-3 * diagonal(lines))]
    ends = np.array([end for vertices, closed in lines if not closed for end in vertices[[0, -1]]])
    nearest = min(pdist(places).min(initial=np.inf), cdist(places, ends.reshape(-1, 2)).min(initial=np.inf))
    assert nearest > 0.05 * diagonal(lines)


@every_family
def test_curves_bend_gently(family):
    curves = family.build(0)
    tightest = max(curve.curvature(np.linspace(0, 1, 1000)).max() for curve in curves)
    assert tightest * diagonal(polylines(curves)) < 1 / 0.045


@pytest.mark.parametrize(("corners", "angle"), [(3, 60.0), (4, 90.0), (5, 72.0)])
def test_a_looped_polygon_crosses_at_its_corners(corners, angle):
    curve = looped_polygon(corners, 0.3)
    turns = np.arange(corners) * 2 * np.pi / corners
    places = crossings(polylines([curve], 2000)).locations
    assert len(places) == corners
    gaps = cdist(places, np.column_stack((np.cos(turns), np.sin(turns))))
    assert gaps.min(axis=0).max() < 1e-3
    np.testing.assert_allclose(angles([curve]), angle, atol=6.0)


@random_family
@pytest.mark.parametrize("seed", range(4))
def test_random_curves_cross_clearly(family, seed):
    (curve,) = family.build(seed)
    ((vertices, closed),) = polylines([curve])
    whole = diagonal([(vertices, closed)])
    found = crossings([(vertices, closed)])
    assert 1 <= len(found.locations) <= 6
    assert min(angles([curve])) > 39.0
    assert pdist(found.locations).min(initial=np.inf) > 0.145 * whole
    assert cdist(vertices, found.locations).min(axis=0).max() < 0.01 * whole
    assert distance_away_from_crossings(vertices, closed, found) > 0.115 * whole


def distance_away_from_crossings(vertices, closed, found):
    """Smallest distance of branches, but of the arms of one crossing."""
    way, chord = arc_lengths(vertices, closed), cdist(vertices, vertices)
    near = 0.25 * diagonal([(vertices, closed)])
    arms = np.zeros(chord.shape, bool)
    for first, second in np.round(found.positions).astype(int) % len(vertices):
        one, other = way[first] < near, way[second] < near
        arms |= (one[:, None] & other) | (other[:, None] & one)
    return chord[(way > 2 * chord) & ~arms].min(initial=np.inf)


@random_family
def test_random_curves_are_of_several_kinds(family):
    counts = {len(crossings(polylines(family.build(seed))).locations) for seed in range(6)}
    assert len(counts) > 1
