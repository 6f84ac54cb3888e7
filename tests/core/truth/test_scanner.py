import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import InvalidParameter
from core.surface.range_image import triangulate
from core.truth.objects import distances, normals, solid, solid_names
from core.truth.scanner import Scanner, scan


def placed(image):
    """The points that an image sees, in place."""
    points = image.points.reshape(-1, 3) @ image.pose.rotation.T + image.pose.translation
    return points[np.isfinite(points).all(axis=1)]


@pytest.mark.parametrize("name", solid_names())
@pytest.mark.parametrize("distance", [None, 3.0])
def test_without_noise_every_point_lies_on_the_surface(name, distance):
    one = solid(name)
    for image in scan(one, Scanner(views=3, pixels=40, noise=0.0, distance=distance)):
        points = placed(image)
        assert len(points) > 50
        assert np.abs(one.field(points)).max() < 1e-9 * one.extent


@pytest.mark.parametrize("distance", [None, 2.0, 5.0])
def test_pixels_see_the_first_surface_and_that_from_outside(distance):
    one = solid("double_torus")
    for image in scan(one, Scanner(views=4, pixels=48, noise=0.0, distance=distance)):
        points = placed(image)
        middle = one.box.mean(axis=0)
        radius = np.linalg.norm(one.box[1] - middle)
        backward = image.pose.rotation[:, 2]
        eye = middle + (distance or 0.0) * radius * backward
        ray = backward if distance is None else eye - points
        ray = np.broadcast_to(ray / np.linalg.norm(ray, axis=-1, keepdims=True), points.shape)
        for way in np.geomspace(0.01, radius, 40):
            assert np.all(one.field(points + way * ray) > -1e-9)
        assert np.all(np.sum(normals(one, points) * ray, axis=1) > -1e-6)


def test_rows_and_columns_turn_as_range_images_do():
    one = solid("ball")
    for image in scan(one, Scanner(views=5, pixels=30, noise=0.0)):
        mesh = triangulate(image)
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        assert np.all(np.sum(np.cross(b - a, c - a) * a, axis=1) > 0.0)


def test_views_from_all_sides_see_all_of_a_ball():
    points = np.vstack([placed(image) for image in scan(solid("ball"), Scanner(views=12, pixels=60))])
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    nearest = np.linalg.norm(points[:, None] / 50.0 - directions, axis=2).min(axis=0)
    assert nearest.max() < 0.1


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 1.0))
def test_noise_runs_along_the_rays_with_its_standard_deviation(seed, noise):
    one = solid("ball")
    clean, noisy = (scan(one, Scanner(views=2, pixels=50, noise=sigma, seed=seed)) for sigma in (0.0, noise))
    for a, b in zip(clean, noisy, strict=True):
        np.testing.assert_array_equal(np.isnan(a.points), np.isnan(b.points))
        step = (b.points - a.points)[np.isfinite(a.points[:, :, 0])]
        np.testing.assert_array_equal(step[:, :2], 0.0)
        assert np.std(step[:, 2]) == pytest.approx(noise, rel=0.2)


def test_a_pose_error_misplaces_views_by_about_as_much():
    one = solid("ellipsoid")
    error = 0.2
    images = scan(one, Scanner(views=12, pixels=40, noise=0.0, pose_error=error))
    typical = [np.sqrt(np.mean(distances(one, placed(image)) ** 2)) for image in images]
    assert 0.3 * error < np.mean(typical) < 2.0 * error
    assert all(
        np.abs(image.pose.rotation @ image.pose.rotation.T - np.eye(3)).max() < 1e-12 for image in images
    )


def test_the_same_seed_gives_the_same_scans_and_another_one_others():
    one = solid("fork")
    first, again, other = (scan(one, Scanner(views=2, pixels=30, seed=seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first[1].points, again[1].points)
    np.testing.assert_array_equal(first[1].pose.rotation, again[1].pose.rotation)
    assert np.abs(first[1].pose.rotation - other[1].pose.rotation).max() > 1e-3


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"views": 0}, "views"),
        ({"pixels": 1}, "pixels"),
        ({"noise": -1.0}, "noise"),
        ({"noise": float("nan")}, "noise"),
        ({"pose_error": -0.1}, "pose_error"),
        ({"distance": 1.0}, "distance"),
    ],
)
def test_a_scanner_that_cannot_be_is_refused(wrong, name):
    with pytest.raises(InvalidParameter) as caught:
        scan(solid("ball"), Scanner(**wrong))
    assert caught.value.loc == (name,)
