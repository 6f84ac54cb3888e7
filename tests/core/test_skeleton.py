from functools import cache, lru_cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from core.errors import DegenerateInput, InvalidInput, InvalidParameter, InvalidPoints, TapelineError
from core.methods import partition, pca, skeleton
from core.parameters import PcaParameters, SkeletonParameters
from core.truth import names, oracle_rms, point_set
from tests.core.answers import assert_sound, moved_back, same_curves, scored, topology
from tests.core.shapes import arc, diagonal, distances, in_a_tilted_plane, line, rotation

SEEDS = st.integers(0, 2**32 - 1)
READINGS = ["through", "split", "waist", "graph"]


def reconstruct(points, **parameters):
    return skeleton(points, SkeletonParameters(**parameters))


def same(answer, first, points):
    """Whether two answers have the same curves: open ones but for rounding.

    The feet on a closed curve are counted from where its skeleton begins, which the order and the
    position of the points decide; its regression moves with that by a small share of the noise.
    """
    limit = 1e-5 if any(topology(first)) else 1e-6
    return same_curves(answer, first) < limit * diagonal(points)


def codes(answer):
    return [warning.code for warning in answer.warnings]


def ends_of(answer):
    """First and last vertices of the open curves, (K, d)."""
    return np.concatenate([c.vertices[[0, -1]] for c in answer.curves if not c.closed])


# ---------------------------------------------------------------- the right curves

CROSSING = {  # family: samples, noise
    "figure_8": (1000, 0.008),
    "double_8": (2000, 0.005),
    "two_circles": (1500, 0.006),
    "ribbon": (1200, 0.006),
    "t_junction": (1200, 0.008),
}
CLOSED = ["figure_8", "double_8", "two_circles"]


@cache
def read(name, reading):
    n, sigma = CROSSING[name]
    sample = point_set(name, n=n, sigma=sigma, seed=1)
    return sample, reconstruct(sample.points, crossings=reading)


@pytest.mark.parametrize("name", ["circle", "nested", "s_shape", "disjoint", "tilted"])
def test_curves_that_do_not_cross_come_out_as_well_as_from_the_march(name):
    sample = point_set(name, n=1200, sigma=0.008, seed=2)
    answer = skeleton(sample.points)
    got = scored(answer, sample)
    assert got.topology_right
    assert got.rms < 2.0 * oracle_rms(sample)
    assert answer.warnings == ()
    assert answer.method == "skeleton"
    assert answer.sampling.sigma == pytest.approx(sample.sigma, rel=0.08)
    assert same_curves(answer, pca(sample.points)) < sample.sigma


@pytest.mark.parametrize("name", CROSSING)
def test_straight_through_a_crossing(name):
    sample, answer = read(name, "through")
    assert scored(answer, sample).topology_right
    assert answer.warnings == ()
    assert len(answer.crossings) == len(sample.crossings)
    for place in sample.crossings:
        found = [np.linalg.norm(crossing.location - place) for crossing in answer.crossings]
        assert min(found) < 4.0 * sample.sigma


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("reading", ["split", "waist"])
def test_readings_without_crossings(name, reading):
    sample, answer = read(name, reading)
    assert scored(answer, sample, reading).topology_right
    assert all(curve.closed for curve in answer.curves)
    assert answer.crossings == ()


def test_how_many_curves_each_reading_has():
    counts = {name: [len(read(name, mode)[1].curves) for mode in READINGS[:3]] for name in CLOSED}
    assert counts == {"figure_8": [1, 2, 1], "double_8": [1, 4, 1], "two_circles": [2, 2, 1]}


@pytest.mark.parametrize("name", ["figure_8", "double_8", "two_circles", "ribbon"])
def test_arcs_of_a_graph_end_at_crossings(name):
    sample, answer = read(name, "graph")
    loose = 2 * (name == "ribbon")
    # Four arcs' ends meet at each crossing.
    assert 2 * len(answer.curves) == 4 * len(sample.crossings) + loose
    assert not any(curve.closed for curve in answer.curves)
    assert answer.crossings == ()
    places = [*sample.crossings, *sample.curves[0].vertices[[0, -1]][:loose]]
    ends = ends_of(answer)
    away = np.linalg.norm(ends[:, None] - np.array(places), axis=2)
    assert away.min(axis=1).max() < 5.0 * sample.sigma
    # Those of one crossing at the very same place.
    for place in sample.crossings:
        here = ends[np.linalg.norm(ends - place, axis=1) < 5.0 * sample.sigma]
        assert len(here) == 4
        assert np.ptp(here, axis=0).max() < 1e-9


