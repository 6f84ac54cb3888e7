import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import InvalidInput, InvalidParameter
from core.surface.axis import axis_frame
from core.surface.parameters import SliceParameters
from core.surface.results import Mesh
from core.surface.slicing import slices_of
from core.truth import reference_mesh, solid, solid_names
from surface.meshes import TETRAHEDRON, box, signed_area

AXES = st.sampled_from([(0, 0, 1), (0, 0, -2), (1, 0, 0), (0, 1, 0), (1, 2, 3), (-1, 0.5, 0.1)])


def cut(meshes, **parameters):
    return slices_of(meshes, SliceParameters.model_validate(parameters))


def turned(line):
    """A closed polyline from its smallest vertex on."""
    return np.roll(line, -np.lexsort(line.T)[0], axis=0)


@pytest.mark.parametrize("name", solid_names())
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, -2.0, 0.5)])
def test_closed_meshes_give_closed_polylines_with_the_inside_on_their_left(name, axis):
    mesh = reference_mesh(solid(name), 40)
    frame = axis_frame(axis)
    slices = cut([mesh], levels=25, axis=axis)
    assert len(slices) == 25
    for one in slices:
        assert one.closed
        assert all(one.closed)
        assert sum(signed_area(frame.to_plane(line)) for line in one.polylines) > 0.0


def test_the_slices_of_a_ball_are_circles_of_the_right_size():
    mesh = reference_mesh(solid("ball"), 64)
    for one in cut([mesh], levels=20):
        (line,) = one.polylines
        radius = np.sqrt(50.0**2 - one.height**2)
        assert np.hypot(line[:, 0], line[:, 1]) == pytest.approx(np.full(len(line), radius), rel=0.01)
        assert np.all(np.abs(line[:, 2] - one.height) < 1e-12 * 50)


def test_holes_run_clockwise():
    torus = reference_mesh(solid("torus"), 48)
    (one,) = cut([torus], heights=[0.0], axis=(0, 1, 0))
    frame = axis_frame((0, 1, 0))
    areas = sorted(signed_area(frame.to_plane(line)) for line in one.polylines)
    assert areas == pytest.approx([-np.pi * 19.0**2, np.pi * 49.0**2], rel=0.01)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), AXES)
def test_integer_meshes_with_many_vertices_on_planes_still_give_closed_polylines(seed, axis):
    # cubes of a lattice, whose faces, edges and vertices lie on the planes
    rng = np.random.default_rng(seed)
    corners = rng.integers(0, 4, size=(4, 3))
    meshes = [box(low, low + rng.integers(1, 3, size=3)) for low in corners]
    heights = np.arange(-8.0, 9.0) * (1.0 if np.count_nonzero(axis) == 1 else 0.37)
    for one in cut(meshes, heights=tuple(heights), axis=axis):
        assert all(one.closed)


def test_a_vertex_on_a_plane_counts_as_below():
    cube = box()
    low, middle, high = cut([cube], heights=[0.0, 0.5, 1.0])
    assert low.closed == middle.closed == (True,)
    assert high.polylines == ()
    assert len(high.points) == 0
    assert signed_area(low.polylines[0][:, :2]) == pytest.approx(1.0)
    (apex,) = cut([TETRAHEDRON], heights=[1.0])
    assert apex.polylines == ()


def test_no_vertex_of_a_polyline_is_repeated():
    for one in cut([reference_mesh(solid("ball"), 20)], heights=[-10.0, 0.0, 10.0]):
        for line in one.polylines:
            assert np.all(np.any(line != np.roll(line, 1, axis=0), axis=1))


