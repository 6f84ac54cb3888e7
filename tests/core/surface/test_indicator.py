import numpy as np
import pytest

from core.surface.axis import axis_frame
from core.surface.density import samples_of
from core.surface.indicator import Indicator, indicator_of
from core.surface.range_image import triangulate
from core.surface.results import Mesh
from core.truth import Scanner, reference_mesh, scan, solid
from surface.meshes import TETRAHEDRON, box, signed_area

FRAME = axis_frame((0.0, 0.0, 1.0))
RADIUS = 50.0  # of the built-in ball
CELLS = 48


@pytest.fixture(scope="module")
def ball():
    return [triangulate(one) for one in scan(solid("ball"), Scanner(views=8, pixels=64, noise=0.05))]


@pytest.fixture(scope="module")
def torus():
    return [triangulate(one) for one in scan(solid("torus"), Scanner(views=8, pixels=80))]


def without(meshes, removed):
    """Meshes without the faces whose centroids a condition holds for."""
    return [Mesh(one.vertices, one.faces[~removed(one.vertices[one.faces].mean(axis=1))]) for one in meshes]


def moved(meshes, scale, shift):
    return [Mesh(scale * one.vertices + np.asarray(shift), one.faces) for one in meshes]


def reversed_faces(mesh):
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


def heights(indicator: Indicator, count=40):
    """Heights across the whole grid."""
    return indicator.origin[2] + indicator.pitch * np.linspace(-1.0, len(indicator.values), count)


def enclosed(indicator: Indicator, height):
    return sum(signed_area(loop) for loop in indicator.loops(height))


def test_the_contours_of_a_scanned_ball_are_its_circles_to_a_fraction_of_a_cell(ball):
    indicator = indicator_of(ball, FRAME, CELLS)
    for height in np.linspace(-0.9, 0.9, 19) * RADIUS:
        (loop,) = indicator.loops(height)
        distance = np.hypot(np.linalg.norm(loop, axis=1), height) - RADIUS
        assert np.abs(distance).max() < 0.2 * indicator.pitch
        assert np.abs(distance).mean() < 0.06 * indicator.pitch
    assert indicator.loops(1.1 * RADIUS) == indicator.loops(-1.1 * RADIUS) == []


def test_more_cells_are_as_exact_in_cells(ball):
    coarse, fine = (indicator_of(ball, FRAME, cells) for cells in (32, 96))
    assert fine.pitch == pytest.approx(coarse.pitch / 3.0)
    errors = [
        np.abs(np.linalg.norm(one.loops(0.0)[0], axis=1) - RADIUS).max() / one.pitch for one in (coarse, fine)
    ]
    assert max(errors) < 0.2


def test_loops_are_closed_without_repeating_a_vertex(torus):
    indicator = indicator_of(torus, FRAME, CELLS)
    for height in heights(indicator):
        for loop in indicator.loops(height):
            step = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1)
            assert step.max() <= 1.5 * indicator.pitch
            assert np.any(loop[0] != loop[-1])


def test_a_torus_upright_has_two_contours_side_by_side_and_one_at_both_ends(torus):
    indicator = indicator_of(torus, FRAME, CELLS)
    counts = [len(indicator.loops(height)) for height in (-44.0, -30.0, -10.0, 0.0, 10.0, 30.0, 44.0)]
    assert counts == [1, 1, 2, 2, 2, 1, 1]


def test_the_inside_is_on_the_left_of_nested_contours(torus):
    indicator = indicator_of(torus, axis_frame((0.0, 1.0, 0.0)), CELLS)
    inner, outer = sorted(signed_area(loop) for loop in indicator.loops(0.0))
    assert outer == pytest.approx(np.pi * 49.0**2, rel=0.01)
    assert inner == pytest.approx(-np.pi * 19.0**2, rel=0.02)


def test_contours_lie_in_the_plane_of_any_axis(torus):
    frame = axis_frame((1.0, -2.0, 3.0))
    indicator = indicator_of(torus, frame, CELLS)
    places = [frame.lift(loop, height) for height in (-20.0, 0.0, 15.0) for loop in indicator.loops(height)]
    distance = solid("torus").field(np.concatenate(places))
    assert np.abs(distance).max() < 0.3 * indicator.pitch


def test_where_scans_overlap_more_the_surface_is_in_the_same_place(ball):
    upper = without(ball, lambda centre: centre[:, 0] < 0.0)
    indicator = indicator_of([*ball, *upper, *upper, *upper], FRAME, CELLS)
    (loop,) = indicator.loops(0.0)
    assert np.abs(np.linalg.norm(loop, axis=1) - RADIUS).max() < 0.3 * indicator.pitch