def test_readings_have_the_same_samples_and_noise():
    for name in ("figure_8", "ribbon"):
        _, through = read(name, "through")
        for mode in READINGS[1:]:
            _, answer = read(name, mode)
            assert answer.sampling.sigma == pytest.approx(through.sampling.sigma, rel=0.1)
            assert sum(c.length for c in answer.curves) == pytest.approx(
                sum(c.length for c in through.curves), rel=0.03
            )


def test_the_stem_of_a_junction_ends_on_the_bar():
    sample, answer = read("t_junction", "through")
    bar, stem = sorted(answer.curves, key=lambda c: -c.length)
    assert not bar.closed
    assert not stem.closed
    gaps = distances(stem.vertices[[0, -1]], bar.vertices, False)
    assert gaps.min() < 4.0 * sample.sigma
    end = stem.vertices[[0, -1]][int(np.argmin(gaps))]
    assert np.linalg.norm(sample.junctions - end, axis=1).min() < 5.0 * sample.sigma


@pytest.mark.parametrize("reading", READINGS)
def test_crossings_in_a_tilted_plane(reading):
    sample, flat = read("figure_8", reading)
    points, turn = in_a_tilted_plane(sample.points, 3)
    answer = reconstruct(points, crossings=reading)
    assert topology(answer) == topology(flat)
    assert len(answer.crossings) == len(flat.crossings)
    (frame,) = answer.frames
    assert abs(frame.axes[2] @ turn[:, 2]) == pytest.approx(1.0)
    shift = points[0] - np.append(sample.points[0], 0.0) @ turn.T
    back = moved_back(answer, lambda v: (v - shift) @ turn)
    height = np.concatenate([c.vertices[:, 2] for c in back.curves])
    assert np.abs(height).max() < 1e-9
    in_plane = moved_back(back, lambda v: v[:, :2])
    # Whatever the reading, the curves are those of a closed one.
    assert same_curves(in_plane, flat) < 1e-3 * diagonal(points)


def test_a_helix_is_projected_with_a_warning():
    sample = point_set("helix", n=1000, sigma=0.006)
    answer = skeleton(sample.points)
    bent = [w for w in answer.warnings if w.code == "not-quasi-planar"]
    assert len(bent) == 1
    assert "projected" in bent[0].message
    assert len(bent[0].location) == 3
    (frame,) = answer.frames
    for curve in answer.curves:
        assert np.abs((curve.vertices - frame.origin) @ frame.axes[2]).max() < 1e-9
    assert_sound(answer, sample.points)


# ---------------------------------------------------------------- invariance

FAMILIES = ["ellipse", "nested", "figure_8", "two_circles", "tilted", "s_shape", "t_junction", "ribbon"]
CASES = st.tuples(st.sampled_from(FAMILIES), st.integers(0, 1))


@lru_cache(maxsize=32)
def base(case):
    name, seed = case
    points = point_set(name, n=700, sigma=0.008, seed=seed).points
    return points, skeleton(points)


def assert_same(case, answer, back):
    points, first = base(case)
    assert len(answer.crossings) == len(first.crossings)
    assert same(moved_back(answer, back), first, points)
    assert [len(part.holes) for part in answer.tape] == [len(part.holes) for part in first.tape]
    assert sorted(n.degree for n in answer.graph.nodes) == sorted(n.degree for n in first.graph.nodes)


@settings(max_examples=4, deadline=None)
@given(CASES, SEEDS)
def test_the_order_of_the_points_does_not_matter(case, seed):
    points, first = base(case)
    order = np.random.default_rng(seed).permutation(len(points))
    answer = skeleton(points[order])
    assert_same(case, answer, lambda v: v)
    np.testing.assert_array_equal(np.sort(order[answer.outliers]), first.outliers)


