import numpy as np
import pytest

from core.cloud.frame import principal_frame
from core.methods import partition, pca
from core.parameters import PartitionParameters, PcaParameters
from core.truth import point_set
from tests.core.shapes import arc, diagonal, distances, rotation


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


def test_close_branches_are_reported_as_violations():
    sigma = 0.01
    near = np.concatenate((arc(3000, sigma, 1.0, seed=1), arc(3000, sigma, 1.0 - 3.5 * sigma, seed=2)))
    far = np.concatenate((arc(3000, sigma, 1.0, seed=1), arc(3000, sigma, 1.0 - 12 * sigma, seed=2)))
    # Too near to be told apart, or told apart and reported: never a clean bill for two curves.
    answer = pca(near)
    assert len(answer.curves) != 2 or not answer.sampling.nyquist.compliant
    wide = pca(far)
    assert len(wide.curves) == 2
    nyquist = wide.sampling.nyquist
    assert nyquist.compliant
    assert nyquist.violations == ()
    assert nyquist.margin_sigmas == pytest.approx(12.0, abs=2.0)


def test_a_violation_says_where():
    # A hairpin whose strokes come near each other by and by.
    rng = np.random.default_rng(0)
    x = rng.uniform(0.0, 4.0, 6000)
    y = np.where(rng.uniform(size=6000) < 0.5, 1, -1) * (0.025 + 0.06 * x)
    points = np.column_stack((x, y)) + 0.015 * rng.normal(size=(6000, 2))
    answer = pca(points)
    nyquist = answer.sampling.nyquist
    assert not nyquist.compliant
    sigma = answer.sampling.sigma
    for violation in nyquist.violations:
        assert violation.location.shape == (2,)
        assert violation.gap_sigmas < 5.0
        assert violation.gap_sigmas >= nyquist.margin_sigmas
        away = np.sort([distances(violation.location[None], c.vertices, c.closed)[0] for c in answer.curves])
        assert away[0] < violation.gap_sigmas * sigma
        assert violation.reason


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