def test_contours_are_closed_across_a_hole(ball):
    cut = 0.7 * RADIUS
    indicator = indicator_of(without(ball, lambda centre: centre[:, 0] > cut), FRAME, CELLS)
    for height in np.linspace(-0.6, 0.6, 7) * RADIUS:
        (loop,) = indicator.loops(height)
        seen = loop[:, 0] < cut - 5.0 * indicator.pitch
        distance = np.hypot(np.linalg.norm(loop, axis=1), height) - RADIUS
        assert np.abs(distance[seen]).max() < 0.3 * indicator.pitch
        assert distance.max() < indicator.pitch  # what closes it does not swell
        assert loop[:, 0].max() > cut - 6.0 * indicator.pitch  # nor cave in


def test_a_hole_at_the_end_is_closed_beyond_what_was_seen_or_before(ball):
    cut = 0.8 * RADIUS
    indicator = indicator_of(without(ball, lambda centre: centre[:, 2] > cut), FRAME, CELLS)
    top = max(height for height in heights(indicator, 200) if indicator.loops(height))
    assert cut - 4.0 * indicator.pitch < top < RADIUS + indicator.pitch


def test_one_view_of_a_ball_gives_closed_contours_within_the_grid(ball):
    indicator = indicator_of(ball[:1], FRAME, CELLS)
    upper = indicator.origin[:2] + indicator.pitch * np.array(indicator.values.shape[:0:-1])
    found = [loop for height in heights(indicator) for loop in indicator.loops(height)]
    assert found
    for loop in found:
        assert np.all((loop > indicator.origin[:2]) & (loop < upper))


def test_nothing_on_the_border_is_inside(ball, torus):
    for meshes in (ball, torus, ball[:1], ball[3:5], torus[2:4]):
        indicator = indicator_of(meshes, FRAME, CELLS)
        for axis in range(3):
            for end in (0, -1):
                assert np.take(indicator.values, end, axis=axis).max() <= indicator.level


def test_two_bodies_of_different_size_are_both_found(ball):
    small = moved(ball, 0.12, (RADIUS + 10.0, 0.0, 20.0))
    indicator = indicator_of([*ball, *small], FRAME, 96)
    areas = sorted(signed_area(loop) for loop in indicator.loops(20.0))
    assert areas == pytest.approx([np.pi * 6.0**2, np.pi * (RADIUS**2 - 20.0**2)], rel=0.05)
    assert len(indicator.loops(-20.0)) == 1


def test_a_box_of_twelve_triangles_is_sampled_as_densely_as_the_grid():
    indicator = indicator_of([box((0, 0, 0), (1, 2, 3))], FRAME, CELLS)
    for height in np.linspace(0.2, 2.8, 9):
        assert len(indicator.loops(height)) == 1
        assert enclosed(indicator, height) == pytest.approx(2.0, rel=0.01)
    assert not indicator.loops(-1.5 * indicator.pitch)
    assert not indicator.loops(3.0 + 1.5 * indicator.pitch)


def test_the_grid_is_only_as_long_as_needed():
    indicator = indicator_of([box((0, 0, 0), (1, 2, 8))], FRAME, 64)
    assert indicator.pitch == pytest.approx(8.0 / 64)
    assert np.all(np.array(indicator.values.shape) <= np.array([64, 16, 8]) + 6)


@pytest.mark.parametrize(
    ("scale", "shift"),
    [(1.0, (1e6, -3e6, 2e6)), (0.37, (0.0, 0.0, 0.0)), (1e-200, (0.0, 0.0, 0.0)), (1e300, (0.0, 0.0, 0.0))],
)
def test_moved_and_scaled_meshes_have_moved_and_scaled_contours(torus, scale, shift):
    one, other = indicator_of(torus, FRAME, CELLS), indicator_of(moved(torus, scale, shift), FRAME, CELLS)
    assert other.pitch == pytest.approx(scale * one.pitch, rel=1e-6)
    for height in (-40.0, 0.0, 25.0):
        loops = one.loops(height)
        images = other.loops(scale * height + shift[2])
        assert len(images) == len(loops)
        for loop, image in zip(loops, images, strict=True):
            back = (image - shift[:2]) / scale
            assert signed_area(back) == pytest.approx(signed_area(loop), rel=1e-3)
            assert back.mean(axis=0) == pytest.approx(loop.mean(axis=0), abs=0.05 * one.pitch)