@settings(max_examples=4, deadline=None)
@given(CASES, SEEDS, st.booleans())
def test_a_rotated_or_mirrored_cloud_has_such_curves(case, seed, mirrored):
    points, _ = base(case)
    turn = rotation(np.random.default_rng(seed), points.shape[1])
    if mirrored:
        turn[:, 0] *= -1.0
    assert_same(case, skeleton(points @ turn.T), lambda v: v @ turn)


@settings(max_examples=4, deadline=None)
@given(CASES, st.floats(-6.0, 6.0))
def test_a_scaled_cloud_has_the_scaled_curves(case, power):
    points, first = base(case)
    factor = 10.0**power
    answer = skeleton(points * factor)
    assert_same(case, answer, lambda v: v / factor)
    assert answer.sampling.sigma == pytest.approx(factor * first.sampling.sigma, rel=1e-5)
    assert answer.sampling.density == pytest.approx(first.sampling.density / factor, rel=1e-5)


@settings(max_examples=4, deadline=None)
@given(CASES, SEEDS, st.sampled_from([1.0, 1e3]))
def test_a_translated_cloud_has_the_translated_curves(case, seed, far):
    points, _ = base(case)
    way = far * np.random.default_rng(seed).normal(size=points.shape[1])
    assert_same(case, skeleton(points + way), lambda v: v - way)


def test_the_same_points_give_the_same_bits_whatever_the_seed():
    points, first = base(("figure_8", 0))
    for seed in (0, 1):
        again = reconstruct(points.copy(), seed=seed)
        for one, two in zip(first.curves, again.curves, strict=True):
            np.testing.assert_array_equal(one.vertices, two.vertices)


def test_the_points_are_left_alone():
    points = base(("figure_8", 0))[0].copy()
    before = points.copy()
    points.setflags(write=False)
    skeleton(points, stages=True)
    np.testing.assert_array_equal(points, before)


# ---------------------------------------------------------------- difficult samples


@pytest.mark.parametrize("name", ["circle", "s_shape", "figure_8"])
def test_samples_without_noise(name):
    sample = point_set(name, n=400, sigma=0.0, seed=1)
    answer = skeleton(sample.points)
    assert scored(answer, sample).topology_right
    assert set(codes(answer)) <= {"march-instead"}
    assert scored(answer, sample).rms < 2e-3 * diagonal(sample.points)
    assert answer.sampling.sigma < 2e-3 * diagonal(sample.points)


@pytest.mark.parametrize("way", [[0.6, 0.8], [0.48, 0.6, 0.64]])
def test_points_on_a_straight_line(way):
    along = np.random.default_rng(0).uniform(0.0, 5.0, 400)
    answer = skeleton(np.outer(along, way) + 2.0)
    (curve,) = answer.curves
    assert not curve.closed
    assert curve.length == pytest.approx(5.0, rel=0.02)
    ends = 2.0 + np.outer([0.0, 5.0], way)
    assert distances(curve.vertices, ends, False).max() < 1e-6
    assert codes(answer) == ["march-instead"]
    assert len(answer.warnings[0].location) == len(way)
    # Without width there is no polygon.
    assert answer.tape == ()
    assert answer.graph is None
    assert answer.containment is None


@pytest.mark.parametrize("name", ["circle", "figure_8"])
def test_noise_that_hides_the_detail_is_told(name):
    sample = point_set(name, n=1000, sigma=0.08, seed=0)
    answer = skeleton(sample.points)
    assert_sound(answer, sample.points)
    hidden = [w for w in answer.warnings if w.code == "noise-hides-detail"]
    assert hidden
    low, high = sample.points.min(axis=0), sample.points.max(axis=0)
    for warning in hidden:
        assert np.all((low <= warning.location) & (warning.location <= high))


def test_a_crossing_at_ten_degrees_is_ambiguous():
    sigma, angle = 0.01, np.radians(10.0)
    sticks = [line(1000, sigma, 4.0, seed=seed) for seed in (1, 2)]
    sticks[1] = sticks[1] @ np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
    points = np.concatenate(sticks)
    answer = skeleton(points)
    assert_sound(answer, points)
    places = [w.location for w in answer.warnings if w.code == "ambiguous-crossing"]
    assert places
    # The sticks are within three sigma of each other as far as this.
    assert np.linalg.norm(places, axis=1).max() < 3.0 * sigma / np.sin(angle)


