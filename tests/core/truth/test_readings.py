from itertools import combinations

import numpy as np
import pytest
import shapely

from core.truth import held_out_names, names, point_set
from core.truth.intersections import crossings
from core.truth.readings import readings


def lines(name, seed=0):
    return [(one.vertices, one.closed) for one in point_set(name, n=1, seed=seed).curves]


def ring(radius=1.0, centre=(0.0, 0.0), count=400):
    angle = np.arange(count) * 2 * np.pi / count
    return np.column_stack((np.cos(angle), np.sin(angle))) * radius + centre, True


CLOSED = [n for n in (*names(), *held_out_names()) if readings(lines(n)) is not None]
CROSSED = [n for n in CLOSED if len(point_set(n, n=1).crossings)]


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("circle", 1),
        ("nested", 3),
        ("figure_8", 2),  # its lobes
        ("double_8", 4),
        ("limacon_loop", 2),  # the outer and the inner outline of one face
        ("two_circles", 2),  # lunes, with a white lens between
        ("pretzel", 3),
        ("looped_square", 5),  # the square and its loops
        ("pentagram", 5),
        ("linked_ellipses", 4),
    ],
)
def test_split_curves_are_the_outlines_of_the_black_faces(name, count):
    known = readings(lines(name))
    assert (known.count("split"), len(known.split)) == (count, count)


@pytest.mark.parametrize("name", CROSSED)
def test_split_curves_cover_the_truth_touch_at_crossings_and_nowhere_cross(name):
    true = lines(name)
    known = readings(true)
    rings = [shapely.Polygon(vertices) for vertices in known.split]
    assert all(one.is_valid for one in rings)
    length = sum(one.length for one in rings)
    assert length == pytest.approx(sum(shapely.linearrings(v).length for v, _ in true), rel=1e-9)
    assert len(crossings([(vertices, True) for vertices in known.split]).locations) == 0
    for place in shapely.points(crossings(true).locations):
        assert sum(one.exterior.distance(place) < 1e-9 * length for one in rings) == 2
    for one, other in combinations(rings, 2):
        common = one.intersection(other).area / min(one.area, other.area)
        assert min(common, abs(1 - common)) < 1e-6  # beside each other, or one in the other


def test_curves_that_hang_together_have_one_waist():
    chain = [ring(), ring(centre=(1.5, 0.0)), ring(centre=(3.0, 0.0))]
    assert readings(chain).waist == 1
    assert readings([*chain, ring(centre=(9.0, 0.0)), ring(0.2, (9.0, 0.0))]).waist == 3


@pytest.mark.parametrize("name", CLOSED)
def test_the_order_of_curves_and_their_direction_do_not_matter(name):
    true = lines(name)
    known, again = readings(true), readings([(v[::-1], closed) for v, closed in true[::-1]])
    assert known.count("split") == again.count("split")
    assert known.count("waist") == again.count("waist")


@pytest.mark.parametrize("seed", range(4))
def test_there_are_no_more_black_faces_than_euler_allows(seed):
    # V - E + F = 2 and E = 2 V: V + 2 faces, of which the outside is white
    true = lines("random_crossing", seed)
    known = readings(true)
    assert 1 <= known.count("split") <= len(crossings(true).locations) + 1
    assert known.waist == 1


@pytest.mark.parametrize("name", ["ribbon", "t_junction", "disjoint", "helix", "trefoil"])
def test_open_curves_and_curves_in_space_have_no_such_reading(name):
    assert readings(lines(name)) is None
