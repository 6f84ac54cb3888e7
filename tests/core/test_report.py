import numpy as np
import pytest

from core.cloud.frame import principal_frame
from core.cloud.working_frame import working_frame
from core.methods import partition, pca
from core.parameters import PartitionParameters, PcaParameters
from core.refine.polyline import Polyline
from core.refine.principal_curve import Refined
from core.refine.project import project
from core.report import report
from core.solved import Solved
from core.truth import point_set
from tests.core.shapes import arc, diagonal, distances, in_space, rotation


def polyline_length(curve):
    ring = np.concatenate((curve.vertices, curve.vertices[:1])) if curve.closed else curve.vertices
    return np.linalg.norm(np.diff(ring, axis=0), axis=1).sum()


@pytest.fixture(scope="module", params=["nested", "figure_8", "helix", "wave", "disjoint"])
def answered(request):
    sample = point_set(request.param, n=1500, sigma=0.008, outliers=0.02, seed=5)
    # Somewhere else, and in other units than those that the work is done in.
    points = 40.0 * sample.points + 300.0
    return points, pca(points, stages=True)


def test_a_curve_says_its_own_length_samples_and_residual(answered):
    points, answer = answered
    for k, curve in enumerate(answer.curves):
        own = points[answer.labels == k]
        assert curve.length == pytest.approx(polyline_length(curve))
        assert curve.samples == len(own)
        away = distances(own, curve.vertices, curve.closed)
        assert curve.rms_residual == pytest.approx(np.sqrt(np.mean(away**2)), rel=1e-3)


def test_each_sample_is_on_its_nearest_curve_or_an_outlier(answered):
    points, answer = answered
    away = np.array([distances(points, c.vertices, c.closed) for c in answer.curves])
    on = answer.labels >= 0
    np.testing.assert_allclose(
        away[answer.labels[on], np.flatnonzero(on)], away.min(axis=0)[on], atol=1e-9 * diagonal(points)
    )
    np.testing.assert_array_equal(answer.outliers, np.flatnonzero(~on))
    assert away.min(axis=0)[on].max() < away.min(axis=0)[~on].max()


def test_a_closed_curve_does_not_repeat_its_first_vertex(answered):
    points, answer = answered
    for curve in answer.curves:
        ends = np.linalg.norm(curve.vertices[0] - curve.vertices[-1])
        assert ends > 1e-6 * diagonal(points)
        if curve.closed:
            assert ends < 2 * curve.length / len(curve.vertices)


def test_the_sampling_is_that_of_the_curves(answered):
    points, answer = answered
    length = sum(c.length for c in answer.curves)
    assert answer.sampling.density == pytest.approx(sum(c.samples for c in answer.curves) / length)
    assert answer.sampling.epsilon == pytest.approx(partition(points).epsilon)
    residual = np.sqrt(np.mean([c.rms_residual**2 for c in answer.curves]))
    directions = 2 if answer.frames[0].planarity < 0.5 and points.shape[1] == 3 else 1
    assert answer.sampling.sigma == pytest.approx(residual / np.sqrt(directions), rel=0.1)


def test_components_and_frames_are_those_of_the_partition(answered):
    points, answer = answered
    parts = partition(points)
    assert {c.component for c in answer.curves} <= set(range(parts.count))
    for frame in answer.frames:
        known = parts.components[frame.component].frame
        np.testing.assert_array_equal(frame.origin, known.origin)
        np.testing.assert_array_equal(frame.axes, known.axes)
        assert frame.planarity == known.planarity


def test_crossings_lie_on_the_curves_that_cross(answered):
    points, answer = answered
    for crossing in answer.crossings:
        assert crossing.location.shape == (points.shape[1],)
        assert 0.0 <= crossing.angle <= 90.0
        for k in crossing.curves:
            curve = answer.curves[k]
            away = distances(crossing.location[None], curve.vertices, curve.closed)[0]
            assert away < 1e-9 * diagonal(points) + 1e-9


def test_balls_are_stages_of_the_march(answered):
    points, answer = answered
    d = points.shape[1]
    balls, march = answer.stages.balls, answer.stages.march
    assert len(balls) == sum(len(course) for course in march)
    np.testing.assert_array_equal([b.centre for b in balls], np.concatenate(march))
    size = diagonal(points)
    for ball in balls:
        assert ball.centre.shape == ball.direction.shape == (d,)
        assert np.linalg.norm(ball.direction) == pytest.approx(1.0, abs=1e-6)
        assert 0.0 < ball.radius < size
        assert ball.samples >= 1
    gaps = np.min([distances(np.concatenate(march), c.vertices, c.closed) for c in answer.curves], axis=0)
    assert np.quantile(gaps, 0.95) < 3 * answer.sampling.sigma


