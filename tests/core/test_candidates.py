from dataclasses import replace

import numpy as np
import pytest

from core.candidates import by_march, by_neighbours, by_tape, crossings_read
from core.cloud.partition import partition
from core.parameters import ReconstructParameters
from core.prepared import prepared
from core.truth import point_set
from tests.core.shapes import arc, distances

PARAMETERS = ReconstructParameters()


def prepare(points):
    (component,) = partition(points).components
    return prepared(points, np.arange(len(points)), component, PARAMETERS)


@pytest.mark.parametrize("method", [by_march, by_tape])
@pytest.mark.parametrize("hasty", [False, True])
def test_both_methods_find_a_ring(method, hasty):
    one = replace(prepare(arc(30_000 if hasty else 600, 0.01)), hasty=hasty)
    candidate = method(one, PARAMETERS)
    (line,) = candidate.refined.curves
    assert line.closed
    assert np.abs(np.linalg.norm(one.frame.restore(line.vertices), axis=1) - 1.0).max() < 0.01
    assert len(candidate.refined.feet.curve) == len(one.sample.points)
    assert candidate.explained > 0.99
    assert not candidate.leaves_too_many
    assert (candidate.march is None) == (method is by_tape)
    assert (candidate.tape is None) == (method is by_march)


@pytest.mark.parametrize("factor", [0.6, 0.85])
def test_other_scales_find_the_same_ring(factor):
    one = prepare(arc(600, 0.01))
    for candidate in (by_march(one, PARAMETERS, (factor,)), by_tape(one, PARAMETERS, (factor,))):
        (line,) = candidate.refined.curves
        assert line.closed
        assert np.abs(np.linalg.norm(one.frame.restore(line.vertices), axis=1) - 1.0).max() < 0.01


def test_sparse_clean_samples_are_linked_in_order():
    angle = np.linspace(0.0, 2.0 * np.pi, 15, endpoint=False)
    points = np.column_stack([np.cos(angle), np.sin(angle)])[np.random.default_rng(0).permutation(15)]
    candidate = by_neighbours(prepare(points))
    (line,) = candidate.refined.curves
    assert line.closed
    assert len(line.vertices) == 15
    assert np.isnan(candidate.refined.errors[0]).all()


def test_a_blob_has_no_chain_of_neighbours():
    assert by_neighbours(prepare(np.random.default_rng(0).normal(size=(300, 2)))) is None


@pytest.mark.parametrize(("reading", "count"), [("through", 1), ("split", 2), ("waist", 1), ("graph", 2)])
def test_pieces_keep_the_standard_errors_of_their_curves(reading, count):
    one = prepare(point_set("figure_8", n=2000, sigma=0.008).points)
    straight = by_tape(one, PARAMETERS)
    read = crossings_read(one, straight, reading)
    assert len(read.refined.curves) == count
    low, high = np.min(straight.refined.errors[0]), np.max(straight.refined.errors[0])
    for line, errors in zip(read.refined.curves, read.refined.errors, strict=True):
        assert errors.shape == (len(line.vertices),)
        assert np.all((errors >= low - 1e-12) & (errors <= high + 1e-12))
        near = distances(line.vertices, straight.refined.curves[0].vertices, True)
        assert near.max() < 3.0 * straight.refined.sigma
    assert read.refined.sigma == straight.refined.sigma