def test_a_clear_crossing_is_not_ambiguous():
    sticks = line(800, 0.01, 2.0, seed=1), line(800, 0.01, 2.0, seed=2)[:, ::-1]
    answer = skeleton(np.concatenate(sticks))
    assert topology(answer) == [False, False]
    assert answer.warnings == ()
    (crossing,) = answer.crossings
    assert np.linalg.norm(crossing.location) < 0.03
    assert crossing.angle == pytest.approx(90.0, abs=3.0)


@pytest.mark.parametrize("name", ["circle", "figure_8"])
def test_samples_are_kept_or_rejected_as_told(name):
    sample = point_set(name, n=1200, sigma=0.008, outliers=0.05, seed=7)
    answers = [reconstruct(sample.points, outliers=mode) for mode in ("keep", "auto", "reject")]
    kept, auto, strict = (set(answer.outliers.tolist()) for answer in answers)
    assert kept <= auto < strict
    assert kept == set(np.flatnonzero(partition(sample.points).labels < 0).tolist())
    for answer in answers:
        assert topology(answer) == [True]
        assert len(answer.crossings) == len(sample.crossings)
        assert 0.9 * sample.sigma < answer.sampling.sigma < 2.0 * sample.sigma
    away = np.min([distances(sample.points, c.vertices, True) for c in answers[1].curves], axis=0)
    clear = np.flatnonzero((sample.curve_of < 0) & (away > 5.0 * sample.sigma))
    assert np.isin(clear, answers[1].outliers).all()


def test_repeated_samples_change_little():
    points, first = base(("figure_8", 1))
    answer = skeleton(np.repeat(points, 3, axis=0))
    assert len(answer.crossings) == 1
    assert same_curves(first, answer) < 0.01 * diagonal(points)


@pytest.mark.parametrize("grid", [0.01, 0.04])
def test_coordinates_may_be_quantised(grid):
    sample = point_set("figure_8", n=2000, sigma=0.008, seed=1)
    answer = skeleton(np.round(sample.points / grid) * grid)
    got = scored(answer, sample)
    assert got.topology_right
    assert got.rms < 0.5 * sample.sigma + 0.5 * grid


# ---------------------------------------------------------------- parameters


def test_the_spacing_of_the_vertices():
    points = arc(1000, 0.01)
    for spacing in (0.02, 0.3):
        for refine in (True, False):
            (curve,) = reconstruct(points, vertex_spacing=spacing, refine=refine).curves
            ring = np.concatenate((curve.vertices, curve.vertices[:1]))
            steps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
            assert steps.max() < 1.03 * spacing
            assert steps.min() > 0.7 * spacing


@pytest.mark.parametrize("wished", ["vertex_spacing", "resample"])
def test_a_spacing_that_no_memory_could_hold_is_refused(wished):
    with pytest.raises(InvalidParameter) as raised:
        reconstruct(arc(300, 0.01), **{wished: 1e-13})
    assert wished in raised.value.loc


@pytest.mark.parametrize("name", ["s_shape", "figure_8", "two_circles"])
def test_curves_may_be_left_unrefined(name):
    sample = point_set(name, n=1000, sigma=0.008, seed=4)
    rough, fine = (reconstruct(sample.points, refine=refine) for refine in (False, True))
    assert topology(rough) == topology(fine)
    assert 1e-6 * diagonal(sample.points) < same_curves(rough, fine) < 3.0 * sample.sigma
    assert scored(rough, sample).topology_right
    assert scored(fine, sample).rms < 2.0 * oracle_rms(sample)


EXTREMES = [
    *({name: value} for name in ("f_l", "f_a") for value in (1e-300, 1e9)),
    *({"f_d": value} for value in (1e-300, 1e-9, 100.0)),
    *({"resample": value} for value in (1e3, 1e300)),
    *({"prune": value} for value in (0.0, 100.0)),
    {"f_l": 1e-9, "f_a": 1e-9, "f_d": 1e-9},
    {"f_l": 1e9, "f_a": 1e9, "f_d": 100.0},
]


