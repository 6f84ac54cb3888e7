from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from core.errors import DegenerateInput, InvalidParameter, InvalidPoints, TapelineError
from core.methods import partition, pca
from core.parameters import PartitionParameters, PcaParameters
from core.truth import names, oracle_rms, point_set
from core.truth.families import BUILT_IN
from tests.core.answers import assert_sound, moved_back, same_curves, scored, topology
from tests.core.shapes import arc, diagonal, distances, in_a_tilted_plane, line, rotation

SMOOTH = [f.name for f in BUILT_IN if f.smooth and f.non_crossing]
SEEDS = st.integers(0, 2**32 - 1)


def reconstruct(points, **parameters):
    return pca(points, PcaParameters(**parameters))


# ---------------------------------------------------------------- the right curves


@pytest.mark.parametrize(("n", "sigma", "seed"), [(1000, 0.01, 0), (4000, 0.02, 1)])
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_families_come_out_right_without_a_parameter(name, n, sigma, seed):
    sample = point_set(name, n=n, sigma=sigma, seed=seed)
    answer = pca(sample.points)
    got = scored(answer, sample)
    assert got.topology_right
    assert got.rms < 2.0 * oracle_rms(sample)
    assert answer.method == "pca"
    if name != "multi_scan":  # registration errors come on top of the noise
        assert answer.sampling.sigma == pytest.approx(sample.sigma, rel=0.08)


@pytest.mark.parametrize("name", ["circle", "flower", "helix"])
def test_little_noise_and_many_samples(name):
    sample = point_set(name, n=20_000, sigma=0.0025, seed=3)
    answer = pca(sample.points)
    assert scored(answer, sample).topology_right
    assert scored(answer, sample).rms < 2.0 * oracle_rms(sample)
    assert answer.sampling.sigma == pytest.approx(sample.sigma, rel=0.03)


@pytest.mark.parametrize("name", ["figure_8", "lissajous"])
@pytest.mark.parametrize("seed", [0, 1])
def test_crossings_are_passed_straight_through(name, seed):
    sample = point_set(name, n=4000, sigma=0.005, seed=seed)
    answer = pca(sample.points)
    assert scored(answer, sample).topology_right
    assert len(answer.crossings) == len(sample.crossings)
    found = np.array([c.location for c in answer.crossings])
    for place in sample.crossings:
        assert np.linalg.norm(found - place, axis=1).min() < 4 * sample.sigma


@pytest.mark.parametrize("seed", [0, 1])
def test_a_square_is_closed_and_has_corners(seed):
    sample = point_set("square", n=3000, sigma=0.005, seed=seed)
    answer = pca(sample.points)
    assert topology(answer) == [True]
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    curve = answer.curves[0]
    assert distances(corners, curve.vertices, True).max() < 3 * sample.sigma
    assert scored(answer, sample).rms < 0.5 * sample.sigma


def test_several_curves_of_one_component():
    sticks = line(1500, 0.01, 2.0, seed=1), line(1500, 0.01, 2.0, seed=2)[:, ::-1]
    answer = pca(np.concatenate(sticks))
    assert topology(answer) == [False, False]
    assert {c.component for c in answer.curves} == {0}
    (crossing,) = answer.crossings
    assert sorted(crossing.curves) == [0, 1]
    assert np.linalg.norm(crossing.location) < 0.03
    assert crossing.angle == pytest.approx(90.0, abs=3.0)


def test_several_components_have_curves_of_their_own():
    rings = [arc(800, 0.01, seed=k) + np.array([5.0 * k, 0.0]) for k in range(3)]
    answer = pca(np.concatenate(rings))
    assert topology(answer) == [True, True, True]
    assert sorted(c.component for c in answer.curves) == [0, 1, 2]
    np.testing.assert_array_equal(np.bincount(answer.labels[answer.labels >= 0]) > 780, [True] * 3)


@pytest.mark.parametrize("turn", [1.0, 4.0, 5.8])
def test_the_ends_of_an_open_curve(turn):
    sigma = 0.01
    answer = pca(arc(3000, sigma, turn=turn, seed=4))
    assert topology(answer) == [False]
    ends = answer.curves[0].vertices[[0, -1]]
    truth = np.array([(1.0, 0.0), (np.cos(turn), np.sin(turn))])
    gaps = np.linalg.norm(ends[:, None] - truth, axis=2)
    assert min(gaps[[0, 1], [0, 1]].max(), gaps[[0, 1], [1, 0]].max()) < 2.5 * sigma


