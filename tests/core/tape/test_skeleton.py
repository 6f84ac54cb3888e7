import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.errors import InvalidParameter
from core.tape.medial_axis import MOST_SAMPLES, SPACING, mean_width
from core.tape.skeleton import PASSES, skeleton_of

PRUNE = 0.8
HALF = 0.5  # half-width of all tapes here


def unit(degrees):
    return np.array((np.cos(np.radians(degrees)), np.sin(np.radians(degrees))))


def tape(*ways, cap="round"):
    """What is within half a width of some segments."""
    return shapely.multilinestrings([np.asarray(way, float) for way in ways]).buffer(HALF, cap_style=cap)


def strip(degrees=0.0, cap="round"):
    return tape((-5.0 * unit(degrees), 5.0 * unit(degrees)), cap=cap)


def tee():
    return tape([(-5, 0), (5, 0)], [(0, 0), (0, -5)])


def plus():
    return tape([(-5, 0), (5, 0)], [(0, -5), (0, 5)])


def annulus(radius=1.5):
    centre = shapely.Point(0.0, 0.0)
    return centre.buffer(radius + HALF).difference(centre.buffer(radius - HALF))


def rough(seed, share, count):
    """A strip whose long sides go up and down by a share of its half-width."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-5.0, 5.0, count)
    top, bottom = HALF * (1.0 + share * rng.uniform(-1.0, 1.0, (2, count)))
    sides = np.column_stack((x, top)), np.column_stack((x, -bottom))[::-1]
    return shapely.Polygon(np.concatenate(sides))


def window(columns, rows):
    """A frame with panes of three by three between bars one wide."""
    panes = [shapely.box(4 * i, 4 * j, 4 * i + 3, 4 * j + 3) for i in range(columns) for j in range(rows)]
    return shapely.box(-1, -1, 4 * columns, 4 * rows).difference(shapely.union_all(panes))


def dumbbell(neck):
    """Two rods two wide, and a straight neck three long between them."""
    rods = [shapely.LineString([(side * 10, 0), (side * 2.5, 0)]).buffer(1.0) for side in (-1, 1)]
    return shapely.union_all([*rods, shapely.LineString([(-5, 0), (5, 0)]).buffer(0.5 * neck)])


def places(skeleton):
    return np.concatenate([edge.places for edge in skeleton.graph.edges])


def radii(skeleton):
    return np.concatenate([edge.radius for edge in skeleton.graph.edges])


def tips(skeleton):
    return skeleton.graph.places[skeleton.graph.degree == 1]


def off(skeleton, *ways):
    """Distance of the graph's places from some segments."""
    truth = shapely.multilinestrings([np.asarray(way, float) for way in ways])
    return shapely.distance(shapely.points(places(skeleton)), truth)


def drawn(skeleton):
    return shapely.MultiLineString([edge.places for edge in skeleton.graph.edges])


def pieces(graph):
    ends = np.array([edge.ends for edge in graph.edges]).T
    size = len(graph.places)
    return connected_components(coo_array((np.ones(ends.shape[1]), ends), (size, size)), directed=False)[0]


def loops(graph):
    return len(graph.edges) - len(graph.places) + pieces(graph)


