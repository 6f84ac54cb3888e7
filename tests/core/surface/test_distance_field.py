import numpy as np
import pytest

from core.surface.distance_field import mesh_of_distances
from core.surface.mesh_report import is_sound, report_of
from core.surface.regions import regions_of
from tests.core.surface.contours import ring, square, stack


def surface(levels, attempt=0):
    mesh = mesh_of_distances(regions_of(levels, np.eye(3)), attempt)
    report = report_of(mesh, "distance")
    assert is_sound(report)
    return mesh, report


@pytest.mark.parametrize("attempt", [0, 1])
def test_a_cylinder_between_its_levels(attempt):
    mesh, _ = surface(stack(*[[ring(3.0, (5.0, -2.0))]] * 4, heights=(0.0, 1.0, 3.0, 3.5)), attempt)
    body = (mesh.vertices[:, 2] > 0.0) & (mesh.vertices[:, 2] < 3.5)
    distance = np.hypot(mesh.vertices[body, 0] - 5.0, mesh.vertices[body, 1] + 2.0)
    # The 60-gon lies within the circle by 0.004.
    assert np.all((distance > 2.985) & (distance < 3.01))


def test_a_cone_is_straight_between_levels():
    mesh, _ = surface(stack([ring(4.0, count=400)], [ring(2.0, count=400)]))
    body = (mesh.vertices[:, 2] > 0.0) & (mesh.vertices[:, 2] < 1.0)
    error = np.hypot(*mesh.vertices[body, :2].T) - (4.0 - 2.0 * mesh.vertices[body, 2])
    assert np.abs(error).max() < 8.0 / 256.0  # a pixel
    assert np.sqrt((error**2).mean()) < 0.1 * 8.0 / 256.0


def test_holes_and_branches():
    _, tube = surface(stack(*[[ring(2.0), ring(1.0)]] * 3))
    assert (tube.components, tube.genus) == (1, 1)
    _, fork = surface(stack([ring(2.0)], [ring(1.8)], [ring(0.8, (-1.0, 0.0)), ring(0.8, (1.0, 0.0))]))
    assert (fork.components, fork.genus) == (1, 0)


def test_an_empty_level_parts_the_surface():
    _, report = surface(stack([square(0, 0, 1)], [], [square(0, 0, 1)]))
    assert report.components == 2