# ---------------------------------------------------------------- invariance

FAMILIES = ["ellipse", "flower", "wave", "nested", "figure_8", "tilted", "helix", "s_shape", "star"]
CASES = st.tuples(st.sampled_from(FAMILIES), st.integers(0, 4))


@lru_cache(maxsize=100)
def base(case):
    name, seed = case
    points = point_set(name, n=700, sigma=0.01, seed=seed).points
    return points, pca(points)


def assert_same(case, answer, back):
    points, first = base(case)
    second = moved_back(answer, back)
    assert len(answer.crossings) == len(first.crossings)
    assert same_curves(first, second) < 1e-6 * diagonal(points)


@settings(max_examples=7, deadline=None)
@given(CASES, SEEDS)
def test_the_order_of_the_points_does_not_matter(case, seed):
    points, first = base(case)
    order = np.random.default_rng(seed).permutation(len(points))
    answer = pca(points[order])
    assert_same(case, answer, lambda v: v)
    np.testing.assert_array_equal(np.sort(order[answer.outliers]), first.outliers)


@settings(max_examples=7, deadline=None)
@given(CASES, SEEDS)
def test_a_rotated_cloud_has_the_rotated_curves(case, seed):
    points, _ = base(case)
    turn = rotation(np.random.default_rng(seed), points.shape[1])
    assert_same(case, pca(points @ turn.T), lambda v: v @ turn)


@settings(max_examples=7, deadline=None)
@given(CASES, SEEDS)
def test_a_mirrored_cloud_has_the_mirrored_curves(case, seed):
    points, _ = base(case)
    turn = rotation(np.random.default_rng(seed), points.shape[1])
    turn[:, 0] *= -1.0
    assert_same(case, pca(points @ turn.T), lambda v: v @ turn)


@settings(max_examples=7, deadline=None)
@given(CASES, st.floats(-6.0, 6.0))
def test_a_scaled_cloud_has_the_scaled_curves(case, power):
    points, first = base(case)
    factor = 10.0**power
    answer = pca(points * factor)
    assert_same(case, answer, lambda v: v / factor)
    assert answer.sampling.sigma == pytest.approx(factor * first.sampling.sigma, rel=1e-5)
    assert answer.sampling.density == pytest.approx(first.sampling.density / factor, rel=1e-5)
    assert answer.sampling.epsilon == pytest.approx(factor * first.sampling.epsilon, rel=1e-5)


@settings(max_examples=7, deadline=None)
@given(CASES, SEEDS, st.sampled_from([1.0, 1e3]))
def test_a_translated_cloud_has_the_translated_curves(case, seed, far):
    points, _ = base(case)
    way = far * np.random.default_rng(seed).normal(size=points.shape[1])
    assert_same(case, pca(points + way), lambda v: v - way)


@settings(max_examples=7, deadline=None)
@given(CASES, SEEDS)
def test_far_from_the_origin_only_the_coordinates_are_rounded(case, seed):
    points, _ = base(case)
    rng = np.random.default_rng(seed)
    # A multiple of a large power of two: what is left of the coordinates can be brought back exactly.
    way = np.rint(rng.normal(size=points.shape[1]) * 8) * 2.0**20
    far = points + way
    near = far - way
    assert np.abs(near - points).max() < 1e-7
    assert same_curves(pca(near), moved_back(pca(far), lambda v: v - way)) < 1e-6 * diagonal(points)


# Point sets in which the rounding of sums once decided a comparison.
CLOSE_CALLS = [
    ("s_shape", 500, 0.005, 912, 0.0),
    ("disjoint", 500, 0.01, 997, 0.0),
    ("disjoint", 500, 0.01, 624, 0.0),
    ("disjoint", 500, 0.02, 237, 0.0),
    ("disjoint", 1000, 0.02, 573, 0.0),
    ("disjoint", 2000, 0.02, 585, 0.0),
    ("star", 500, 0.01, 400, 0.03),
    ("helix", 700, 0.01, 3, 0.0),
    ("helix", 1000, 0.005, 444, 0.0),
]


@pytest.mark.parametrize("drawn", CLOSE_CALLS)
def test_rounding_decides_nothing(drawn):
    name, n, sigma, seed, outliers = drawn
    points = point_set(name, n=n, sigma=sigma, seed=seed, outliers=outliers).points
    first, rng = pca(points), np.random.default_rng(0)
    for _ in range(2):
        turn, scale = rotation(rng, points.shape[1]), rng.uniform(0.5, 2.0)
        answer = pca(scale * rng.permutation(points) @ turn.T)
        back = moved_back(answer, lambda v, turn=turn, scale=scale: v @ turn / scale)
        assert same_curves(first, back) < 1e-6 * diagonal(points)


