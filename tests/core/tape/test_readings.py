import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from core.refine.crossings import crossings
from core.refine.polyline import Polyline
from core.tape.bends import GAP
from core.tape.readings import read_crossings
from tests.core.shapes import rotation
from tests.core.tape.drawings import (
    circle,
    double_eight,
    drawn,
    eight,
    extent,
    flat,
    keep_clear,
    limacon,
    lissajous,
    odd,
    ribbon,
    rose,
    scribble,
    segment,
)

SEEDS = st.integers(0, 2**32 - 1)
NON_CROSSING = ["split", "waist"]


def counts(lines):
    closed = sum(line.closed for line in lines)
    return closed, len(lines) - closed


def kinds(curves, sigma=0.01, touching=0.0):
    """Numbers of closed and open curves in each of the readings that change curves."""
    return [counts(read_crossings(curves, mode, sigma, touching)) for mode in ("graph", "split", "waist")]


def lines_at_random(seed, count=3, waves=6):
    rng = np.random.default_rng(seed)
    return [scribble(rng, bool(rng.integers(2)), waves) for _ in range(rng.integers(1, count + 1))]


def groups(curves):
    """Number of groups of curves that are connected by crossings."""
    lines = np.array([drawn(curve) for curve in curves])
    return connected_components(shapely.intersects(lines[:, None], lines))[0]


@pytest.mark.parametrize(
    ("curves", "arcs", "lobes"),
    [
        ([eight()], 2, 2),
        ([double_eight()], 6, 4),
        ([lissajous()], 14, 6),
        ([limacon()], 2, 2),
        ([circle(), circle(1.0)], 4, 2),
        ([circle(), circle(1.95)], 4, 2),
    ],
)
@pytest.mark.parametrize("sigma", [0.0, 1e-4, 0.01])
def test_closed_curves_are_lobes_or_one_curve(curves, arcs, lobes, sigma):
    graph, split, waist = kinds(curves, sigma)
    assert split == (lobes, 0)
    assert waist == (1, 0)
    assert graph == (0, arcs)
    for mode in NON_CROSSING:
        assert keep_clear(read_crossings(curves, mode, sigma))


@pytest.mark.parametrize("petals", [3, 5])
def test_petals_pass_through_one_place_as_far_as_the_noise_can_tell(petals):
    assert kinds([rose(petals)]) == [(0, petals), (petals, 0), (1, 0)]
    for mode in NON_CROSSING:
        assert keep_clear(read_crossings([rose(petals)], mode, 0.01))


def test_the_loop_of_a_ribbon_comes_off_or_stays():
    assert kinds([ribbon()]) == [(0, 3), (1, 1), (0, 1)]
    for mode in NON_CROSSING:
        assert keep_clear(read_crossings([ribbon()], mode, 0.01))


@pytest.mark.parametrize("reach", [-0.02, 0.0, 0.02])
def test_a_curve_that_ends_on_another_still_does(reach):
    curves = [circle(), segment((1.0 + reach, 0.0), (3.0, 0.0))]
    assert kinds(curves, touching=0.03) == [(0, 2), (1, 1), (1, 1)]
    for mode in ("graph", *NON_CROSSING):
        read = read_crossings(curves, mode, 0.01, 0.03)
        assert crossings(read) == []
        assert shapely.distance(drawn(read[0]), drawn(read[1])) < 1e-12


def test_straight_on_is_as_it_was():
    curves = [eight(), segment((-1.0, 0.1), (1.0, 0.1))]
    assert read_crossings(curves, "through", 0.01) == curves


def test_curves_that_meet_nothing_are_as_they_were():
    curves = [circle(), circle(0.2, 0.0, 0.5), segment((2.0, 0.0), (3.0, 0.0))]
    for mode in ("graph", *NON_CROSSING):
        assert read_crossings(curves, mode, 0.01) == curves
        assert read_crossings([], mode, 0.01) == []