def test_a_figure_of_eight_has_one_crossing_where_it_should():
    sample = point_set("figure_8", n=2000, sigma=0.005, seed=1)
    answer = pca(sample.points)
    (crossing,) = answer.crossings
    assert crossing.curves == (0, 0)
    assert np.linalg.norm(crossing.location - sample.crossings[0]) < 3 * sample.sigma
    assert crossing.angle == pytest.approx(90.0, abs=6.0)  # of x = cos t, y = sin(2 t) / 2


def test_curves_in_space_have_no_crossings():
    assert pca(point_set("trefoil", n=2000, sigma=0.005).points).crossings == ()


def test_the_margin_is_the_width_of_a_waist():
    answer = pca(point_set("wasp_waist", n=3000, sigma=0.01, seed=1).points)
    nyquist = answer.sampling.nyquist
    assert nyquist.compliant
    assert nyquist.violations == ()
    assert nyquist.margin_sigmas == pytest.approx(0.56 / answer.sampling.sigma, rel=0.1)


def solved(points, vertices, sigma, outliers="auto"):
    """A component whose curves are given, each open, in the coordinates of the points."""
    (component,) = partition(points, PartitionParameters(epsilon=diagonal(points))).components
    work, frame = working_frame(points, component.frame.axes, True)
    lines = [Polyline(in_space(frame.way.apply(v)), False) for v in vertices]
    noise = sigma / frame.scale
    errors = tuple(np.zeros(len(line.vertices)) for line in lines)
    refined = Refined(
        tuple(lines), project(work, lines, 10 * noise), noise, np.full(len(lines), noise), errors
    )
    return Solved(component, np.arange(len(points)), work, frame, refined, outliers, None)


def bars(gap, sigma):
    """Two parallel strokes, each with samples about it."""
    rng = np.random.default_rng(0)
    x = rng.uniform(0.0, 10.0, 1000)
    y = np.repeat([0.0, gap], 500) + sigma * np.clip(rng.normal(size=1000), -2.0, 2.0)
    ends = np.array([0.0, 10.0])
    return np.column_stack((x, y)), [np.column_stack((ends, np.full(2, height))) for height in (0.0, gap)]


def told(points, one):
    parts = partition(points, PartitionParameters(epsilon=diagonal(points)))
    return report("pca", "a test", points, parts, [one], False)


@pytest.mark.parametrize("gap_sigmas", [1.0, 3.0, 3.8])
def test_branches_closer_than_the_noise_allows_are_violations(gap_sigmas):
    sigma = 0.05
    points, strokes = bars(gap_sigmas * sigma, sigma)
    nyquist = told(points, solved(points, strokes, sigma)).sampling.nyquist
    assert not nyquist.compliant
    assert nyquist.margin_sigmas == pytest.approx(gap_sigmas, rel=0.01)
    for violation in nyquist.violations:
        assert violation.gap_sigmas == pytest.approx(gap_sigmas, rel=0.1)
        assert violation.location[1] == pytest.approx(gap_sigmas * sigma / 2, rel=0.1)
        assert 0.0 <= violation.location[0] <= 10.0
        assert violation.reason


def test_samples_are_outliers_by_their_distance_in_sigma():
    sigma = 0.05
    points, strokes = bars(30 * sigma, sigma)
    # Of three strays only one is past five sigma; one is past three.
    strays = np.array([(5.0, -2.0 * sigma), (5.0, -3.4 * sigma), (5.0, -8.0 * sigma)])
    points = np.concatenate((strays, points))
    expected = {"keep": set(), "auto": {2}, "reject": {1, 2}}
    for mode, outside in expected.items():
        answer = told(points, solved(points, strokes, sigma, mode))
        assert set(answer.outliers.tolist()) == outside


@pytest.mark.parametrize("mode", ["auto", "reject", "keep"])
def test_labels_and_outliers_by_mode(mode):
    sample = point_set("ellipse", n=2000, sigma=0.01, outliers=0.05, seed=2)
    answer = pca(sample.points, PcaParameters(outliers=mode))
    parts = partition(sample.points, PartitionParameters())
    cut = set(np.flatnonzero(parts.labels < 0).tolist())
    assert cut <= set(answer.outliers.tolist())
    if mode == "keep":
        assert cut == set(answer.outliers.tolist())
    else:
        np.testing.assert_array_equal(answer.outliers, np.flatnonzero(answer.labels < 0))


def test_two_sound_components_have_two_frames():
    rng = np.random.default_rng(3)
    rings = []
    for k in range(2):
        flat = np.pad(arc(1500, 0.01, seed=k), ((0, 0), (0, 1)))
        rings.append(flat @ rotation(rng, 3).T + [0.0, 0.0, 5.0 * k])
    answer = pca(np.concatenate(rings))
    assert len(answer.frames) == len(answer.curves) == 2
    for frame in answer.frames:
        points = rings[int(frame.origin[2] > 2.5)]
        truth = principal_frame(points)
        assert abs(frame.axes[2] @ truth.axes[2]) > 1 - 1e-9
        assert frame.planarity > 0.9