@pytest.mark.parametrize("parameters", EXTREMES)
def test_extreme_parameters_are_answered_or_refused(parameters):
    points = base(("figure_8", 0))[0]
    try:
        answer = reconstruct(points, **parameters)
    except InvalidInput as error:
        assert error.loc[-1] in parameters  # noqa: PT017 - either is right
        return
    assert_sound(answer, points)


def test_a_factor_so_large_that_all_triangles_are_small_fills_the_holes():
    points = arc(600, 0.02)
    tape = reconstruct(points, f_l=1e9).tape
    assert all(not part.holes for part in tape)
    assert [len(part.holes) for part in skeleton(points).tape] == [1]


@pytest.mark.parametrize("parameters", [{"f_d": 1.0}, {"f_d": 2.0}, {"prune": 1.0}, {"prune": 4.0}])
def test_reasonable_parameters_change_no_topology(parameters):
    sample, _ = read("figure_8", "through")
    assert scored(reconstruct(sample.points, **parameters), sample).topology_right


def test_resample_is_in_the_units_of_the_points():
    points = 100.0 * arc(600, 0.02)
    for spacing in (0.5, 1.0):
        answer = skeleton(points, SkeletonParameters(resample=spacing), stages=True)
        assert answer.containment.passes == 1
        for ring in answer.stages.border:
            steps = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
            assert np.median(steps) == pytest.approx(spacing, rel=0.1)


def test_a_border_sampled_too_coarsely_is_resampled():
    points = arc(600, 0.02)
    answer = reconstruct(points, resample=3.0)
    assert answer.containment.passes > 1
    assert answer.containment.covered
    assert same_curves(answer, skeleton(points)) < 0.02


# ---------------------------------------------------------------- what determines no curve


@pytest.mark.parametrize("points", [[[0.0, 0.0]], [[3.0, 4.0]] * 100, [[3.0, 4.0, 5.0]] * 100])
def test_points_that_determine_no_curve(points):
    with pytest.raises(DegenerateInput) as raised:
        skeleton(points)
    assert raised.value.loc == ("points",)


def test_the_first_number_that_is_not_finite_is_named():
    points = arc(50, 0.01)
    points[17, 1] = np.nan
    with pytest.raises(InvalidPoints) as raised:
        skeleton(points)
    assert raised.value.loc == ("points", 17, 1)


def assert_sound_skeleton(answer, points):
    assert_sound(answer, points)
    dimension = np.shape(points)[1]
    for part in answer.tape:
        for ring in (part.outer, *part.holes):
            assert ring.shape[1] == dimension
            assert len(ring) >= 3
            assert np.isfinite(ring).all()
    for warning in answer.warnings:
        assert warning.location is None or np.isfinite(warning.location).all()
    assert (answer.graph is None) == (answer.containment is None) == (not answer.tape)
    if answer.graph is not None:
        for edge in answer.graph.edges:
            assert edge.vertices.shape == (len(edge.widths), dimension)
            assert np.isfinite(edge.vertices).all()
            assert np.isfinite([edge.length, *edge.widths]).all()


def assert_sound_or_refused(points, **parameters):
    """The answer, if there is one."""
    try:
        answer = skeleton(points, SkeletonParameters(**parameters), stages=True)
    except TapelineError:
        return None
    assert_sound_skeleton(answer, points)
    return answer


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_uniform_cloud_does_not_raise(dimension):
    points = np.random.default_rng(0).uniform(size=(800, dimension))
    assert assert_sound_or_refused(points) is not None


@pytest.mark.parametrize("size", [4, 30])
def test_a_full_grid_is_answered_or_refused(size):
    rows = np.linspace(0.0, 1.0, size)
    assert_sound_or_refused(np.stack(np.meshgrid(rows, rows), axis=-1).reshape(-1, 2))