def test_the_same_points_give_the_same_bits():
    points, first = base(("flower", 0))
    again = pca(points.copy())
    for one, two in zip(first.curves, again.curves, strict=True):
        np.testing.assert_array_equal(one.vertices, two.vertices)


def test_the_points_are_left_alone():
    points, _ = base(("ellipse", 1))
    before = points.copy()
    pca(points)
    np.testing.assert_array_equal(points, before)
    frozen = points.copy()
    frozen.setflags(write=False)
    pca(frozen)


@pytest.mark.parametrize("form", ["list", "float32", "fortran", "strided"])
def test_any_form_of_array_will_do(form):
    points, first = base(("ellipse", 2))
    given = {
        "list": points.tolist(),
        "float32": points.astype(np.float32),
        "fortran": np.asfortranarray(points),
        "strided": np.repeat(points, 2, axis=0)[::2],
    }[form]
    answer = pca(given)
    assert same_curves(first, answer) < (1e-4 if form == "float32" else 1e-12) * diagonal(points)


# ---------------------------------------------------------------- space


@pytest.mark.parametrize("planar", [None, True])
@pytest.mark.parametrize("thickness", [0.0, 0.02])
def test_a_tilted_circle_is_worked_on_in_its_plane(planar, thickness):
    points, turn = in_a_tilted_plane(arc(2000, 0.02), 5, thickness)
    answer = reconstruct(points, planar=planar)
    (curve,) = answer.curves
    assert curve.closed
    assert answer.warnings == ()
    (frame,) = answer.frames
    assert abs(frame.axes[2] @ turn[:, 2]) > np.cos(np.radians(2))
    height = (curve.vertices - frame.origin) @ frame.axes[2]
    assert np.abs(height).max() < 1e-9
    centre = curve.vertices.mean(axis=0)
    assert np.linalg.norm(curve.vertices - centre, axis=1).mean() == pytest.approx(1.0, abs=0.01)


def test_a_planar_curve_may_be_marched_in_space():
    flat = arc(2000, 0.02)
    points, turn = in_a_tilted_plane(flat, 6, 0.02)
    answer = reconstruct(points, planar=False)
    assert topology(answer) == [True]
    in_plane = reconstruct(points, planar=True)
    assert same_curves(answer, in_plane) < 0.02
    height = (answer.curves[0].vertices - points.mean(axis=0)) @ turn[:, 2]
    assert 0 < np.ptp(height) < 0.04


@pytest.mark.parametrize("name", ["helix", "trefoil", "saddle"])
def test_space_curves_are_marched_in_space_by_themselves(name):
    sample = point_set(name, n=3000, sigma=0.006, seed=2)
    free = pca(sample.points)
    assert scored(free, sample).flags_right
    assert [w.code for w in free.warnings] == ["not-quasi-planar"]
    assert free.warnings[0].location is not None
    assert len(free.warnings[0].location) == 3
    asked = reconstruct(sample.points, planar=False)
    assert same_curves(free, asked) < 1e-9
    assert asked.warnings == ()


def test_a_helix_can_be_forced_into_its_plane():
    sample = point_set("helix", n=2000, sigma=0.005)
    answer = reconstruct(sample.points, planar=True)
    (frame,) = answer.frames
    for curve in answer.curves:
        assert np.abs((curve.vertices - frame.origin) @ frame.axes[2]).max() < 1e-9
    assert "not-quasi-planar" in [w.code for w in answer.warnings]


# ---------------------------------------------------------------- outliers and difficult samples


@pytest.mark.parametrize("name", ["circle", "s_shape", "nested"])
def test_outliers_are_found(name):
    sample = point_set(name, n=2000, sigma=0.01, outliers=0.08, seed=3)
    answer = pca(sample.points)
    assert topology(answer) == sorted(c.closed for c in sample.curves)
    stray = np.flatnonzero(sample.curve_of < 0)
    # A stray point within the noise of the curve cannot be told from a sample.
    reach = 5 * sample.sigma
    away = np.min([distances(sample.points, c.vertices, c.closed) for c in sample.curves], axis=0)
    clear = stray[away[stray] > reach]
    assert np.isin(clear, answer.outliers).all()
    assert np.mean(sample.curve_of[answer.outliers] < 0) > 0.95
    assert scored(answer, sample).rms < 2.0 * oracle_rms(sample)


