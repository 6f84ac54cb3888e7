import numpy as np
import pytest

from core.cloud.sampling import Sample
from core.refine.polyline import Polyline
from core.refine.principal_curve import as_they_are, refine_curves
from core.truth import oracle_rms, point_set
from core.truth.metrics import distances as nearest
from core.truth.metrics import rms, true_points
from tests.core.shapes import arc, distances, in_space, line, rotation


def ring(radius=1.0, count=200, turn=2 * np.pi):
    closed = turn == 2 * np.pi
    angle = np.linspace(0.0, turn, count, endpoint=not closed)
    return Polyline(in_space(radius * np.column_stack((np.cos(angle), np.sin(angle)))), closed)


def refined(points, first, sigma, flat=True, **options):
    return refine_curves(Sample.of(in_space(points)), [first], sigma, flat, **options)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_curvature_bias_is_removed(seed):
    sigma = 0.04 * 2 * np.sqrt(2.0)  # 4 % of the diagonal
    answer = refined(arc(20_000, sigma, seed=seed), ring(), sigma)
    radius = np.linalg.norm(answer.curves[0].vertices, axis=1).mean()
    # Plain averages lie kappa sigma^2 / 2 too far out; the mean itself has sigma / sqrt(N).
    assert abs(radius - 1.0) < 0.15 * sigma**2 + 2 * sigma / np.sqrt(20_000)


def test_in_space_the_bias_is_removed_too():
    sigma, rng = 0.08, np.random.default_rng(0)
    flat = in_space(arc(20_000, 0.0))
    turn = rotation(rng, 3)
    points = (flat + sigma * rng.normal(size=flat.shape)) @ turn.T
    first = ring()
    answer = refined(points, Polyline(first.vertices @ turn.T, True), sigma, flat=False)
    radius = np.linalg.norm(answer.curves[0].vertices, axis=1).mean()
    assert abs(radius - 1.0) < 0.2 * sigma**2 + 2 * sigma / np.sqrt(20_000)
    assert answer.sigma == pytest.approx(sigma, rel=0.05)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("sigma", [0.01, 0.05])
@pytest.mark.parametrize("turn", [2 * np.pi, 4.0])
def test_the_noise_is_estimated_within_a_twentieth(turn, sigma, seed):
    # Whatever noise it was told at first.
    answer = refined(arc(5000, sigma, turn=turn, seed=seed), ring(turn=turn), 1.2 * sigma)
    assert answer.sigma == pytest.approx(sigma, rel=0.05)
    np.testing.assert_allclose(answer.sigmas, answer.sigma, rtol=0.02)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("short", [-0.03, 0.0, 0.03])
def test_open_ends_are_where_the_curve_ends(seed, short):
    sigma = 0.02
    points = arc(4000, sigma, turn=4.0, seed=seed)
    first = ring(turn=4.0)
    # The march may have stopped a little early, or gone a little too far.
    first = Polyline(
        first.at(np.linspace(short, 4.0 - short, 200)) if short >= 0 else ring(turn=4.03).vertices, False
    )
    (curve,) = refined(points, first, sigma).curves
    assert not curve.closed
    for end, angle in ((0, 0.0), (-1, 4.0)):
        truth = np.array([np.cos(angle), np.sin(angle), 0.0])
        assert np.linalg.norm(curve.vertices[end] - truth) < 1.5 * sigma


def test_a_closed_curve_stays_closed():
    answer = refined(arc(2000, 0.02), ring(), 0.02)
    assert answer.curves[0].closed
    edges = np.linalg.norm(np.diff(answer.curves[0].ring, axis=0), axis=1)
    assert edges.max() < 1.2 * edges.min()


def test_a_straight_line_comes_out_straight():
    sigma = 0.01
    first = Polyline(in_space(np.array([(-2.0, 0.02), (2.0, -0.02)])), False)
    answer = refined(line(10_000, sigma, length=4.0), first, sigma)
    vertices = answer.curves[0].vertices
    assert np.abs(vertices[:, 1]).max() < sigma / 2
    assert np.abs(vertices[[0, -1], 0]).min() == pytest.approx(2.0, abs=1.5 * sigma)
    assert answer.sigma == pytest.approx(sigma, rel=0.05)


