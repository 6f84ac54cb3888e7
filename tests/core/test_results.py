import dataclasses
import pickle

import numpy as np
import pytest

from core import results
from core.methods import partition, pca
from tests.core.shapes import arc


@pytest.mark.parametrize("name", results.__all__)
def test_results_are_frozen(name):
    kind = getattr(results, name)
    assert dataclasses.is_dataclass(kind)
    assert kind.__dataclass_params__.frozen


def same(a, b):
    """Whether two results agree in every field, arrays bit for bit."""
    if dataclasses.is_dataclass(a):
        names = [f.name for f in dataclasses.fields(a)]
        return type(a) is type(b) and all(same(getattr(a, n), getattr(b, n)) for n in names)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return np.array_equal(a, b)


def test_an_answer_crosses_process_borders_whole():
    answer = pca(arc(300, 0.02), stages=True)
    copy = pickle.loads(pickle.dumps(answer))  # noqa: S301 - our own bytes
    assert same(answer, copy)


def test_a_partition_counts_its_components():
    one, two = arc(100, 0.01, seed=1), arc(100, 0.01, seed=2)
    parts = partition(np.concatenate((one, two + 10.0)))
    assert parts.count == len(parts.components) == 2


def test_no_answer_carries_stages_unless_asked_for():
    points = arc(300, 0.02)
    assert pca(points).stages is None
    assert pca(points, stages=True).stages is not None
