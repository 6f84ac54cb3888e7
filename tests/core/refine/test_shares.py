import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.refine.branches import near_branches
from core.refine.local_noise import LocalNoise
from core.refine.project import project
from core.refine.shares import noise_at, shares_of
from tests.core.refine.test_branches import CUT, SIGMA, figure_8, straight
from tests.core.shapes import in_space, rotation

FREE = (-np.inf, np.inf)


def shares(points, *lines, ends=None, normals=1, shared=True):
    sigmas = np.full(len(lines), SIGMA)
    feet = project(points, lines, CUT * SIGMA)
    branches = near_branches(lines, sigmas, CUT) if shared else None
    ends = np.array([FREE] * len(lines) if ends is None else ends)
    return shares_of(points, feet, sigmas, CUT, branches, ends, normals), feet


def along(line, n, rng, dimension=2):
    noise = SIGMA * rng.normal(size=(n, 3))
    noise[:, dimension:] = 0.0
    return line.at(rng.uniform(0.0, line.length, n)) + noise


def spread(share, normals=1):
    weight = np.ones(len(share.index)) if share.weight is None else share.weight
    return np.sqrt(np.sum(weight * share.distance**2) / weight.sum() / normals) / SIGMA


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.15, np.pi / 2))
def test_every_sample_is_given_away_once(seed, angle):
    rng = np.random.default_rng(seed)
    lines = [straight(), straight(angle=angle), figure_8()]
    points = np.concatenate([along(line, 500, rng) for line in lines])
    given_to, feet = shares(points, *lines)
    index = np.concatenate([share.index for share in given_to])
    weight = np.concatenate(
        [np.ones(len(share.index)) if share.weight is None else share.weight for share in given_to]
    )
    assert np.all(weight > 0.0)
    total = np.bincount(index, weight, len(points))
    np.testing.assert_allclose(total, feet.curve >= 0, atol=1e-12)
    assert all(np.all(share.distance < CUT * SIGMA) for share in given_to)


def test_far_from_everything_else_samples_are_wholly_their_curves():
    rng = np.random.default_rng(0)
    lines = straight(), straight(0.5)
    given_to, feet = shares(np.concatenate([along(line, 500, rng) for line in lines]), *lines)
    for k, share in enumerate(given_to):
        assert share.weight is None
        np.testing.assert_array_equal(share.index, np.flatnonzero(feet.curve == k))
        assert share.mass == len(share.index)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("degrees", [15, 40, 90])
def test_at_a_crossing_either_curve_sees_noise_of_the_right_size(degrees, dimension):
    rng = np.random.default_rng(1)
    lines = straight(), straight(angle=np.radians(degrees))
    points = np.concatenate([along(line, 60_000, rng, dimension) for line in lines])
    about = 4.0 * SIGMA / np.sin(np.radians(degrees))
    for shared in (True, False):
        given_to, _ = shares(points, *lines, normals=dimension - 1, shared=shared)
        parts = [share.only(np.abs(share.station - 0.5) < about) for share in given_to]
        sizes = [spread(part, dimension - 1) for part in parts]
        if shared:
            np.testing.assert_allclose(sizes, 1.0, atol=0.02)
            masses = [part.mass for part in parts]
            np.testing.assert_allclose(masses, 60_000 * 2.0 * about, rtol=0.04)
        else:  # the nearest curve takes it all: the noise of either is cut off
            assert max(sizes) < 0.97


@pytest.mark.parametrize("many", [1, 4])
def test_in_a_narrow_gap_weights_follow_the_densities(many):
    rng = np.random.default_rng(2)
    gap = 4.0 * SIGMA
    lines = straight(), straight(gap)
    points = np.concatenate((along(lines[0], 4000, rng), along(lines[1], 4000 * many, rng)))
    middle = in_space(np.column_stack((rng.uniform(-0.3, 0.3, 50), np.full(50, 0.4999 * gap))))
    (lower, upper), _ = shares(np.concatenate((points, middle)), *lines)
    for share, part in ((lower, 1.0 / (1 + many)), (upper, many / (1 + many))):
        between = share.weight[share.index >= len(points)]
        assert len(between) == 50
        assert np.mean(between) == pytest.approx(part, abs=0.04)
        assert spread(share) == pytest.approx(1.0, abs=0.04)
        offset = points[share.index[share.index < len(points)], 1] - (0.0 if share is lower else gap)
        mean = np.average(offset, weights=share.weight[share.index < len(points)])
        assert abs(mean) < 3.0 * SIGMA / np.sqrt(4000)