@pytest.mark.parametrize(("n", "dimension"), [(30, 2), (60, 3)])
@pytest.mark.parametrize("seed", [0, 11])
def test_the_largest_and_smallest_doubles_are_answered_or_refused(n, dimension, seed):
    extremes = [0.0, 1.0, -1.0, 1e308, -1e308, 5e-324, 1e-300, 1e300, 1.7e308]
    assert_sound_or_refused(np.random.default_rng(seed).choice(extremes, (n, dimension)))


@pytest.mark.parametrize("scale", [1e-310, 1e-150, 1e150, 1e307])
def test_a_circle_of_any_size_is_closed(scale):
    answer = assert_sound_or_refused(scale * arc(500, 0.02))
    assert answer is not None
    if scale > 1e-300:  # the smallest doubles have few digits
        assert topology(answer) == [True]


FINITE = st.floats(allow_nan=False, allow_infinity=False)
SHAPES = st.tuples(st.integers(1, 40), st.sampled_from([2, 3]))


@settings(max_examples=30, deadline=None)
@given(hnp.arrays(np.float64, SHAPES, elements=FINITE))
def test_any_finite_numbers_are_answered_or_refused(points):
    assert_sound_or_refused(points)


@settings(max_examples=20, deadline=None)
@given(hnp.arrays(np.float64, SHAPES, elements=st.integers(-3, 3).map(float)))
def test_points_on_a_coarse_grid_are_answered_or_refused(points):
    assert_sound_or_refused(points)


@settings(max_examples=20, deadline=None)
@given(
    SEEDS,
    st.integers(6, 80),
    st.sampled_from([2, 3]),
    st.sampled_from([0.0, 1e-9, 1e-3, 1.0]),
    st.sampled_from([0.0, 1e12]),
    st.sampled_from([1e-310, 1e-150, 1.0, 1e150, 1e290]),
)
def test_blobs_and_nearly_collinear_points_are_answered_or_refused(seed, n, dimension, width, offset, scale):
    rng = np.random.default_rng(seed)
    turn = rotation(rng, dimension)
    points = rng.normal(size=(n, dimension)) * np.append(1.0, np.full(dimension - 1, width)) @ turn.T
    assert_sound_or_refused(scale * (points + offset))


PARAMETERS = st.fixed_dictionaries(
    {},
    optional={
        "crossings": st.sampled_from(READINGS),
        "epsilon": st.sampled_from([1e-3, 0.1, 1e3]),
        "f_d": st.sampled_from([1e-2, 1.0, 100.0]),
        "f_a": st.sampled_from([1e-3, 1.0, 1e3]),
        "f_l": st.sampled_from([1e-3, 1.0, 1e3]),
        "resample": st.sampled_from([1e-2, 0.1, 1e3]),
        "prune": st.sampled_from([0.0, 0.5, 100.0]),
        "vertex_spacing": st.sampled_from([1e-2, 1.0, 1e6]),
        "min_component_size": st.sampled_from([1, 5, 1000]),
        "outliers": st.sampled_from(["keep", "reject"]),
        "refine": st.just(False),
    },
)


@settings(max_examples=20, deadline=None)
@example(
    0,
    "helix",
    10,
    {"crossings": "split", "f_d": 0.01, "outliers": "keep", "min_component_size": 1, "vertex_spacing": 0.01},
)
@given(SEEDS, st.sampled_from(["figure_8", "line", "blob", "helix"]), st.integers(10, 150), PARAMETERS)
def test_any_parameters_are_answered_or_refused(seed, shape, n, parameters):
    points = {
        "line": lambda: line(n, 0.02, seed=seed, dimension=3),
        "blob": lambda: np.random.default_rng(seed).normal(size=(n, 2)),
    }.get(shape, lambda: point_set(shape, n=n, sigma=0.01, seed=seed % 1000).points)()
    assert_sound_or_refused(points, **parameters)


@pytest.mark.parametrize("name", names())
def test_few_samples_of_any_family_are_answered_or_refused(name):
    for n in (11, 60):
        assert_sound_or_refused(point_set(name, n=n, sigma=0.02, seed=n).points)


def test_the_march_knows_no_tape():
    points = base(("ellipse", 0))[0]
    answer = pca(points, PcaParameters())
    assert answer.tape is answer.graph is answer.containment is None