def test_without_outliers_hardly_any_sample_is_called_one():
    sample = point_set("ellipse", n=4000, sigma=0.01, seed=6)
    assert len(pca(sample.points).outliers) <= 0.003 * 4000
    # Three standard deviations leave 0.27 % out.
    strict = reconstruct(sample.points, outliers="reject").outliers
    assert 2 <= len(strict) <= 0.008 * 4000


@pytest.mark.parametrize("name", ["ellipse", "wave", "nested"])
def test_samples_are_kept_or_rejected_as_told(name):
    sample = point_set(name, n=2000, sigma=0.01, outliers=0.05, seed=7)
    answers = [reconstruct(sample.points, outliers=mode) for mode in ("keep", "auto", "reject")]
    kept, auto, strict = (set(answer.outliers.tolist()) for answer in answers)
    assert kept <= auto < strict
    # Every sample of a component takes part.
    out = np.flatnonzero(partition(sample.points).labels < 0)
    assert kept == set(out.tolist())
    for answer in answers:
        assert topology(answer) == sorted(c.closed for c in sample.curves)
        assert sum(c.samples for c in answer.curves) == pytest.approx(2000, rel=0.06)
        assert 0.9 * sample.sigma < answer.sampling.sigma < 2.0 * sample.sigma


@pytest.mark.parametrize("times", [2, 5])
def test_copies_of_samples_tell_nothing_more(times):
    points, first = base(("ellipse", 3))
    answer = pca(np.repeat(points, times, axis=0))
    assert same_curves(first, answer) < 1e-9 * diagonal(points)
    assert answer.sampling.sigma == pytest.approx(first.sampling.sigma, rel=1e-9)
    assert answer.sampling.density == pytest.approx(times * first.sampling.density, rel=1e-9)
    assert [len(c.vertices) for c in answer.curves] == [len(c.vertices) for c in first.curves]


@pytest.mark.parametrize("grid", [0.01, 0.05])
def test_coordinates_may_be_quantised(grid):
    sample = point_set("ellipse", n=3000, sigma=0.01, seed=1)
    answer = pca(np.round(sample.points / grid) * grid)
    assert topology(answer) == [True]
    got = scored(answer, sample)
    assert got.rms < 0.5 * sample.sigma + 0.5 * grid


@pytest.mark.parametrize("n", [12, 100, 2000])
def test_points_on_a_straight_line(n):
    along = np.random.default_rng(n).uniform(0.0, 5.0, n)
    points = np.outer(along, [0.6, 0.8]) + 2.0
    try:
        answer = pca(points)
    except DegenerateInput:
        assert n < 50
        return
    for curve in answer.curves:
        assert not curve.closed
        across = (curve.vertices - 2.0) @ np.array([0.8, -0.6])
        assert np.abs(across).max() < 1e-6
    if n >= 100:
        assert sum(c.length for c in answer.curves) == pytest.approx(5.0, rel=0.15)


@pytest.mark.parametrize("n", [500, 3000])
def test_samples_without_any_noise(n):
    sample = point_set("ellipse", n=n, sigma=0.0)
    answer = pca(sample.points)
    assert topology(answer) == [True]
    assert scored(answer, sample).rms < 2e-3 * diagonal(sample.points)


def test_a_scan_in_order_is_like_one_in_any_order():
    angle = np.sort(np.random.default_rng(0).uniform(0, 2 * np.pi, 1500))
    points = np.column_stack((np.cos(angle), 0.6 * np.sin(angle)))
    points += 0.01 * np.random.default_rng(1).normal(size=points.shape)
    assert topology(pca(points)) == [True]


# ---------------------------------------------------------------- parameters


def test_the_spacing_of_the_vertices():
    points = arc(2000, 0.01)
    for spacing in (0.02, 0.1, 0.5):
        for refine in (True, False):
            (curve,) = reconstruct(points, vertex_spacing=spacing, refine=refine).curves
            ring = np.concatenate((curve.vertices, curve.vertices[:1]))
            steps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
            # Equidistant along the curve, and never farther apart than asked for.
            assert steps.max() < 1.03 * spacing
            assert steps.min() > 0.7 * spacing


@pytest.mark.parametrize("refine", [True, False])
def test_a_spacing_that_no_memory_could_hold_is_refused(refine):
    with pytest.raises(InvalidParameter) as raised:
        reconstruct(arc(500, 0.01), vertex_spacing=1e-13, refine=refine)
    assert "vertex_spacing" in raised.value.loc