def test_beyond_its_end_an_open_curve_claims_little():
    rng = np.random.default_rng(3)
    bar, stem = straight(), straight(angle=np.pi / 2)
    # The stem's polyline runs through the bar; its samples end there, half way along.
    place = in_space(np.column_stack((np.zeros(10_000), rng.uniform(0.0, 0.5, 10_000))))
    noise = in_space(SIGMA * rng.normal(size=(10_000, 2)))
    points = np.concatenate((along(bar, 20_000, rng), place + noise))
    (on_bar, on_stem), _ = shares(points, bar, stem, ends=[FREE, (0.5, 1.0)])
    beyond = on_stem.only(on_stem.station < 0.5)
    # The samples that noise carries over the end: 0.4 rho sigma.
    assert beyond.mass == pytest.approx(0.4 * 20_000 * SIGMA, rel=0.25)
    inside = on_bar.only(np.abs(on_bar.station - 0.5) < 4.0 * SIGMA)
    assert inside.mass == pytest.approx(8.0 * SIGMA * 20_000, rel=0.06)
    assert spread(inside) == pytest.approx(1.0, abs=0.04)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_frame_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    lines = straight(), figure_8()
    points = np.concatenate([along(line, 400, rng) for line in lines])
    turn = rotation(rng, 3).T
    once, _ = shares(points, *lines)
    again, _ = shares(points @ turn, *[type(line)(line.vertices @ turn, line.closed) for line in lines])
    for a, b in zip(once, again, strict=True):
        assert b.mass == pytest.approx(a.mass, abs=1e-3)
        moment = [np.sum(share.weight * share.distance**2) for share in (a, b)]
        assert moment[1] == pytest.approx(moment[0], rel=1e-4)


def test_noise_at_a_foot_is_that_of_its_curve_there():
    local = [LocalNoise(np.array([0.0, 10.0]), np.array([1.0, 3.0])), LocalNoise.constant(5.0, 10.0)]
    curve, station = np.array([0, 0, 1, -1]), np.array([0.0, 5.0, 5.0, 0.0])
    assert noise_at(curve, station, np.array([2.0, 5.0]), local).tolist() == [1.0, 2.0, 5.0, 0.0]
    assert noise_at(curve, station, np.array([2.0, 5.0]), None).tolist() == [2.0, 2.0, 5.0, 0.0]


def test_the_cut_follows_the_noise_along_the_curve():
    line = straight()
    noise = LocalNoise(np.array([0.0, line.length]), SIGMA * np.array([0.5, 2.0]))
    points = line.at(np.linspace(0.0, line.length, 50)) + np.array([0.0, 3.0 * SIGMA, 0.0])
    feet = project(points, [line], 2.0 * CUT * SIGMA)
    (share,) = shares_of(points, feet, np.array([SIGMA]), CUT, None, np.array([FREE]), 1, [noise])
    assert share.index.tolist() == np.flatnonzero(CUT * noise.at(feet.station) > 3.0 * SIGMA).tolist()
    assert 0 < len(share.index) < 50


def test_where_noise_differs_a_sample_between_two_branches_is_rather_the_noisier_ones():
    lines = straight(), straight(0.0)
    lines = lines[0], type(lines[0])(lines[0].vertices + np.array([0.0, 6.0 * SIGMA, 0.0]), False)
    rng = np.random.default_rng(0)
    between = lines[0].at(np.linspace(0.2, 0.8, 9) * lines[0].length) + np.array([0.0, 3.0 * SIGMA, 0.0])
    points = np.concatenate([along(line, 500, rng) for line in lines] + [between])
    feet, sigmas = project(points, lines, CUT * SIGMA), np.full(2, SIGMA)
    branches, ends = near_branches(lines, sigmas, CUT), np.array([FREE, FREE])
    local = [
        LocalNoise.constant(SIGMA, lines[0].length),
        LocalNoise(np.array([0.0, 1.0]), SIGMA * np.array([1.5, 1.6])),
    ]
    shares = shares_of(points, feet, sigmas, CUT, branches, ends, 1, local)
    weights = [np.zeros(len(points)), np.zeros(len(points))]
    for share, weight in zip(shares, weights, strict=True):
        np.add.at(weight, share.index, 1.0 if share.weight is None else share.weight)
    assert np.all(weights[1][-9:] > weights[0][-9:])
