import numpy as np
import pytest

from core.march.fragments import march_all
from core.march.strip import N_ALL
from core.march.walk import RADIUS
from core.refine.polyline import Polyline
from core.truth import point_set
from tests.core.march.walks import scene
from tests.core.shapes import arc, diagonal, distances, line


def walked(points, flat=True, **fixed):
    sample, pace = scene(points, flat, **fixed)
    fragments, passed = march_all(sample.points, pace)
    return fragments, passed, pace


def pieces(name, flat=True, **drawn):
    sample = point_set(name, **drawn)
    fragments, passed, pace = walked(sample.points, flat)
    truth = [c.vertices - sample.points.mean(axis=0) for c in sample.curves]
    return fragments, passed, pace, truth


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("sigma", [0.005, 0.05])
def test_the_march_closes_on_a_circle(sigma, seed):
    points = arc(2000, sigma, seed=seed)
    fragments, passed, _ = walked(points)
    assert [f.closed for f in fragments] == [True]
    assert passed.mean() > 0.95
    x, y = fragments[0].centres[:, :2].T + points.mean(axis=0)[:, None]
    assert np.abs(np.hypot(x, y) - 1.0).max() < sigma
    turn = np.unwrap(np.arctan2(y, x))
    assert abs(turn[-1] - turn[0]) < 2 * np.pi + 0.5  # once around and no more


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("turn", [2.0, 5.0])
def test_the_march_stops_at_the_ends(turn, seed):
    points = arc(2000, 0.01, turn=turn, seed=seed)
    fragments, passed, _ = walked(points)
    assert [f.closed for f in fragments] == [False]
    assert passed.mean() > 0.9
    ends = fragments[0].centres[[0, -1], :2] + points.mean(axis=0)
    truth = np.array([(1.0, 0.0), (np.cos(turn), np.sin(turn))])
    gaps = np.linalg.norm(ends[:, None] - truth, axis=2)
    reach = fragments[0].nodes[[0, -1], RADIUS].max()
    assert min(gaps[0, 0] + gaps[1, 1], gaps[0, 1] + gaps[1, 0]) < 2 * reach
    assert fragments[0].length == pytest.approx(turn, abs=2 * reach)


@pytest.mark.parametrize("seed", range(4))
def test_a_crossing_is_marched_straight_through(seed):
    fragments, passed, pace, (truth,) = pieces("figure_8", n=3000, sigma=0.005, seed=seed)
    assert passed.mean() > 0.95
    longest = max(fragments, key=lambda f: f.length)
    assert longest.closed
    assert distances(longest.centres[:, :2], truth, True).max() < 3 * pace.scale.sigma
    # Both lobes, once each; all else are leavings of the crossing.
    assert all(f.length < 0.1 * longest.length for f in fragments if f is not longest)
    around = Polyline(longest.centres, True).length
    assert around == pytest.approx(point_set("figure_8").curves[0].length, rel=0.05)


@pytest.mark.parametrize(
    ("name", "flat"), [("spiral", True), ("nested", True), ("helix", False), ("trefoil", False)]
)
def test_every_stretch_is_passed_and_nothing_else(name, flat):
    fragments, passed, pace, truth = pieces(name, flat, n=4000, sigma=0.005, seed=1)
    assert passed.mean() > 0.95
    centres = np.concatenate([f.centres for f in fragments])[:, : truth[0].shape[1]]
    near = np.min([distances(centres, t, True) for t in truth], axis=0)
    assert np.quantile(near, 0.95) < 2 * pace.scale.sigma
    length = sum(np.linalg.norm(np.diff(t, axis=0), axis=1).sum() for t in truth)
    assert 0.9 * length < sum(f.length for f in fragments) < 1.2 * length


@pytest.mark.parametrize("name", ["ellipse", "s_shape", "figure_8", "flower"])
def test_directions_are_unit_vectors_that_point_ahead(name):
    fragments, _, _, _ = pieces(name, seed=2)
    for fragment in fragments:
        direction = fragment.nodes[:, 3:6]
        np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0)
        # v_i . v_{i+1} > 0 (4.2.2), and each points to the next vertex.
        assert np.all(np.einsum("ij,ij->i", direction[:-1], direction[1:]) > 0)
        assert np.all(np.einsum("ij,ij->i", direction[:-1], np.diff(fragment.centres, axis=0)) > 0)


@pytest.mark.parametrize("radius", [0.15, 0.3])
def test_a_given_radius_is_that_of_every_ball(radius):
    fragments, _, _ = walked(arc(3000, 0.01), radius=radius)
    nodes = np.concatenate([f.nodes for f in fragments])
    np.testing.assert_allclose(nodes[:, RADIUS], radius)


@pytest.mark.parametrize("step", [0.03, 0.1])
def test_a_given_step_is_the_distance_from_ball_to_ball(step):
    sigma = 0.005
    fragments, _, _ = walked(arc(3000, sigma), step=step)
    gaps = np.concatenate([np.linalg.norm(np.diff(f.centres, axis=0), axis=1) for f in fragments])
    # A fit moves each centre across the course, by less than the noise.
    assert np.median(gaps) == pytest.approx(step, rel=0.05)
    assert np.quantile(np.abs(gaps - step), 0.9) < sigma


@pytest.mark.parametrize("uses", [1, 2, 8])
def test_a_sample_is_used_in_no_more_balls_than_allowed(uses):
    points = arc(3000, 0.02)
    fragments, _, _ = walked(points, max_uses=uses)
    counted = sum(f.nodes[:, N_ALL].sum() for f in fragments)
    # Refitting moves a ball by a fraction of its radius after its samples were counted.
    assert 0 < counted <= 1.15 * uses * len(points)


def test_more_uses_allow_more_balls():
    points = arc(3000, 0.02)
    used = [sum(f.nodes[:, N_ALL].sum() for f in walked(points, max_uses=k)[0]) for k in (1, 2, 3)]
    assert used[0] < used[1] < used[2]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("shape", ["normal", "uniform"])
@pytest.mark.parametrize("fixed", [{}, {"radius": 0.2}, {"step": 0.02}, {"max_uses": 100}])
def test_a_blob_is_no_endless_loop(shape, seed, fixed):
    points = getattr(np.random.default_rng(seed), shape)(size=(1500, 2))
    sample, pace = scene(points, **fixed)
    if pace.scale is None:
        return
    fragments, _ = march_all(sample.points, pace)
    assert sum(len(f.nodes) for f in fragments) <= 4 * len(points)


@pytest.mark.parametrize("flat", [True, False])
def test_a_straight_segment_is_one_fragment(flat):
    fragments, passed, _ = walked(line(1500, 0.005, length=2.0, dimension=2 if flat else 3), flat)
    assert [f.closed for f in fragments] == [False]
    assert passed.mean() > 0.9
    assert fragments[0].length == pytest.approx(2.0, rel=0.3)


def test_both_estimators_start_the_same_march():
    points = arc(1500, 0.02)
    (one,), _, _ = walked(points, estimator="pca")
    (two,), _, _ = walked(points, estimator="least_squares", seed=7)
    assert one.closed
    assert two.closed
    assert distances(one.centres, two.centres, True).max() < 1e-6


def test_far_apart_curves_are_fragments_of_their_own():
    one, two = arc(1000, 0.01, seed=1), arc(1000, 0.01, seed=2)
    two[:, 0] += 5.0
    fragments, passed, _ = walked(np.concatenate((one, two)))
    assert [f.closed for f in fragments] == [True, True]
    assert diagonal(fragments[0].centres) < 3.0
    assert passed.mean() > 0.95