def test_unrefined_curves_are_the_march():
    points = arc(2000, 0.02)
    answer = pca(points, PcaParameters(refine=False), stages=True)
    (curve,), (course,) = answer.curves, answer.stages.march
    np.testing.assert_allclose(curve.vertices, course, atol=1e-12)
    smooth = pca(points).curves[0]
    assert same_curves(answer, pca(points)) > 1e-6
    rough_off = np.linalg.norm(curve.vertices, axis=1) - 1.0
    smooth_off = np.linalg.norm(smooth.vertices, axis=1) - 1.0
    assert np.std(smooth_off) < np.std(rough_off)


def test_epsilon_decides_what_hangs_together():
    one, two = arc(1000, 0.01, seed=1), arc(1000, 0.01, seed=2) + np.array([3.0, 0.0])
    points = np.concatenate((one, two))
    for epsilon, count in ((0.3, 2), (2.0, 1)):
        answer = reconstruct(points, epsilon=epsilon)
        assert answer.sampling.epsilon == epsilon
        assert topology(answer) == [True, True]
        assert len({c.component for c in answer.curves}) == count
        assert partition(points, PartitionParameters(epsilon=epsilon)).count == count


def test_components_may_be_too_small_to_count():
    one, two = arc(1000, 0.01, seed=1), arc(300, 0.01, seed=2) + np.array([3.0, 0.0])
    points = np.concatenate((one, two))
    assert len(reconstruct(points, min_component_size=200).curves) == 2
    large = reconstruct(points, min_component_size=400)
    assert len(large.curves) == 1
    assert set(range(1000, 1300)) <= set(large.outliers.tolist())
    with pytest.raises(DegenerateInput):
        reconstruct(points, min_component_size=2000)


def test_radius_and_step_are_in_the_units_of_the_points():
    points = 30.0 * arc(3000, 0.01)
    answer = pca(points, PcaParameters(radius=6.0, step=2.0), stages=True)
    assert topology(answer) == [True]
    np.testing.assert_allclose([b.radius for b in answer.stages.balls], 6.0)
    gaps = np.linalg.norm(np.diff(answer.stages.march[0], axis=0), axis=1)
    assert np.median(gaps) == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("step", [0.01, 0.05, 0.3])
def test_any_reasonable_step_leads_around(step):
    answer = reconstruct(arc(2000, 0.01), step=step)
    assert topology(answer) == [True]
    assert answer.curves[0].length == pytest.approx(2 * np.pi, rel=0.01)


def test_the_number_of_uses_limits_the_balls():
    points = arc(3000, 0.02)
    for uses in (1, 3):
        answer = pca(points, PcaParameters(max_uses=uses), stages=True)
        assert sum(b.samples for b in answer.stages.balls) <= 1.15 * uses * len(points)
    free = pca(points, stages=True)
    assert sum(b.samples for b in free.stages.balls) > 3 * len(points)


@pytest.mark.parametrize("name", ["ellipse", "s_shape", "helix"])
def test_both_estimators_give_the_same_curve(name):
    points = point_set(name, n=1500, sigma=0.01, seed=1).points
    one = pca(points)
    for seed in (0, 1):
        two = reconstruct(points, estimator="least_squares", seed=seed)
        assert same_curves(one, two) < 1e-6 * diagonal(points)


def test_the_same_seed_gives_the_same_answer():
    points, _ = base(("star", 0))
    one, two = (reconstruct(points, estimator="least_squares", seed=9) for _ in range(2))
    for a, b in zip(one.curves, two.curves, strict=True):
        np.testing.assert_array_equal(a.vertices, b.vertices)


# ---------------------------------------------------------------- what determines no curve


@pytest.mark.parametrize(
    "points",
    [
        [[0.0, 0.0]],
        [[0.0, 0.0], [1.0, 1.0]],
        [[3.0, 4.0]] * 100,
        [[3.0, 4.0, 5.0]] * 100,
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] * 50,
    ],
)
def test_points_that_determine_no_curve(points):
    with pytest.raises(DegenerateInput) as raised:
        pca(points)
    assert raised.value.loc == ("points",)
    assert raised.value.kind == "degenerate-input"