def test_samples_exactly_on_a_curve_leave_it_there():
    points = arc(2000, 0.0)
    answer = refined(points, ring(), 0.0)
    assert np.abs(np.linalg.norm(answer.curves[0].vertices, axis=1) - 1.0).max() < 2e-3
    assert answer.sigma < 2e-3


@pytest.mark.parametrize("name", ["ellipse", "wave", "bean", "cubic"])
def test_refinement_comes_near_the_oracle(name):
    sample = point_set(name, n=3000, sigma=0.01, seed=3)
    (truth,) = sample.curves
    rough = truth.exact.polyline(60)
    rng = np.random.default_rng(0)
    rough = rough + sample.sigma * rng.normal(size=rough.shape)  # as good as a march is
    answer = refined(sample.points, Polyline(in_space(rough), truth.closed), sample.sigma)
    curve = answer.curves[0]
    error = rms(nearest(true_points(sample.curves), [(curve.vertices[:, :2], curve.closed)]))
    assert error < 1.6 * oracle_rms(sample)


def test_the_standard_error_tells_how_far_off_the_curve_is():
    sigma, far = 0.03, []
    for seed in range(6):
        answer = refined(arc(1500, sigma, seed=seed), ring(), sigma)
        off = np.linalg.norm(answer.curves[0].vertices, axis=1) - 1.0
        assert len(answer.errors[0]) == len(off)
        far.append(np.mean(off**2) / np.mean(answer.errors[0] ** 2))
    assert 0.3 < np.mean(far) < 3.0


def test_every_sample_has_its_foot():
    points = in_space(arc(800, 0.02))
    answer = refined(points, ring(), 0.02)
    curve = answer.curves[0]
    assert np.count_nonzero(answer.feet.curve == 0) > 795
    near = answer.feet.curve == 0
    np.testing.assert_allclose(
        answer.feet.distance[near], distances(points[near], curve.vertices, curve.closed), atol=1e-9
    )


def test_two_curves_share_no_samples():
    inner, outer = arc(2000, 0.02, 1.0, seed=1), arc(3000, 0.04, 2.0, seed=2)
    sample = Sample.of(in_space(np.concatenate((inner, outer))))
    answer = refine_curves(sample, [ring(1.0), ring(2.0)], 0.03, True)
    for curve, radius in zip(answer.curves, (1.0, 2.0), strict=True):
        assert np.linalg.norm(curve.vertices, axis=1).mean() == pytest.approx(radius, abs=0.003)
    own = answer.feet.curve
    assert np.all((own == np.repeat([0, 1], [2000, 3000])) | (own < 0))
    assert np.count_nonzero(own < 0) < 5  # beyond four sigma
    np.testing.assert_allclose(answer.sigmas, [0.02, 0.04], rtol=0.06)
    assert 0.02 < answer.sigma < 0.04


def test_outliers_do_not_move_the_curve():
    clean = arc(2000, 0.01)
    stray = np.random.default_rng(1).uniform(-1.5, 1.5, size=(200, 2))
    stray = stray[np.abs(np.linalg.norm(stray, axis=1) - 1.0) > 0.1]
    one = refined(clean, ring(), 0.01).curves[0]
    two = refined(np.concatenate((clean, stray)), ring(), 0.01).curves[0]
    assert distances(one.vertices, two.vertices, True).max() < 0.002


def test_the_spacing_of_the_vertices_can_be_chosen():
    for first, points in ((ring(), arc(1000, 0.01)), (ring(turn=4.0), arc(1000, 0.01, turn=4.0))):
        (curve,) = refined(points, first, 0.01, spacing=0.05).curves
        steps = np.linalg.norm(np.diff(curve.ring, axis=0), axis=1)
        assert np.all((steps > 0.045) & (steps < 0.055))


def test_chords_deviate_less_than_the_standard_error():
    for n in (1000, 50_000):
        sample = Sample.of(in_space(arc(n, 0.01)))
        (curve,) = refine_curves(sample, [ring()], 0.01, True).curves
        chord = curve.length / len(curve.vertices)
        assert chord**2 / 8 < 0.5 * 0.01 / np.sqrt(n / 20)