SHAPES = {
    "strip": strip(),
    "strip cut off": strip(cap="flat"),
    "slanting strip": strip(33.0),
    "rectangle": shapely.box(0, 0, 4, 2),
    "annulus": annulus(),
    "T": tee(),
    "plus": plus(),
    "rough strip": rough(0, 0.1, 300),
    "window": window(3, 2),
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_tape_covers_its_skeleton(name):
    shape = SHAPES[name]
    skeleton = skeleton_of(shape, PRUNE)
    assert skeleton.outside.shape == (0, 2)
    assert 1 <= skeleton.passes <= PASSES
    assert skeleton.graph.edges
    assert shape.covers(drawn(skeleton))


@pytest.mark.parametrize("degrees", [0.0, 33.0, 90.0])
def test_a_strip_has_its_middle_line(degrees):
    skeleton = skeleton_of(strip(degrees), PRUNE)
    way = -5.0 * unit(degrees), 5.0 * unit(degrees)
    assert len(skeleton.graph.edges) == 1
    assert off(skeleton, 1.1 * np.array(way)).max() < 0.1 * HALF
    assert radii(skeleton) == pytest.approx(HALF, rel=0.1)
    for end in way:
        assert np.hypot(*(tips(skeleton) - end).T).min() < 0.5 * HALF


@pytest.mark.parametrize("shape", [strip(cap="flat"), shapely.box(-5, -HALF, 5, HALF)])
def test_a_square_end_is_reached_by_the_last_disc(shape):
    skeleton = skeleton_of(shape, PRUNE)
    assert len(skeleton.graph.edges) == 1
    # The axis of a rectangle ends where its corners' bisectors meet, which are hair.
    assert np.sort(tips(skeleton)[:, 0]) == pytest.approx([HALF - 5.0, 5.0 - HALF], abs=0.1 * HALF)
    assert off(skeleton, [(-5, 0), (5, 0)]).max() < 0.1 * HALF
    assert radii(skeleton) == pytest.approx(HALF, rel=0.1)


def test_a_rectangle_has_the_axis_between_its_longer_sides():
    skeleton = skeleton_of(shapely.box(0, 0, 4, 2), PRUNE)
    assert len(skeleton.graph.edges) == 1
    assert off(skeleton, [(1, 1), (3, 1)]).max() < 0.1
    assert radii(skeleton) == pytest.approx(1.0, rel=0.1)


def test_an_annulus_has_one_closed_axis():
    skeleton = skeleton_of(annulus(), PRUNE)
    (edge,) = skeleton.graph.edges
    assert edge.ends == (0, 0)
    assert np.hypot(*edge.places.T) == pytest.approx(1.5, abs=0.1 * HALF)
    assert edge.radius == pytest.approx(HALF, rel=0.1)


def test_a_disc_is_no_curve():
    assert skeleton_of(shapely.Point(0.0, 0.0).buffer(1.0), PRUNE).graph.edges == ()


WAYS = {
    "T": (tee(), [[(-5, 0), (5, 0)], [(0, 0), (0, -5)]], [(-5, 0), (5, 0), (0, -5)]),
    "plus": (plus(), [[(-5, 0), (5, 0)], [(0, -5), (0, 5)]], [(-5, 0), (5, 0), (0, -5), (0, 5)]),
}


@pytest.mark.parametrize("name", WAYS)
def test_where_tapes_meet_each_has_an_arm_and_no_hair(name):
    shape, ways, ends = WAYS[name]
    skeleton = skeleton_of(shape, PRUNE)
    assert len(tips(skeleton)) == len(ends)
    assert loops(skeleton.graph) == 0
    for end in ends:
        assert np.hypot(*(tips(skeleton) - end).T).min() < 0.5 * HALF
    away = np.hypot(*places(skeleton).T) > 3.0 * HALF
    assert off(skeleton, *ways)[away].max() < 0.1 * HALF
    assert radii(skeleton)[away] == pytest.approx(HALF, rel=0.1)
    assert off(skeleton, *ways).max() < HALF


def test_the_fork_of_a_t_is_as_far_from_its_bar_as_from_its_corners():
    graph = skeleton_of(tee(), PRUNE, 0.05).graph
    (fork,) = np.flatnonzero(graph.degree == 3)
    # On the T's own axis, where 1/2 - y is the distance from a corner (1/2, -1/2).
    assert graph.places[fork] == pytest.approx((0.0, -0.125), abs=0.05 * HALF)
    assert graph.radius[fork] == pytest.approx(0.625, rel=0.02)


@pytest.mark.parametrize(
    ("shape", "holes", "parts"),
    [
        (strip(), 0, 1),
        (annulus(), 1, 1),
        (window(1, 1), 1, 1),
        (window(3, 2), 6, 1),
        (shapely.MultiPolygon([annulus(), shapely.box(3, 0, 9, 1), shapely.box(3, 2, 9, 3)]), 1, 3),
        (shapely.MultiPolygon([annulus(3.0), annulus(1.0)]), 2, 2),
    ],
)
def test_there_is_a_loop_for_each_hole_and_a_piece_for_each_part(shape, holes, parts):
    graph = skeleton_of(shape, PRUNE).graph
    assert loops(graph) == holes
    assert pieces(graph) == parts


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("count", [100, 400])
def test_a_rough_border_grows_no_hair(seed, count):
    skeleton = skeleton_of(rough(seed, 0.1, count), PRUNE)
    assert len(skeleton.graph.edges) == 1
    assert off(skeleton, [(-5, 0), (5, 0)]).max() < 0.1 * HALF
    assert radii(skeleton) == pytest.approx(HALF, rel=0.1)
    assert np.sort(tips(skeleton)[:, 0]) == pytest.approx([HALF - 5.0, 5.0 - HALF], abs=0.5 * HALF)


def test_the_more_is_pruned_the_less_is_left():
    shape = shapely.union_all([strip(), shapely.box(-0.2, 0.0, 0.2, 1.3)])
    thorn = [len(tips(skeleton_of(shape, prune))) for prune in (0.1, 3.0)]
    assert thorn == [3, 2]


@pytest.mark.parametrize("neck", [0.2, 0.1])
def test_a_neck_narrower_than_the_spacing_is_resampled_more_finely(neck):
    shape = dumbbell(neck)
    assert neck < SPACING * mean_width(shape)
    skeleton = skeleton_of(shape, PRUNE)
    assert 1 < skeleton.passes <= PASSES
    assert len(skeleton.outside) == 0
    assert skeleton_of(dumbbell(1.0), PRUNE).passes == 1


def test_a_finer_first_spacing_needs_fewer_passes():
    passes = [skeleton_of(dumbbell(0.1), PRUNE, spacing).passes for spacing in (0.4, 0.05)]
    assert passes[0] > passes[1] == 1


def test_running_out_of_passes_says_where_and_keeps_what_leaves_the_tape_least():
    shape = dumbbell(0.01)
    skeleton = skeleton_of(shape, PRUNE)
    assert skeleton.passes <= PASSES
    assert len(skeleton.outside) > 0
    assert np.all(np.abs(skeleton.outside) <= (1.6, 0.1))  # in the neck
    # The first pass leaves the tape in the fewest segments, which are the longest and farthest away.
    assert shapely.distance(shape, shapely.points(places(skeleton))).max() < 0.1 * HALF


def test_a_first_spacing_far_too_coarse_only_takes_longer():
    width = mean_width(tee())
    for spacing in (2.0 * width, 10.0 * width, 1e9 * width):
        skeleton = skeleton_of(tee(), PRUNE, spacing)
        assert len(tips(skeleton)) == 3
        assert len(skeleton.outside) == 0


def test_too_many_samples_are_refused():
    shape = strip()
    with pytest.raises(InvalidParameter, match="resample"):
        skeleton_of(shape, PRUNE, 0.9 * shape.length / MOST_SAMPLES)


@pytest.mark.parametrize("exponent", [-20, 30])
def test_the_unit_of_length_changes_nothing(exponent):
    factor = 2.0**exponent
    one = skeleton_of(tee(), PRUNE)
    other = skeleton_of(shapely.transform(tee(), lambda xy: factor * xy), PRUNE)
    assert other.passes == one.passes
    assert len(other.graph.edges) == len(one.graph.edges)
    far = shapely.hausdorff_distance(drawn(one), shapely.transform(drawn(other), lambda xy: xy / factor))
    assert far < 1e-6