@pytest.mark.parametrize("mode", NON_CROSSING)
@settings(max_examples=25, deadline=None)
@given(seed=SEEDS, share=st.sampled_from([0.0, 1e-4, 1e-3, 0.01, 0.03]))
def test_no_two_curves_meet(mode, seed, share):
    curves = lines_at_random(seed)
    assert keep_clear(read_crossings(curves, mode, share * extent(curves)))


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.sampled_from([1e-4, 1e-3, 0.01]))
def test_only_the_surroundings_of_crossings_change(seed, share):
    curves = lines_at_random(seed)
    met = np.array([m.place for m in crossings(curves)]).reshape(-1, 3)
    assume(len(met) > 0)
    sigma = share * extent(curves)
    before = np.concatenate([curve.vertices for curve in curves])
    away = np.linalg.norm(before[:, None] - met, axis=2).min(axis=1) > 60.0 * sigma
    together = shapely.union_all([drawn(curve) for curve in curves])
    for mode in NON_CROSSING:
        after = np.concatenate([line.vertices for line in read_crossings(curves, mode, sigma)])
        kept = {tuple(v) for v in after}
        if mode == "waist":
            assert all(tuple(v) in kept for v in before[away])
        assert shapely.distance(shapely.points(after[:, :2]), together).max() < 4.0 * sigma + 1e-3 * extent(
            curves
        )


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.integers(1, 3))
def test_split_curves_are_the_outlines_and_the_holes_of_black_faces(seed, count):
    rng = np.random.default_rng(seed)
    curves = [scribble(rng) for _ in range(count)]
    cut = shapely.union_all([drawn(curve) for curve in curves])
    faces = list(shapely.polygonize([cut]).geoms)
    parts = groups(curves)
    assume(parts == 1 and len(crossings(curves)) > 0)
    black = [face for face in faces if odd(curves, np.array(face.representative_point().coords[0]))]
    # Polygons may not touch themselves: where a black face does, it has a hole.
    due = sum(1 + len(face.interiors) for face in black)
    assert counts(read_crossings(curves, "split", 0.0)) == (due, 0)


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.sampled_from([0.0, 1e-3, 0.02]))
def test_waists_make_one_curve_of_each_group_that_meets(seed, share):
    rng = np.random.default_rng(seed)
    curves = [
        Polyline(scribble(rng, waves=3).vertices + 3.0 * rng.normal(size=3) * (1, 1, 0), True)
        for _ in range(4)
    ]
    parts = groups(curves)
    assert counts(read_crossings(curves, "waist", share)) == (parts, 0)


@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_arcs_of_a_graph_make_up_the_curves(seed):
    curves = lines_at_random(seed)
    arcs = read_crossings(curves, "graph", 0.0)
    assert crossings(arcs) == []
    whole, parts = (sum(line.length for line in lines) for lines in (curves, arcs))
    assert parts == pytest.approx(whole, rel=1e-4)


@pytest.mark.parametrize("mode", ["graph", *NON_CROSSING])
@settings(max_examples=10, deadline=None)
@given(seed=SEEDS, scale=st.sampled_from([1e-6, 1.0, 1e6]))
def test_readings_turn_and_grow_with_the_curves(mode, seed, scale):
    curves = lines_at_random(seed)
    turn = np.eye(3)
    turn[:2, :2] = rotation(np.random.default_rng(seed), 2) * scale
    moved = [Polyline(curve.vertices @ turn.T, curve.closed) for curve in curves]
    sigma = 0.003 * extent(curves)
    there = [Polyline(line.vertices @ turn.T, line.closed) for line in read_crossings(curves, mode, sigma)]
    back = read_crossings(moved, mode, sigma * scale)
    assert counts(there) == counts(back)
    lengths = [np.sort([line.length for line in lines]) for lines in (there, back)]
    np.testing.assert_allclose(*lengths, rtol=1e-6)


