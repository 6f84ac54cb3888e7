import numpy as np
import pytest

from core.cloud.partition import partition
from core.errors import InvalidParameter
from core.parameters import PcaParameters, ReconstructParameters, SkeletonParameters
from core.prepared import prepared
from core.truth import point_set
from tests.core.shapes import arc, in_a_tilted_plane


def prepare(points, parameters=None):
    parameters = parameters or ReconstructParameters()
    (component,) = partition(points).components
    return prepared(points, np.arange(len(points)), component, parameters)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_working_coordinates_are_the_samples_seen_from_their_frame(scale):
    points = scale * (arc(300, 0.01) + np.array([7.0, -3.0]))
    one = prepare(points)
    assert np.allclose(one.frame.restore(one.sample.points), points, rtol=1e-12)
    assert one.extent == pytest.approx(np.sqrt(2.0), rel=0.15)  # root mean square one per coordinate
    assert one.scale.sigma * one.frame.scale == pytest.approx(0.01 * scale, rel=0.3)


def test_repeated_samples_are_kept_but_asked_only_once():
    points = np.repeat(arc(200, 0.01), 3, axis=0)
    one = prepare(points)
    assert len(one.sample.points) == 600
    assert len(one.once.points) == 200


@pytest.mark.parametrize(
    ("parameters", "flat", "quasi_planar"),
    [
        (PcaParameters(), False, False),
        (PcaParameters(planar=True), True, False),
        (PcaParameters(planar=False), False, True),
        (SkeletonParameters(), True, False),
        (ReconstructParameters(), False, False),
        (ReconstructParameters(planar=True), True, False),
    ],
)
def test_what_is_projected(parameters, flat, quasi_planar):
    one = prepare(point_set("helix", n=600, sigma=0.005).points, parameters)
    assert one.frame.flat is flat
    assert one.quasi_planar is quasi_planar


@pytest.mark.parametrize("parameters", [PcaParameters(), SkeletonParameters(), ReconstructParameters()])
def test_a_tilted_plane_is_a_plane(parameters):
    points, _ = in_a_tilted_plane(arc(400, 0.01), 2, 0.005)
    one = prepare(points, parameters)
    assert one.frame.flat
    assert one.quasi_planar
    assert np.all(one.sample.points[:, 2] == 0.0)


def test_the_spacing_of_vertices_is_in_working_units():
    one = prepare(10.0 * arc(300, 0.01), ReconstructParameters(vertex_spacing=0.5))
    assert one.spacing * one.frame.scale == pytest.approx(0.5)
    assert prepare(arc(300, 0.01)).spacing is None


def test_a_spacing_that_no_memory_could_hold_is_refused():
    with pytest.raises(InvalidParameter) as error:
        prepare(arc(300, 0.01), ReconstructParameters(vertex_spacing=1e-9))
    assert error.value.loc == ("parameters", "vertex_spacing")
