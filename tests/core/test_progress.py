"""Fractions of the work that is done: ascending, finely enough, and without any effect on the answer."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.methods import diagnose, partition, pca, reconstruct, skeleton
from core.progress import tell, within
from core.results import Partition
from core.truth import point_set
from tests.core.shapes import arc

FRACTIONS = st.floats(0.0, 1.0)
METHODS = [pca, skeleton, reconstruct, diagnose]


class Heard:
    """Keeps what it is told."""

    def __init__(self):
        self.fractions = []
        self.words = []

    def __call__(self, fraction, what):
        self.fractions.append(fraction)
        self.words.append(what)


def rings(*counts):
    return np.concatenate([arc(n, 0.01, seed=k) + np.array([5.0 * k, 0.0]) for k, n in enumerate(counts)])


# ---------------------------------------------------------------- shares


@given(st.lists(FRACTIONS, min_size=1), st.lists(FRACTIONS, min_size=1, max_size=6), FRACTIONS, FRACTIONS)
def test_shares_of_shares_ascend_and_meet(told, cuts, one, other):
    heard = Heard()
    low, high = sorted((one, other))
    cuts = [0.0, *sorted(cuts), 1.0]
    for start, end in pairwise(cuts):
        share = within(within(heard, low, high), start, end)
        for fraction in [0.0, *sorted(told), 1.0]:
            tell(share, fraction, "")
    assert np.all(np.diff(heard.fractions) >= 0.0)
    assert heard.fractions[0] == low
    assert heard.fractions[-1] == high


def test_parts_say_where_they_are():
    heard = Heard()
    tell(within(within(heard, 0.5, 1.0, "second half: "), 0.0, 0.5, "slice 3 of 4: "), 0.5, "cutting")
    assert heard.fractions == [0.625]
    assert heard.words == ["second half: slice 3 of 4: cutting"]


def test_nobody_needs_to_listen():
    assert within(None, 0.0, 1.0) is None
    tell(None, 0.5, "nothing")


# ---------------------------------------------------------------- methods


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("points", [arc(700, 0.01), rings(300, 200, 60), point_set("figure_8", n=900).points])
def test_fractions_ascend_from_nothing_to_all(method, points):
    heard = Heard()
    method(points, progress=heard)
    assert np.all(np.diff(heard.fractions) >= 0.0)
    assert heard.fractions[0] == 0.0
    assert heard.fractions[-1] == 1.0
    assert heard.fractions.count(1.0) == 1
    assert all(heard.words)


@pytest.mark.parametrize("method", METHODS)
def test_one_component_alone_advances_several_times(method):
    heard = Heard()
    method(arc(600, 0.01), progress=heard)
    assert len(set(heard.fractions)) >= 6
    assert len(set(heard.words)) >= 5
    assert max(np.diff(heard.fractions)) < 0.6


@pytest.mark.parametrize("method", METHODS)
def test_a_component_has_a_share_that_grows_with_its_samples(method):
    heard = Heard()
    method(rings(20_000, 500, 400), progress=heard)
    begun = {word: part for part, word in zip(heard.fractions, heard.words, strict=True) if "scale" in word}
    first, second, third = (begun[f"component {k} of 3: estimating its scale"] for k in (1, 2, 3))
    assert first < second < third
    assert second - first > 3.0 * (third - second)


def test_a_partition_tells_that_it_is_done():
    heard = Heard()
    assert isinstance(partition(arc(300, 0.01), progress=heard), Partition)
    assert heard.fractions == [0.0, 1.0]


@pytest.mark.parametrize("method", METHODS)
def test_whoever_listens_may_end_the_computation(method):
    class EnoughError(Exception):
        pass

    def listen(fraction, what):
        if fraction > 0.3:
            raise EnoughError(what)

    with pytest.raises(EnoughError):
        method(arc(300, 0.01), progress=listen)


@pytest.mark.parametrize("method", METHODS)
def test_the_answer_is_the_same_whether_anybody_listens_or_not(method):
    points = rings(300, 200)
    told, untold = method(points, progress=Heard()), method(points)
    assert told.reason == untold.reason
    assert told.sampling.sigma == untold.sampling.sigma
    assert np.array_equal(told.outliers, untold.outliers)