def test_a_filled_square_of_noise_is_sound_or_degenerate():
    points = np.random.default_rng(0).uniform(size=(2000, 2))
    assert_sound_or_refused(points)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_number_that_is_not_finite_is_named(value):
    points = arc(50, 0.01)
    points[17, 1] = value
    points[30, 0] = np.nan
    for method in (pca, partition):
        with pytest.raises(InvalidPoints) as raised:
            method(points)
        assert raised.value.loc == ("points", 17, 1)


@pytest.mark.parametrize(
    "points", [[], [[]], [1.0, 2.0], [[1.0]], [[1.0] * 4], [["a", "b"]], [[1, 2], [3]], None]
)
def test_what_is_no_point_set(points):
    with pytest.raises(InvalidPoints) as raised:
        pca(points)
    assert raised.value.loc[0] == "points"


def assert_sound_or_refused(points, **parameters):
    try:
        answer = reconstruct(points, **parameters)
    except TapelineError:
        return
    assert_sound(answer, points)


@pytest.mark.parametrize(("n", "dimension"), [(30, 2), (60, 3), (120, 3)])
@pytest.mark.parametrize("seed", [0, 11, 12])
def test_the_largest_and_smallest_doubles_are_answered_or_refused(n, dimension, seed):
    extremes = [0.0, 1.0, -1.0, 1e308, -1e308, 5e-324, 1e-300, 1e300, 1.7e308]
    assert_sound_or_refused(np.random.default_rng(seed).choice(extremes, (n, dimension)))


FINITE = st.floats(allow_nan=False, allow_infinity=False)
SHAPES = st.tuples(st.integers(1, 40), st.sampled_from([2, 3]))


@settings(max_examples=100, deadline=None)
@given(hnp.arrays(np.float64, SHAPES, elements=FINITE))
def test_any_finite_numbers_are_answered_or_refused(points):
    assert_sound_or_refused(points)


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(np.float64, SHAPES, elements=st.integers(-3, 3).map(float)))
def test_points_on_a_coarse_grid_are_answered_or_refused(points):
    assert_sound_or_refused(points)


@settings(max_examples=50, deadline=None)
@given(
    SEEDS, st.integers(1, 60), st.sampled_from([2, 3]), st.sampled_from([1e-310, 1e-150, 1.0, 1e150, 1e306])
)
def test_blobs_of_any_size_and_scale_are_answered_or_refused(seed, n, dimension, scale):
    rng = np.random.default_rng(seed)
    assert_sound_or_refused(scale * rng.normal(size=(n, dimension)))


@settings(max_examples=60, deadline=None)
@given(
    SEEDS,
    st.integers(10, 80),
    st.sampled_from([2, 3]),
    st.sampled_from([0.0, 1e-9, 1e-3]),
    st.sampled_from([0.0, 1e12]),
    st.sampled_from([1e-300, 1.0, 1e290]),
)
def test_nearly_collinear_points_are_answered_or_refused(seed, n, dimension, width, offset, scale):
    rng = np.random.default_rng(seed)
    turn = rotation(rng, dimension)
    points = rng.normal(size=(n, dimension)) * np.append(1.0, np.full(dimension - 1, width)) @ turn.T
    assert_sound_or_refused(scale * (points + offset))


PARAMETERS = st.fixed_dictionaries(
    {},
    optional={
        "epsilon": st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
        "radius": st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
        "step": st.sampled_from([1e-2, 0.1, 1.0, 1e3]),
        "vertex_spacing": st.sampled_from([1e-2, 1.0, 1e6]),
        "max_uses": st.sampled_from([1, 2, 1000]),
        "min_component_size": st.sampled_from([1, 5, 1000]),
        "estimator": st.just("least_squares"),
        "outliers": st.sampled_from(["keep", "reject"]),
        "planar": st.booleans(),
        "refine": st.just(False),
    },
)


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from(["circle", "line", "blob", "helix"]), st.integers(10, 150), PARAMETERS)
def test_any_parameters_are_answered_or_refused(seed, shape, n, parameters):
    points = {
        "circle": lambda: arc(n, 0.02, seed=seed),
        "line": lambda: line(n, 0.02, seed=seed, dimension=3),
        "blob": lambda: np.random.default_rng(seed).normal(size=(n, 2)),
        "helix": lambda: point_set("helix", n=n, seed=seed % 1000).points,
    }[shape]()
    assert_sound_or_refused(points, **parameters)


@pytest.mark.parametrize("name", names())
def test_few_samples_of_any_family_are_answered_or_refused(name):
    for n in (11, 60):
        assert_sound_or_refused(point_set(name, n=n, sigma=0.02, seed=n).points)
