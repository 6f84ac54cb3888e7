"""Computations in parts: solved anywhere and in any order, they give the same to the last bit."""

import pickle
import subprocess
import sys
from dataclasses import fields, is_dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core import divisions, methods
from core.division import Part, balanced
from core.errors import DegenerateInput, InvalidParameter, InvalidPoints
from core.parameters import PcaParameters, ReconstructParameters, SkeletonParameters
from core.truth import point_set
from tests.core.shapes import arc

WORK = st.lists(st.floats(1.0, 1e6), min_size=1, max_size=60)
ALL = [
    (methods.pca, divisions.PCA, PcaParameters(planar=False, outliers="reject", seed=3), {"stages": True}),
    (methods.skeleton, divisions.SKELETON, SkeletonParameters(crossings="split"), {"stages": True}),
    (methods.reconstruct, divisions.RECONSTRUCT, ReconstructParameters(), {"stages": True}),
    (methods.diagnose, divisions.DIAGNOSE, ReconstructParameters(), {}),
]


def assert_same(one, other):
    """Equal to the last bit."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert one.tobytes() == other.tobytes()
    elif is_dataclass(one):
        for each in fields(one):
            assert_same(getattr(one, each.name), getattr(other, each.name))
    elif isinstance(one, tuple | list):
        assert len(one) == len(other)
        for mine, its in zip(one, other, strict=True):
            assert_same(mine, its)
    else:
        assert one == other


# ---------------------------------------------------------------- balance


@given(WORK)
def test_every_piece_is_in_one_part(work):
    groups = balanced(work)
    assert not groups or sorted(k for group in groups for k in group) == list(range(len(work)))
    assert len(groups) <= 16
    assert len(groups) != 1
    assert all(group == sorted(group) for group in groups)
    assert groups == balanced(work)


@given(WORK)
def test_no_part_takes_much_longer_than_it_must(work):
    groups = balanced(work)
    loads = [sum(work[k] for k in group) for group in groups]
    assert all(one >= other * (1 - 1e-12) for one, other in pairwise(loads))
    if groups:  # Graham's bound
        assert loads[0] <= sum(work) / len(groups) + max(work)


@pytest.mark.parametrize(
    "work",
    [[1e6], [9000.0] * 5, [1e6, 1e5, 1e5], [1.0] * 1000, []],
    ids=["one", "few", "most", "tiny", "none"],
)
def test_what_is_not_worth_dividing(work):
    assert balanced(work) == []


def test_small_pieces_fill_up_beside_large_ones():
    assert balanced([5e4, 4.9e4, *[100.0] * 10]) == [[0], list(range(1, 12))]


# ---------------------------------------------------------------- the same answer


@lru_cache
def cloud():
    """Eleven components of several kinds, three of them crossing themselves, and outliers."""
    rng = np.random.default_rng(1)
    kinds = ["circle", "figure_8", "ellipse"]
    places = [
        point_set(kinds[k % 3], n=140 + 20 * k, sigma=0.01, seed=k).points + 6.0 * np.array([k % 4, k // 4])
        for k in range(10)
    ]
    clump = rng.normal(0.0, 0.02, (40, 2)) + 18.0
    cloud = np.concatenate([*places, clump, rng.uniform(-3.0, 21.0, (20, 2))])
    return cloud[rng.permutation(len(cloud))]


def in_space():
    return np.column_stack([cloud(), 0.1 * np.sin(cloud() @ [0.3, 0.2])])


@pytest.mark.parametrize(("whole", "division", "parameters", "flags"), ALL)
def test_parts_in_any_order_give_the_undivided_answer(whole, division, parameters, flags):
    points = in_space() if getattr(parameters, "planar", True) is False else cloud()
    parts = division.split(points, parameters)
    assert len(parts) > 3
    solved = [division.solve(part, None) for part in reversed(parts)]
    answer = division.join(points, parameters, solved, **flags)
    assert_same(answer, whole(points, parameters, **flags))


def test_parts_are_solved_in_another_process():
    points = cloud()
    parts = divisions.PCA.split(points, None)
    code = (
        "import pickle, sys; from core.divisions import PCA\n"
        "part = pickle.load(sys.stdin.buffer); pickle.dump(PCA.solve(part, None), sys.stdout.buffer)"
    )
    first, *others = parts
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, input=pickle.dumps(first), capture_output=True, check=True)  # noqa: S603
    solved = [pickle.loads(run.stdout), *(divisions.PCA.solve(part, None) for part in others)]  # noqa: S301
    assert_same(divisions.PCA.join(points, None, solved), methods.pca(points))


def test_parts_hold_each_sample_of_a_component_once():
    points = cloud()
    parts = divisions.RECONSTRUCT.split(points, None)
    pieces = sorted((piece for part in parts for piece in part.pieces), key=lambda each: each.component.label)
    labels = methods.partition(points).labels
    assert [piece.component.label for piece in pieces] == list(range(labels.max() + 1))
    for piece in pieces:
        assert np.array_equal(piece.members, np.flatnonzero(labels == piece.component.label))
        assert np.array_equal(piece.points, points[piece.members])


def test_parts_have_names_and_the_largest_comes_first():
    parts = divisions.RECONSTRUCT.split(cloud(), None)
    assert all(isinstance(part, Part) for part in parts)
    assert len({part.name for part in parts}) == len(parts)
    assert all(one.work >= other.work for one, other in pairwise(parts))


def test_a_part_tells_how_far_it_has_come():
    part = divisions.PCA.split(cloud(), None)[0]
    told = []
    divisions.PCA.solve(part, lambda fraction, what: told.append((fraction, what)))
    fractions = [fraction for fraction, _ in told]
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert np.all(np.diff(fractions) >= 0.0)
    assert len(fractions) > 2 * len(part.pieces)
    assert told[0][1].startswith(f"component {part.pieces[0].component.label + 1} of {part.count}: ")


# ---------------------------------------------------------------- where nothing is divided, or wrong


@pytest.mark.parametrize("points", [arc(300, 0.01), arc(60_000, 0.01)], ids=["small", "one"])
def test_clouds_that_are_not_worth_dividing(points):
    assert divisions.RECONSTRUCT.split(points, None) == ()


def test_two_large_components_are_two_parts():
    points = np.concatenate([arc(30_000, 0.01), arc(25_000, 0.01, seed=1) + 5.0])
    assert [len(part.pieces) for part in divisions.SKELETON.split(points, None)] == [1, 1]


def test_input_is_checked_before_anything_is_solved():
    with pytest.raises(InvalidPoints):
        divisions.PCA.split([[0.0, np.nan]] * 20, None)
    with pytest.raises(DegenerateInput):
        divisions.PCA.split(np.zeros((100, 2)), None)


def test_an_error_in_a_part_is_that_of_the_whole():
    parameters = PcaParameters(vertex_spacing=1e-12)
    part = divisions.PCA.split(cloud(), parameters)[0]
    with pytest.raises(InvalidParameter) as there:
        divisions.PCA.solve(part, None)
    with pytest.raises(InvalidParameter) as here:
        methods.pca(cloud(), parameters)
    assert there.value.args == here.value.args


def test_parts_without_any_curve_are_told_like_the_whole():
    with pytest.raises(DegenerateInput, match="No curve"):
        divisions.PCA.join(cloud(), None, [(), ()])
