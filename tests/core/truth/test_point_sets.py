import numpy as np
import pytest
from scipy.stats import chisquare, kstest

from core.errors import InvalidParameter
from core.truth import PointSet, describe, hard_names, held_apart_names, held_out_names, names, point_set
from core.truth.metrics import distances

EVERY = (*names(), *held_out_names(), *hard_names(), *held_apart_names())


def diagonal(sample):
    return np.linalg.norm(np.ptp(np.concatenate([one.vertices for one in sample.curves]), axis=0))


def lines(sample):
    return [(one.vertices, one.closed) for one in sample.curves]


@pytest.mark.parametrize("name", EVERY)
def test_samples_without_noise_lie_on_their_curves(name):
    sample = point_set(name, n=300, sigma=0.0)
    assert distances(sample.points, lines(sample)).max() < 1e-4 * diagonal(sample)  # chords sag
    for k, one in enumerate(sample.curves):
        here = sample.curve_of == k
        np.testing.assert_allclose(
            sample.points[here], one.exact.at(sample.u[here]), atol=1e-12 * diagonal(sample)
        )


@pytest.mark.parametrize("name", EVERY)
def test_every_curve_is_sampled_and_described(name):
    sample = point_set(name)
    assert isinstance(sample, PointSet)
    assert set(sample.curve_of) == set(range(len(sample.curves)))
    assert sample.points.shape == (len(sample.u), sample.curves[0].vertices.shape[1])
    assert np.isfinite(sample.points).all()
    assert describe(name)


@pytest.mark.parametrize("name", ["circle", "spiral", "disjoint", "helix", "random_open"])
@pytest.mark.parametrize("sigma", [0.0025, 0.02])
def test_noise_is_isotropic_and_as_large_as_asked(name, sigma):
    sample = point_set(name, n=20000, sigma=sigma, seed=4)
    assert sample.sigma == pytest.approx(sigma * diagonal(sample), rel=1e-4)
    exact = point_set(name, n=20000, sigma=0.0, seed=4).points
    noise = (sample.points - exact) / sample.sigma
    dimension = noise.shape[1]
    # six standard errors of a mean and of a covariance of 20 000 samples
    np.testing.assert_allclose(noise.mean(axis=0), 0.0, atol=6 / np.sqrt(20000))
    np.testing.assert_allclose(np.cov(noise.T), np.eye(dimension), atol=6 * np.sqrt(2 / 20000))


def test_noise_measured_against_the_truth_is_sigma():
    sample = point_set("circle", n=50000, sigma=0.005)
    residual = np.sqrt(np.mean(distances(sample.points, lines(sample)) ** 2))
    assert residual == pytest.approx(sample.sigma, rel=0.02)


@pytest.mark.parametrize("name", ["ellipse", "spiral", "nested", "trefoil", "parallel_waves"])
def test_samples_are_uniform_by_arc_length(name):
    sample = point_set(name, n=20000, seed=1)
    assert kstest(sample.u, "uniform").pvalue > 1e-4
    lengths = np.array([one.length for one in sample.curves])
    if len(lengths) > 1:
        counts = np.bincount(sample.curve_of)
        assert chisquare(counts, lengths / lengths.sum() * 20000).pvalue > 1e-4


def test_the_density_of_non_uniform_varies_eight_to_one():
    u = point_set("non_uniform", n=200000).u
    counts = np.histogram(u, bins=40, range=(0, 1))[0]
    assert counts.max() / counts.min() == pytest.approx(8.0, rel=0.15)


def test_no_sample_of_scans_is_far_from_the_outline():
    sample = point_set("multi_scan", n=20000)
    assert np.quantile(distances(sample.points, lines(sample)), 0.99) < 4 * sample.sigma


def test_order_says_nothing_about_place():
    sample = point_set("disjoint", n=20000, seed=5)
    assert abs(np.corrcoef(np.arange(20000), sample.u)[0, 1]) < 6 / np.sqrt(20000)
    assert abs(np.corrcoef(np.arange(20000), sample.curve_of)[0, 1]) < 6 / np.sqrt(20000)


CROSSED = [
    ("figure_8", 1),
    ("double_8", 3),
    ("lissajous", 7),
    ("ribbon", 1),
    ("limacon_loop", 1),
    ("looped_square", 4),
    ("pretzel", 3),
    ("bow", 2),
    ("pentagram", 5),
    ("trifolium_ribbon", 3),
]