@pytest.mark.parametrize("n", [0, 1, 5, 9])
def test_a_curve_with_hardly_any_sample_survives(n):
    far = in_space(arc(n, 0.01)) if n else np.full((1, 3), 50.0)
    answer = refine_curves(Sample.of(far), [ring()], 0.01, True)
    assert np.isfinite(answer.curves[0].vertices).all()
    assert np.isfinite(answer.sigma)


def test_as_they_are_moves_nothing():
    points, first = in_space(arc(2000, 0.02)), ring(1.003)
    answer = as_they_are(Sample.of(points), [first], 0.03, True)
    np.testing.assert_array_equal(answer.curves[0].vertices, first.vertices)
    assert answer.sigma == pytest.approx(0.02, rel=0.06)
    assert len(answer.errors[0]) == len(first.vertices)
    spaced = as_they_are(Sample.of(points), [first], 0.03, True, spacing=0.1).curves[0]
    assert distances(spaced.vertices, first.vertices, True).max() < 1e-12
    assert np.linalg.norm(np.diff(spaced.ring, axis=0), axis=1).max() <= 0.1


@pytest.mark.parametrize("factor", [1e-5, 1e5])
def test_refinement_scales(factor):
    points, first = arc(1000, 0.02), ring()
    one = refined(points, first, 0.02)
    two = refined(factor * points, Polyline(factor * first.vertices, True), factor * 0.02)
    assert two.sigma == pytest.approx(factor * one.sigma, rel=1e-6)
    np.testing.assert_allclose(two.curves[0].vertices, factor * one.curves[0].vertices, atol=1e-7 * factor)


def stroke(angle, n, sigma, seed, dimension=2):
    """Samples of a unit segment through the origin, and a wavy first approximation of it."""
    rng = np.random.default_rng(seed)
    way, side = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
    noise = sigma * rng.normal(size=(n, 3))
    noise[:, dimension:] = 0.0
    x = np.linspace(-0.5, 0.5, 150)[:, None]
    wave = 0.3 * sigma * np.sin(x / (3.0 * sigma))
    return rng.uniform(-0.5, 0.5, n)[:, None] * way + noise, Polyline(x * way + wave * side, False), side


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("degrees", [20, 45, 90])
def test_lines_that_cross_come_out_straight_with_their_whole_noise(degrees, dimension):
    sigma, n, far, noise = 0.01, 5000, [], []
    for seed in range(3):
        parts = [
            stroke(np.radians(turn), n, sigma, 2 * seed + k, dimension) for k, turn in enumerate((0, degrees))
        ]
        sample = Sample.of(np.concatenate([points for points, _, _ in parts]))
        answer = refine_curves(sample, [line for _, line, _ in parts], 1.1 * sigma, dimension == 2)
        noise += (answer.sigmas / sigma).tolist()
        for curve, error, (_, _, side) in zip(answer.curves, answer.errors, parts, strict=True):
            about = np.linalg.norm(curve.vertices, axis=1) < 4.0 * sigma / np.sin(np.radians(degrees))
            off = curve.vertices[about] @ side
            far.append(np.mean(off**2) / np.mean(error[about] ** 2))
    assert np.mean(far) < 2.0
    # Three standard errors of the mean of six estimates.
    assert np.mean(noise) == pytest.approx(1.0, abs=3.0 / np.sqrt(6 * 2 * n * (dimension - 1)))


@pytest.mark.parametrize("gap", [3.5, 4.5, 6.0])
def test_parallel_lines_do_not_push_each_other_away(gap):
    sigma, n = 0.01, 8000
    below, first, _ = stroke(0.0, n, sigma, 1)
    above, _, _ = stroke(0.0, 3 * n, sigma, 2)
    up = np.array([0.0, gap * sigma, 0.0])
    answer = refine_curves(
        Sample.of(np.concatenate((below, above + up))),
        [first, Polyline(first.vertices + up, False)], 1.1 * sigma, True,
    )  # fmt: skip
    for curve, height in zip(answer.curves, (0.0, gap * sigma), strict=True):
        off = curve.vertices[np.abs(curve.vertices[:, 0]) < 0.4, 1].mean() - height
        assert abs(off) < 3.5 * sigma / np.sqrt(n)
    np.testing.assert_allclose(answer.sigmas, sigma, rtol=0.025)
    assert answer.sigma == pytest.approx(sigma, rel=0.02)