def test_an_open_mesh_gives_open_polylines_from_border_to_border():
    y, x = np.mgrid[0:6, 0:9].astype(float)
    grid = np.arange(54).reshape(6, 9)
    near = np.stack((grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1]), axis=-1).reshape(-1, 3)
    far = np.stack((grid[1:, 1:], grid[1:, :-1], grid[:-1, 1:]), axis=-1).reshape(-1, 3)
    sheet = Mesh(np.column_stack((x.ravel(), y.ravel(), 0.3 * x.ravel() * y.ravel())), np.vstack((near, far)))
    for one in cut([sheet], heights=[2.0, 2.5], axis=(0, 1, 0)):
        assert one.closed == (False,)
        assert sorted(one.polylines[0][[0, -1], 0]) == pytest.approx([0.0, 8.0])


def test_what_has_lost_faces_is_cut_into_open_polylines_that_cover_the_rest():
    mesh = reference_mesh(solid("torus"), 48)
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    opened = Mesh(mesh.vertices, mesh.faces[centre[:, 0] < 30.0])
    whole, rest = (cut([one], heights=[0.5])[0] for one in (mesh, opened))
    assert not all(rest.closed)
    assert rest.points[:, 0].max() < 32.0
    assert {tuple(row) for row in np.vstack(rest.polylines)} <= {
        tuple(row) for row in np.vstack(whole.polylines)
    }


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_the_order_of_faces_and_vertices_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    mesh = reference_mesh(solid("pair"), 24)
    order, place = rng.permutation(len(mesh.faces)), rng.permutation(len(mesh.vertices))
    vertices = np.empty_like(mesh.vertices)
    vertices[place] = mesh.vertices
    shuffled = Mesh(vertices, np.roll(place[mesh.faces[order]], rng.integers(3), axis=1))
    for one, other in zip(cut([mesh], levels=9), cut([shuffled], levels=9), strict=True):
        assert one.height == other.height
        assert one.closed == other.closed
        lines = [sorted((turned(line) for line in each.polylines), key=len) for each in (one, other)]
        for a, b in zip(*lines, strict=True):
            assert a == pytest.approx(b, abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.floats(1e-3, 1e3), st.integers(0, 2**32 - 1), AXES)
def test_slices_move_and_grow_with_the_meshes(scale, seed, axis):
    mesh = reference_mesh(solid("fork"), 16)
    shift = np.random.default_rng(seed).normal(size=3) * 1000.0
    moved = Mesh(scale * mesh.vertices + shift, mesh.faces)
    base = axis_frame(axis).heights(shift[None])[0]
    for one, other in zip(cut([mesh], axis=axis), cut([moved], axis=axis), strict=True):
        assert other.height == pytest.approx(scale * one.height + base, abs=1e-9 * (scale * 100 + 2000))
        assert one.closed == other.closed


def test_faces_that_are_not_oriented_alike_still_link():
    mesh = reference_mesh(solid("ball"), 16)
    flip = np.random.default_rng(1).random(len(mesh.faces)) < 0.5
    mixed = Mesh(mesh.vertices, np.where(flip[:, None], mesh.faces[:, ::-1], mesh.faces))
    for one, other in zip(cut([mesh], levels=11), cut([mixed], levels=11), strict=True):
        assert one.closed == other.closed == (True,)
        assert len(one.polylines[0]) == len(other.polylines[0])


def test_edges_with_more_than_two_faces_and_faces_without_area_do_no_harm():
    one, other = box(), box((1.0, 1.0, 0.0), (2.0, 2.0, 1.0))  # they share an edge
    vertices, index = np.unique(np.vstack((one.vertices, other.vertices)), axis=0, return_inverse=True)
    faces = index.ravel()[np.vstack((one.faces, other.faces + 8))]
    faces = np.vstack((faces, [[0, 0, 1], [2, 3, 2]]))
    (slice_,) = cut([Mesh(vertices, faces)], heights=[0.5])
    assert all(slice_.closed)
    assert sum(signed_area(line[:, :2]) for line in slice_.polylines) == pytest.approx(2.0)


def test_every_plane_cuts_all_meshes():
    slices = cut([box(), box((3.0, 0.0, 0.5), (4.0, 1.0, 2.0))], heights=[0.25, 0.75, 1.5])
    assert [len(one.polylines) for one in slices] == [1, 2, 1]