def test_the_order_of_meshes_and_faces_does_not_matter(torus):
    rng = np.random.default_rng(5)
    one = indicator_of(torus, FRAME, CELLS)
    mixed = [Mesh(mesh.vertices, rng.permutation(mesh.faces)) for mesh in torus[::-1]]
    other = indicator_of(mixed, FRAME, CELLS)
    assert one.values.shape == other.values.shape
    assert np.abs((one.values - one.level) - (other.values - other.level)).max() < 1e-4
    assert one.origin == pytest.approx(other.origin)


def test_vertices_that_no_face_has_do_not_matter(torus):
    one = indicator_of(torus, FRAME, CELLS)
    stray = [Mesh(np.vstack((mesh.vertices, [[1e5, 1e5, -1e5]])), mesh.faces) for mesh in torus]
    other = indicator_of([*stray, Mesh(np.full((3, 3), 1e7), np.zeros((0, 3), np.int64))], FRAME, CELLS)
    assert np.array_equal(one.values, other.values)
    assert np.array_equal(one.origin, other.origin)


@pytest.mark.parametrize(
    "meshes",
    [
        [],
        [Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))],
        [Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))],
        [Mesh(np.arange(9.0).reshape(3, 3), np.array([[0, 1, 2]]))],  # in line: no area
        [Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))],
        [box((0, 0, 0), (100, 100, 0.5))],  # thinner than a cell
        [TETRAHEDRON, reversed_faces(TETRAHEDRON)],
    ],
    ids=["none", "empty", "a point", "a line", "a triangle", "thin", "both ways"],
)
def test_where_there_is_nothing_to_tell_there_is_no_indicator(meshes):
    assert indicator_of(meshes, FRAME, CELLS) is None


def test_parts_of_triangles_are_small_and_have_the_area_and_the_centroid_of_the_whole():
    rng = np.random.default_rng(2)
    corners = rng.uniform(0.0, 20.0, (3, 3))
    places, areas = samples_of(corners, np.array([[0, 1, 2]]), 1.0)
    whole = 0.5 * np.cross(corners[1] - corners[0], corners[2] - corners[0])
    assert areas.sum(axis=0) == pytest.approx(whole, rel=1e-4)
    assert np.linalg.norm(areas, axis=1).max() <= np.sqrt(3.0) / 4.0 + 1e-6  # the largest with such edges
    sizes = np.linalg.norm(areas, axis=1)
    assert (places * sizes[:, None]).sum(axis=0) / sizes.sum() == pytest.approx(
        corners.mean(axis=0), rel=1e-4
    )


def test_small_triangles_are_samples_as_they_are():
    places, areas = samples_of(TETRAHEDRON.vertices, TETRAHEDRON.faces, 2.0)
    assert places == pytest.approx(TETRAHEDRON.vertices[TETRAHEDRON.faces].mean(axis=1))
    assert areas.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-6)


def test_many_large_triangles_do_not_take_memory_without_bound():
    rng = np.random.default_rng(3)
    count = 1500
    corners = rng.uniform(0.0, 120.0, (3 * count, 3))
    faces = np.arange(3 * count).reshape(-1, 3)
    places, areas = samples_of(corners, faces, 1.0)
    assert len(places) <= 1_000_000 + 2 * count
    a, b, c = (corners[faces[:, k]] for k in range(3))
    whole = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0
    assert np.linalg.norm(areas, axis=1).sum(dtype=np.float64) == pytest.approx(whole, rel=1e-3)


def test_the_surface_passes_over_a_place_at_the_height_of_the_ball():
    indicator = indicator_of([reference_mesh(solid("ball"), 64)], FRAME)
    places = np.array([[0.0, 0.0], [20.0, 10.0], [-15.0, 25.0], [90.0, 0.0]])
    low, high = np.full(4, 10.0), np.full(4, 60.0)
    found = indicator.crossings(places, low, high)
    true = np.sqrt(RADIUS**2 - np.sum(places[:3] ** 2, axis=1))
    assert np.abs(found[:3] - true).max() < 0.2 * indicator.pitch
    assert np.isnan(found[3])
    below = indicator.crossings(places, -low, -high)
    assert np.abs(below[:3] + true).max() < 0.2 * indicator.pitch
    assert np.isnan(indicator.crossings(places, high, low)).all()  # from outside in
    assert np.isnan(indicator.crossings(places, -high, high)).all()  # there it passes twice


def test_what_is_turned_inside_out_shows_the_same():
    one = indicator_of([reference_mesh(solid("fork"), 32)], FRAME, CELLS)
    other = indicator_of([reversed_faces(reference_mesh(solid("fork"), 32))], FRAME, CELLS)
    for height in heights(one, 12):
        pairs = zip(one.loops(height), other.loops(height), strict=True)
        assert all(np.allclose(loop, same, atol=1e-4 * one.pitch) for loop, same in pairs)
