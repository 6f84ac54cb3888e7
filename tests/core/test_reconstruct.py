"""One answer without parameters: the better of both methods, component by component."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arbiter import arbitrated
from core.errors import DegenerateInput, InvalidParameter, InvalidPoints, TapelineError
from core.methods import diagnose, partition, pca, reconstruct, skeleton
from core.parameters import PcaParameters, ReconstructParameters, SkeletonParameters
from core.prepared import prepared
from core.report import report
from core.truth import oracle_rms, point_set
from tests.core.answers import assert_sound, moved_back, same_curves, scored, topology
from tests.core.shapes import arc, distances, in_a_tilted_plane, line, rotation

SEEDS = st.integers(0, 2**32 - 1)


def with_parameters(points, **parameters):
    return reconstruct(points, ReconstructParameters(**parameters))


def shapes(evidence):
    return (evidence.curves, evidence.closed, evidence.crossings)


# ---------------------------------------------------------------- the right curves


@pytest.mark.parametrize(
    ("name", "sigma", "seed"),
    [
        ("spiral", 0.02, 0),  # near arms share one tape
        ("nested", 0.02, 0),
        ("disjoint", 0.02, 0),
        ("double_8", 0.02, 0),  # a march turns where it should cross
        ("pentagram", 0.02, 1),
        ("linked_ellipses", 0.02, 2),
        ("random_open", 0.02, 2),  # a gap is no bridge
        ("flower", 0.01, 1),
        ("helix", 0.01, 0),
    ],
)
def test_curves_come_out_right_where_one_method_fails(name, sigma, seed):
    sample = point_set(name, n=2000, sigma=sigma, seed=seed)
    answer = reconstruct(sample.points)
    got = scored(answer, sample)
    assert got.topology_right
    assert got.rms < 2.0 * oracle_rms(sample)
    assert_sound(answer, sample.points)


@pytest.mark.parametrize("name", ["pentagram", "trifolium_ribbon", "disjoint"])
def test_few_samples_are_tried_at_more_scales(name):
    sample = point_set(name, n=300, sigma=0.015, seed=2)
    assert scored(reconstruct(sample.points), sample).topology_right


def test_each_component_has_a_decision_of_its_own():
    eight = point_set("double_8", n=1500, sigma=0.02, seed=0).points
    rings = point_set("nested", n=1500, sigma=0.02, seed=0).points
    both = np.concatenate([eight, rings + np.array([20.0, 0.0])])
    answer = reconstruct(both)
    assert len(answer.curves) == 1 + 3
    assert len(answer.crossings) == 3
    assert {curve.component for curve in answer.curves} == {d.component for d in answer.decisions}
    assert "components are by" in answer.reason


@pytest.mark.parametrize("name", ["airfoil", "star", "naca"])
def test_sharp_tips_stay_closed(name):
    sample = point_set(name, n=1500, seed=0)
    assert scored(reconstruct(sample.points), sample).topology_right


@pytest.mark.parametrize("seed", [0, 1])
def test_ends_side_by_side_are_not_joined_round_the_corner(seed):
    rng = np.random.default_rng(seed)
    sigma, angle = 0.02, rng.uniform(0.0, 2.2, (3, 400))
    radius = np.array([[1.0], [1.13], [1.26]])  # 6.5 sigma apart
    arcs = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    answer = reconstruct(arcs.reshape(-1, 2) + sigma * rng.normal(size=(1200, 2)))
    assert topology(answer) == [False] * 3
    assert not answer.crossings


# ---------------------------------------------------------------- the evidence


@pytest.mark.parametrize("name", ["circle", "figure_8", "nested"])
def test_the_evidence_is_told(name):
    sample = point_set(name, n=1000, sigma=0.01, seed=0)
    answer = reconstruct(sample.points)
    chosen, others = answer.decisions, answer.alternatives
    assert [each.nats for each in chosen] == [0.0] * len(chosen)
    assert all(each.nats >= 0.0 for each in others)
    assert sum(each.curves for each in chosen) == len(answer.curves)
    assert sum(each.closed for each in chosen) == sum(c.closed for c in answer.curves)
    for each in (*chosen, *others):
        assert each.method in ("pca", "skeleton")
        assert 0.9 < each.explained <= 1.0
        assert each.sigma == pytest.approx(sample.sigma, rel=0.2)
        assert 0.0 < each.largest_gap < 4 * np.log(len(sample.points))
        assert each.reason.endswith(".")
    assert {each.method for each in chosen if each.component == 0} | {
        each.method for each in others if each.component == 0
    } == {"pca", "skeleton"}
    assert chosen[0].reason in answer.reason or len(chosen) > 1


def test_a_missing_stretch_of_a_ring_is_not_bridged():
    ring = arc(1500, 0.02, turn=2 * np.pi - 0.6, seed=4)
    answer = reconstruct(ring)
    assert topology(answer) == [False]


def test_gaps_that_independent_samples_leave_are_closed():
    for seed in range(5):
        assert topology(reconstruct(arc(250, 0.01, seed=seed))) == [True]


def test_methods_that_disagree_within_a_few_nats_are_told():
    points = arc(400, 0.02)
    parameters = ReconstructParameters()
    parts = partition(points)
    (component,) = parts.components
    members = np.flatnonzero(parts.labels == 0)
    one = arbitrated(prepared(points[members], members, component, parameters), parameters)
    chosen, other = one.evidence
    crossed = replace(other, crossings=other.crossings + 1, nats=1.0)
    doubtful = replace(one, evidence=(chosen, crossed))
    sure = replace(one, evidence=(chosen, replace(crossed, nats=50.0)))
    told = report("pca", "", points, parts, [doubtful], False)
    assert "methods-disagree" in {w.code for w in told.warnings}
    told = report("pca", "", points, parts, [sure], False)
    assert "methods-disagree" not in {w.code for w in told.warnings}


# ---------------------------------------------------------------- parameters


def test_either_method_may_be_asked_for():
    sample = point_set("ellipse", n=800, sigma=0.01, seed=1)
    for method, alone in (("pca", pca), ("skeleton", skeleton)):
        answer = with_parameters(sample.points, method=method)
        assert answer.method == method
        assert answer.alternatives == ()
        assert same_curves(answer, alone(sample.points)) < 0.5 * sample.sigma


def test_parameters_of_both_methods_are_those_of_the_methods():
    for name in (*PcaParameters.model_fields, *SkeletonParameters.model_fields):
        assert name in ReconstructParameters.model_fields


@pytest.mark.parametrize("reading", ["split", "waist", "graph"])
def test_crossings_are_read_as_told_with_their_standard_errors(reading):
    sample = point_set("figure_8", n=2000, sigma=0.01, seed=0)
    answer = with_parameters(sample.points, crossings=reading)
    assert not answer.crossings
    assert len(answer.curves) == (1 if reading == "waist" else 2)
    for curve in answer.curves:
        assert curve.standard_errors.shape == (len(curve.vertices),)
        assert np.all((curve.standard_errors > 0.0) & (curve.standard_errors < sample.sigma))


def test_curves_that_are_not_refined_have_no_standard_errors():
    answer = with_parameters(arc(500, 0.02), refine=False)
    assert [curve.standard_errors for curve in answer.curves] == [None]


def test_space_curves_are_marched():
    sample = point_set("helix", n=2000, sigma=0.005, seed=0)
    answer = reconstruct(sample.points)
    assert answer.method == "pca"
    assert answer.alternatives == ()
    assert answer.tape is None
    assert scored(answer, sample).topology_right


def test_a_tilted_plane_is_worked_in():
    flat = point_set("figure_8", n=1500, sigma=0.008, seed=0)
    points, _ = in_a_tilted_plane(flat.points, 5, 0.0)
    answer = reconstruct(points)
    assert len(answer.crossings) == 1
    assert topology(answer) == [True]
    assert {e.method for e in (*answer.decisions, *answer.alternatives)} == {"pca", "skeleton"}


@pytest.mark.parametrize("method", ["auto", "pca", "skeleton"])
def test_stages_are_those_of_the_method(method):
    points = arc(400, 0.02)
    answer = reconstruct(points, ReconstructParameters(method=method), stages=True)
    assert (type(answer.stages).__name__ == "SkeletonStages") == (answer.method == "skeleton")
    assert reconstruct(points).stages is None


# ---------------------------------------------------------------- invariance

FAMILIES = ["ellipse", "nested", "double_8", "two_circles", "s_shape"]
CASES = st.sampled_from(FAMILIES)


@lru_cache(maxsize=16)
def base(name):
    points = point_set(name, n=700, sigma=0.008, seed=0).points
    return points, reconstruct(points)


def assert_same(name, answer, back):
    points, first = base(name)
    assert answer.method == first.method
    assert [shapes(e) for e in answer.decisions] == [shapes(e) for e in first.decisions]
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert same_curves(moved_back(answer, back), first) < 1e-4 * diagonal


@settings(max_examples=3, deadline=None)
@given(CASES, SEEDS)
def test_the_order_of_the_points_does_not_matter(name, seed):
    points, _ = base(name)
    assert_same(name, reconstruct(np.random.default_rng(seed).permutation(points)), lambda v: v)


@settings(max_examples=3, deadline=None)
@given(CASES, SEEDS, st.booleans())
def test_a_rotated_or_mirrored_cloud_has_such_curves(name, seed, mirrored):
    points, _ = base(name)
    turn = rotation(np.random.default_rng(seed), 2)
    if mirrored:
        turn[:, 0] *= -1.0
    assert_same(name, reconstruct(points @ turn.T), lambda v: v @ turn)


@settings(max_examples=3, deadline=None)
@given(CASES, st.floats(-6.0, 6.0), SEEDS)
def test_a_scaled_and_shifted_cloud_has_such_curves(name, power, seed):
    points, first = base(name)
    factor, way = 10.0**power, np.random.default_rng(seed).normal(size=2)
    answer = reconstruct((points + way) * factor)
    assert_same(name, answer, lambda v: v / factor - way)
    assert answer.decisions[0].sigma == pytest.approx(factor * first.decisions[0].sigma, rel=1e-4)


# ---------------------------------------------------------------- diagnosis


@pytest.mark.parametrize("name", ["ellipse", "figure_8", "nested"])
def test_a_diagnosis_says_what_the_reconstruction_would(name):
    sample = point_set(name, n=3000, sigma=0.01, seed=0)
    answer, told = reconstruct(sample.points), diagnose(sample.points)
    assert told.method == answer.method
    assert told.curves == len(answer.curves)
    assert told.closed == sum(curve.closed for curve in answer.curves)
    assert told.crossings == len(answer.crossings)
    assert told.sampling.sigma == pytest.approx(answer.sampling.sigma, rel=0.01)
    assert told.sampling.density == pytest.approx(answer.sampling.density, rel=0.01)
    assert told.sampling.nyquist.compliant
    assert told.verdict.endswith(".")


def test_a_diagnosis_of_many_samples_counts_them_all():
    sample = point_set("ellipse", n=60_000, sigma=0.01, seed=0)
    told = diagnose(sample.points)
    length = sum(curve.length for curve in sample.curves)
    assert told.sampling.density == pytest.approx(60_000 / length, rel=0.01)
    assert told.sampling.sigma == pytest.approx(sample.sigma, rel=0.02)


# ---------------------------------------------------------------- what determines no curve


def sound_or_refused(points, **parameters):
    try:
        answer = with_parameters(points, **parameters)
        diagnose(points, ReconstructParameters(**parameters))
    except TapelineError:
        return
    assert_sound(answer, points)


@pytest.mark.parametrize("function", [reconstruct, diagnose])
def test_what_is_refused(function):
    with pytest.raises(DegenerateInput):
        function(np.zeros((20, 2)))
    with pytest.raises(InvalidPoints):
        function([[0.0, np.nan]] * 10)
    with pytest.raises(InvalidParameter):
        function(arc(100, 0.01), ReconstructParameters(vertex_spacing=1e-12))


def test_points_on_a_straight_line():
    answer = reconstruct(line(300, 0.0))
    assert topology(answer) == [False]
    assert distances(answer.curves[0].vertices, np.array([[-0.5, 0.0], [0.5, 0.0]]), False).max() < 1e-9


@settings(max_examples=25, deadline=None)
@given(
    SEEDS,
    st.integers(6, 120),
    st.sampled_from([2, 3]),
    st.sampled_from([0.0, 1e-3, 0.05, 1.0]),
    st.sampled_from([1e-300, 1e-5, 1.0, 1e290]),
)
def test_anything_is_answered_or_refused(seed, n, dimension, width, scale):
    rng = np.random.default_rng(seed)
    turn = rotation(rng, dimension)
    points = rng.normal(size=(n, dimension)) * np.append(1.0, np.full(dimension - 1, width)) @ turn.T
    sound_or_refused(scale * points)


@settings(max_examples=25, deadline=None)
@given(
    SEEDS,
    st.integers(10, 120),
    st.fixed_dictionaries(
        {},
        optional={
            "method": st.sampled_from(["pca", "skeleton"]),
            "crossings": st.sampled_from(["split", "waist", "graph"]),
            "planar": st.booleans(),
            "refine": st.just(False),
            "radius": st.sampled_from([1e-3, 0.3, 1e3]),
            "f_l": st.sampled_from([1e-3, 2.0, 1e3]),
            "prune": st.sampled_from([0.0, 50.0]),
            "outliers": st.sampled_from(["keep", "reject"]),
            "epsilon": st.sampled_from([1e-3, 0.1, 1e3]),
        },
    ),
)
def test_any_parameters_are_answered_or_refused(seed, n, parameters):
    sound_or_refused(arc(n, 0.02, seed=seed), **parameters)
