import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import DegenerateInput
from core.results import Curve
from core.surface.axis import axis_frame
from core.surface.parameters import SurfaceParameters
from core.surface.results import ContourLevel
from core.surface.skin import surface_of
from core.truth.stacks import closed_curve, random_stack
from tests.core.surface.contours import ring, square, stack


def sphere(count, radius=50.0, vertices=200):
    heights = radius * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    return stack(*([ring(np.sqrt(radius**2 - z**2), count=vertices)] for z in heights), heights=heights)


def torus(count, big=30.0, small=12.0):
    """It lies: two contours a level."""
    heights = small * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    widths = np.sqrt(small**2 - heights**2)
    levels = ([ring(big + w, count=200), ring(big - w, count=200)] for w in widths)
    return stack(*levels, heights=heights)


def middles(mesh):
    return mesh.vertices[mesh.faces].mean(axis=1)


def areas(mesh):
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


@pytest.mark.parametrize("method", ["slabs", "distance"])
def test_a_sphere_is_met_better_with_more_levels(method):
    errors = []
    for count in (12, 24):
        surface = surface_of(sphere(count), SurfaceParameters(method=method))
        assert (surface.report.components, surface.report.genus, surface.report.method) == (1, 0, method)
        off = np.linalg.norm(middles(surface.mesh), axis=1) - 50.0
        errors.append(np.sqrt(np.average(off**2, weights=areas(surface.mesh))))
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.5
    assert surface.report.volume == pytest.approx(4.0 / 3.0 * np.pi * 50.0**3, rel=1e-2)


@pytest.mark.parametrize("method", ["slabs", "distance"])
def test_a_torus_has_a_hole(method):
    report = surface_of(torus(20), SurfaceParameters(method=method)).report
    assert (report.components, report.genus, report.closed, report.manifold) == (1, 1, True, True)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.2, 0.7]))
def test_any_stack_gives_a_sound_surface_by_slabs(seed, similarity):
    surface = surface_of(random_stack(seed), SurfaceParameters(similarity=similarity))
    report = surface.report
    assert (report.closed, report.manifold, report.self_intersections, report.method) == (
        True,
        True,
        0,
        "slabs",
    )
    assert report.volume > 0.0
    assert not surface.warnings


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_stack_gives_a_sound_surface_by_distances(seed):
    report = surface_of(random_stack(seed), SurfaceParameters(method="distance")).report
    assert (report.closed, report.manifold, report.self_intersections) == (True, True, 0)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_order_of_levels_contours_and_vertices_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    levels = random_stack(seed)
    shuffled = []
    for k in rng.permutation(len(levels)):
        curves = [levels[k].curves[j].vertices for j in rng.permutation(len(levels[k].curves))]
        curves = [np.roll(c, rng.integers(len(c)), axis=0)[:: rng.choice([-1, 1])] for c in curves]
        shuffled.append(ContourLevel(levels[k].height, tuple(closed_curve(c) for c in curves)))
    one, other = surface_of(levels).mesh, surface_of(shuffled).mesh
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.faces, other.faces)


def test_contours_in_place_along_any_axis():
    frame = axis_frame((1.0, -2.0, 0.5))
    levels = sphere(10)
    centre = np.array((7.0, 8.0, 9.0))
    lifted = [
        ContourLevel(
            each.height + float(centre @ frame.axes[2]),
            tuple(closed_curve(frame.lift(c.vertices, each.height) + centre) for c in each.curves),
        )
        for each in levels
    ]
    one = surface_of(levels)
    other = surface_of(lifted, SurfaceParameters(axis=(1.0, -2.0, 0.5)))
    assert other.report.genus == 0
    assert other.report.volume == pytest.approx(one.report.volume, rel=1e-2)
    assert np.allclose(np.linalg.norm(other.mesh.vertices - centre, axis=1).max(), 50.0, atol=5.0)


def test_open_contours_are_left_out_and_said():
    arc = Curve(ring(1.0).vertices[:40], False, 0, 4.0, 40, 0.0)
    surface = surface_of(stack([ring(2.0)], [ring(2.0), arc], [ring(2.0)]))
    assert [each.code for each in surface.warnings] == ["open-contour"]
    assert surface.report.genus == 0
    assert surface.report.components == 1


def test_completed_levels_are_reported():
    levels = sphere(6)
    levels[2] = ContourLevel(levels[2].height, levels[2].curves, completed=True)
    surface = surface_of(levels)
    assert surface.report.completed_levels == (levels[2].height,)
    assert surface.slices == tuple(levels)


def test_contours_that_cancel_determine_no_surface():
    with pytest.raises(DegenerateInput):
        surface_of(stack([square(0, 0, 1), square(0, 0, 1)], []))
    with pytest.raises(DegenerateInput):
        surface_of(stack([square(0, 0, 1), square(0, 0, 1)], []), SurfaceParameters(method="distance"))