@pytest.mark.parametrize("short", [-1.5, 0.0, 1.5])
@pytest.mark.parametrize("degrees", [60, 90])
def test_a_curve_that_ends_on_another_stops_there_and_leaves_it_straight(degrees, short):
    sigma, n = 0.01, 6000
    bar, first, _ = stroke(0.0, 2 * n, sigma, 1)
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    rng = np.random.default_rng(2)
    stem = rng.uniform(0.0, 0.5, n)[:, None] * way + sigma * in_space(rng.normal(size=(n, 2)))
    begun = Polyline(np.linspace(short * sigma, 0.5, 60)[:, None] * way, False)
    answer = refine_curves(Sample.of(np.concatenate((bar, stem))), [first, begun], 1.1 * sigma, True)
    middle = np.abs(answer.curves[0].vertices[:, 0]) < 0.3
    assert np.abs(answer.curves[0].vertices[middle, 1]).max() < 0.15 * sigma
    end, other = answer.curves[1].vertices[[0, -1]]
    assert np.linalg.norm(end) < 0.3 * sigma
    assert other @ way == pytest.approx(0.5, abs=1.5 * sigma)
    np.testing.assert_allclose(answer.sigmas, sigma, rtol=0.03)


@pytest.mark.parametrize("name", ["figure_8", "two_circles", "lissajous"])
def test_with_crossings_too_refinement_comes_near_the_oracle(name):
    sample = point_set(name, n=4000, sigma=0.01, seed=1)
    first = [Polyline(in_space(one.exact.polyline(200)), one.closed) for one in sample.curves]
    answer = refine_curves(Sample.of(in_space(sample.points)), first, 1.1 * sample.sigma, True)
    curves = [(curve.vertices[:, :2], curve.closed) for curve in answer.curves]
    error = rms(nearest(true_points(sample.curves), curves))
    assert error < 1.3 * oracle_rms(sample)
    assert answer.sigma == pytest.approx(sample.sigma, rel=0.04)


def test_curves_kept_as_they_are_see_their_whole_noise_too():
    points = [stroke(angle, 8000, 0.01, seed) for seed, angle in enumerate((0.0, 0.3))]
    straight = [Polyline(line.vertices[[0, -1]], False) for _, line, _ in points]
    answer = as_they_are(Sample.of(np.concatenate([part for part, _, _ in points])), straight, 0.01, True)
    np.testing.assert_allclose(answer.sigmas, 0.01, rtol=0.02)


def test_a_curve_far_away_changes_nothing():
    points, away = arc(3000, 0.02), arc(3000, 0.02, 0.5, seed=1)
    alone = refined(points, ring(), 0.02)
    both = refine_curves(Sample.of(in_space(np.concatenate((points, away)))), [ring(), ring(0.5)], 0.02, True)
    np.testing.assert_allclose(both.curves[0].vertices, alone.curves[0].vertices, atol=1e-9)
    assert both.sigmas[0] == pytest.approx(alone.sigmas[0], rel=1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_where_curves_cross_frame_and_order_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    parts = [stroke(angle, 1500, 0.02, k) for k, angle in enumerate((0.0, 0.6))]
    points = np.concatenate([part for part, _, _ in parts])
    lines = [line for _, line, _ in parts]
    once = refine_curves(Sample.of(points), lines, 0.02, True)
    turn = np.eye(3)
    turn[:2, :2] = rotation(rng, 2)
    moved = [Polyline(1000.0 * line.vertices @ turn.T, False) for line in lines]
    again = refine_curves(Sample.of(1000.0 * rng.permutation(points) @ turn.T), moved, 20.0, True)
    assert again.sigma == pytest.approx(1000.0 * once.sigma, rel=1e-6)
    for a, b in zip(once.curves, again.curves, strict=True):
        np.testing.assert_allclose(b.vertices, 1000.0 * a.vertices @ turn.T, atol=20.0 * 1e-4)