@pytest.mark.parametrize("mode", NON_CROSSING)
@settings(max_examples=10, deadline=None)
@given(seed=SEEDS)
def test_the_order_and_the_direction_of_the_curves_do_not_matter(mode, seed):
    curves = lines_at_random(seed)
    sigma = 0.003 * extent(curves)
    back = [Polyline(curve.vertices[::-1], curve.closed) for curve in curves[::-1]]
    lengths = [np.sort([line.length for line in read_crossings(x, mode, sigma)]) for x in (curves, back)]
    np.testing.assert_allclose(*lengths, rtol=1e-6)


@pytest.mark.parametrize("degrees", [0.1, 1.0, 5.0])
@pytest.mark.parametrize("sigma", [0.0, 1e-3, 0.1])
def test_curves_that_nearly_touch_are_kept_apart(degrees, sigma):
    along = np.array((1.0, np.tan(np.radians(degrees / 2))))
    lines = [segment(-v, v) for v in (along, along * (1.0, -1.0))]
    grazing = [circle(), circle(2.0 * np.cos(np.radians(degrees / 2)))]
    for mode in NON_CROSSING:
        assert keep_clear(read_crossings(lines, mode, sigma))
        read = read_crossings(grazing, mode, sigma)
        assert keep_clear(read)
        assert counts(read) == (2 if mode == "split" else 1, 0)


def test_branches_almost_through_one_place_are_as_through_it():
    lines = []
    for angle in np.radians([10.0, 70.0, 130.0]):
        along = np.array((np.cos(angle), np.sin(angle)))
        across = 0.004 * np.array((-along[1], along[0]))
        lines.append(segment(across - along, across + along))
    for mode in NON_CROSSING:
        read = read_crossings(lines, mode, 0.01)
        assert counts(read) == (0, 3)
        gaps = [shapely.distance(drawn(a), drawn(b)) for a, b in zip(read, read[1:] + read[:1], strict=True)]
        assert min(gaps) > 0.5 * GAP * 0.01


def test_a_closed_curve_smaller_than_the_noise_is_not_cut_off():
    curves = [circle(), circle(1.0, 0.0, 0.02)]
    assert counts(read_crossings(curves, "split", 0.001)) == (2, 0)
    (line,) = read_crossings(curves, "split", 0.02)
    assert line.length > 6.0


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.sampled_from([0.0, 0.01]))
def test_a_tangle_on_a_lattice_is_read_all_the_same(seed, sigma):
    # Vertices on edges, common vertices, stretches that coincide.
    rng = np.random.default_rng(seed)
    curves = [flat(rng.integers(0, 6, (rng.integers(3, 9), 2)), bool(rng.integers(2))) for _ in range(2)]
    for mode in NON_CROSSING:
        assert crossings(read_crossings(curves, mode, sigma)) == []


@pytest.mark.parametrize("sigma", [0.0, 0.01, 10.0])
@pytest.mark.parametrize("touching", [0.0, 0.1, 10.0])
def test_curves_of_hardly_any_extent_are_no_obstacle(sigma, touching):
    dot, doubled = flat([(0.3, 0.3)] * 5, True), flat([(0, 0), (1, 1)], True)
    for curves in ([dot], [dot, eight()], [doubled, segment((0, 1), (1, 0))], [eight(), eight()]):
        for mode in ("graph", *NON_CROSSING):
            read = read_crossings(curves, mode, sigma, touching)
            assert all(np.all(np.isfinite(line.vertices)) for line in read)


def test_hundreds_of_crossings_are_undone():
    rng = np.random.default_rng(5)
    tangle = scribble(rng, waves=40, count=3000)
    assert len(crossings([tangle])) > 100
    for mode in NON_CROSSING:
        read = read_crossings([tangle], mode, 1e-3 * extent([tangle]))
        assert keep_clear(read)
        assert mode == "split" or counts(read) == (1, 0)