def test_samples_are_the_vertices_and_lie_close_enough_on_long_segments():
    (one,) = cut([box((0, 0, 0), (10, 10, 10))], heights=[5.0])
    (line,) = one.polylines
    assert {tuple(row) for row in line} <= {tuple(row) for row in one.points}
    ring = np.vstack((one.points, one.points[:1]))
    steps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
    assert steps.max() <= 0.1 + 1e-12
    assert steps.sum() == pytest.approx(40.0)


def test_levels_halve_the_layers_between_them():
    slices = cut([box((0, 0, 2), (1, 1, 6))], levels=4)
    assert [one.height for one in slices] == pytest.approx([2.5, 3.5, 4.5, 5.5])


def test_a_given_spacing_is_kept_and_centred():
    heights = [one.height for one in cut([box((0, 0, 0), (1, 1, 10))], spacing=3.0)]
    assert heights == pytest.approx([2.0, 5.0, 8.0])
    assert [one.height for one in cut([box()], spacing=50.0)] == pytest.approx([0.5])


def test_given_heights_are_taken_in_ascending_order_each_once():
    assert [one.height for one in cut([box()], heights=[0.75, 0.25, 0.75])] == [0.25, 0.75]


def test_by_default_planes_are_as_far_apart_as_the_samples():
    grid = np.stack(np.meshgrid(np.arange(41.0), np.arange(161.0), indexing="ij"), axis=-1).reshape(-1, 2)
    index = np.arange(41 * 161).reshape(41, 161)
    corners = [index[:-1, :-1], index[1:, :-1], index[:-1, 1:]]
    wall = Mesh(np.insert(grid, 1, 0.0, axis=1), np.stack(corners, axis=-1).reshape(-1, 3))
    assert len(cut([wall])) == 160
    assert len(cut([box()])) == 100


@settings(deadline=None)
@given(st.lists(st.sampled_from(["levels", "spacing", "heights"]), min_size=2, unique=True))
def test_heights_are_given_in_one_way_only(names):
    values = {"levels": 3, "spacing": 1.0, "heights": (1.0,)}
    with pytest.raises(ValueError, match="at most one"):
        SliceParameters(**{name: values[name] for name in names})


def test_a_zero_axis_is_none():
    with pytest.raises(ValueError, match="axis"):
        SliceParameters(axis=(0.0, 0.0, 0.0))


def test_a_spacing_far_too_small_is_refused():
    with pytest.raises(InvalidParameter, match="planes") as caught:
        cut([box()], spacing=1e-9)
    assert caught.value.loc == ("parameters", "spacing")


def test_more_crossings_than_memory_has_room_for_are_refused():
    faces = np.tile(box().faces, (2000, 1))
    with pytest.raises(InvalidParameter, match="fewer planes") as caught:
        cut([Mesh(box().vertices, faces)], levels=10_000)
    assert caught.value.loc == ("parameters", "levels")


@pytest.mark.parametrize(
    ("mesh", "loc"),
    [
        (Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), ("meshes",)),
        (
            Mesh(np.array([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]]), np.array([[0, 1, 2]])),
            ("meshes", 0, "vertices", 1),
        ),
        (Mesh(np.eye(3), np.array([[0, 1, 2], [0, 1, 3]])), ("meshes", 0, "faces", 1)),
        (Mesh(np.eye(3), np.array([[0, -1, 2]])), ("meshes", 0, "faces", 0)),
    ],
)
def test_what_cannot_be_cut_is_refused_with_its_place(mesh, loc):
    with pytest.raises(InvalidInput) as caught:
        cut([mesh])
    assert caught.value.loc == loc


def test_a_flat_mesh_is_cut_nowhere_but_on_request():
    flat = Mesh(np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]], float), np.array([[0, 1, 2]]))
    for one in cut([flat]):
        assert one.polylines == ()