@pytest.mark.parametrize(("name", "count"), CROSSED)
def test_crossings_are_where_two_branches_meet(name, count):
    sample = point_set(name, n=1)
    assert sample.crossings.shape == (count, 2)
    curve = sample.curves[0].exact
    u = np.linspace(0, 1, 20000, endpoint=False)
    points = curve.evaluate(u)
    for place in sample.crossings:
        near = u[np.linalg.norm(points - place, axis=1) < 2e-3 * curve.length]
        passes = np.split(near, np.flatnonzero(np.diff(near) > 0.01) + 1)
        wraps = len(passes) > 2 and near[0] < 0.001 and near[-1] > 0.999
        assert len(passes) - wraps == 2
        for one in passes:
            fine = np.linspace(one[0] - 1e-3, one[-1] + 1e-3, 20001)
            assert np.linalg.norm(curve.evaluate(fine) - place, axis=1).min() < 1e-5 * curve.length


def test_figure_8_crosses_at_its_centre():
    np.testing.assert_allclose(point_set("figure_8", n=1).crossings, [[0.0, 0.0]], atol=1e-12)


def test_circles_cross_where_both_have_their_radius():
    first, second = (one.exact for one in point_set("two_circles", n=1).curves)
    places = point_set("two_circles", n=1).crossings
    assert places.shape == (2, 2)
    for one in (first, second):
        centre = one.evaluate([0.0, 0.5]).mean(axis=0)
        radius = one.length / (2 * np.pi)
        np.testing.assert_allclose(np.linalg.norm(places - centre, axis=1), radius, rtol=1e-9)


def test_a_wave_crosses_the_line_of_its_zeros():
    places = point_set("wave_line", n=1).crossings
    np.testing.assert_allclose(sorted(places[:, 0]), [0.0, np.pi, 2 * np.pi], atol=1e-9)
    np.testing.assert_allclose(places[:, 1], 0.0, atol=1e-12)


@pytest.mark.parametrize(("name", "count"), [("t_junction", 1), ("y_junction", 1), ("fork", 1), ("theta", 2)])
def test_what_ends_on_another_curve_does_not_cross_it(name, count):
    sample = point_set(name, n=1)
    assert len(sample.crossings) == 0
    assert sample.junctions.shape == (count, 2)
    for place in sample.junctions:
        touching = [distances(place[None], [line])[0] < 1e-4 * diagonal(sample) for line in lines(sample)]
        assert sum(touching) > 1


def test_sets_without_crossings_have_no_junctions():
    assert point_set("disjoint", n=1).junctions.shape == (0, 2)
    assert point_set("helix", n=1).junctions.shape == (0, 3)


def test_outliers_come_on_top_and_anywhere_in_the_enlarged_box():
    sample = point_set("circle", n=4000, outliers=0.25, seed=2)
    stray = sample.curve_of == -1
    assert len(sample.points) == 5000
    assert stray.sum() == 1000
    assert np.isnan(sample.u[stray]).all()
    assert np.isfinite(sample.u[~stray]).all()
    margin = 0.1 * diagonal(sample)
    outside = np.abs(sample.points[stray]) > 1.0
    assert outside.any()
    assert np.all(np.abs(sample.points[stray]) <= 1.0 + margin + 1e-6)
    assert kstest(sample.points[stray][:, 0], "uniform", args=(-1 - margin, 2 + 2 * margin)).pvalue > 1e-4
    assert abs(np.corrcoef(np.arange(5000), stray)[0, 1]) < 6 / np.sqrt(5000)


def test_the_same_seed_gives_the_same_points_and_another_seed_others():
    one, same, other = (point_set("spiral", n=50, seed=seed) for seed in (7, 7, 8))
    np.testing.assert_array_equal(one.points, same.points)
    assert not np.any(one.points == other.points)


def test_the_truth_cannot_be_changed_through_one_point_set():
    vertices = point_set("circle", n=5).curves[0].vertices
    with pytest.raises(ValueError, match="read-only"):
        vertices[0] = 0.0


@pytest.mark.parametrize(
    ("arguments", "loc"),
    [
        ({"name": "dodecagon"}, "name"),
        ({"name": "circle", "n": 0}, "n"),
        ({"name": "circle", "n": 5_000_001}, "n"),
        ({"name": "circle", "sigma": -0.1}, "sigma"),
        ({"name": "circle", "sigma": 0.21}, "sigma"),
        ({"name": "circle", "sigma": float("nan")}, "sigma"),
        ({"name": "circle", "outliers": -0.1}, "outliers"),
        ({"name": "circle", "outliers": 0.91}, "outliers"),
        ({"name": "circle", "seed": -1}, "seed"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(arguments, loc):
    with pytest.raises(InvalidParameter) as refused:
        point_set(**arguments)
    assert refused.value.loc == (loc,)


def test_describing_an_unknown_name_is_refused():
    with pytest.raises(InvalidParameter):
        describe("dodecagon")
