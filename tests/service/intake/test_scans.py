"""Scans in every form of body: what they become, and what is said of those that are wrong."""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any

import httpx
import numpy as np
import orjson
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.surface.parameters import SurfaceParameters
from core.surface.results import Pose, RangeImage, Scans
from intake.reading import JSON, LIMITS, dumped, places
from service.intake import IntakeError, Limits, Submission, decode
from service.render.range_grids import write_conf, write_range_ply

OBJ = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
STL = (
    b"solid a\nfacet normal 0 0 1\nouter loop\n"
    b"vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\nendsolid\n"
)
MESH = {"vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0.5]], "faces": [[0, 1, 2]]}
SEEN = np.array([[[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [np.nan] * 3]])
IMAGE = RangeImage(SEEN)
REAL = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**53), 2**53)
NOT_A_NUMBER = st.sampled_from([True, False, "1", "", None, [1.0], {}, {"x": 1}])


def read(body: bytes, content_type: str = JSON, **options: Any) -> Submission:
    return decode(
        body,
        content_type,
        None,
        options.get("query", {}),
        SurfaceParameters,
        frozenset({"slices"}),
        options.get("limits", LIMITS),
        options.get("envelope"),
        "scans",
    )


def outcome(body: bytes) -> Submission | IntakeError:
    try:
        return read(body)
    except IntakeError as error:
        return error


def scans(body: bytes, content_type: str = JSON, **options: Any) -> Scans:
    data = read(body, content_type, **options).data
    assert isinstance(data, Scans)
    return data


def refusal(body: bytes, content_type: str = JSON, **options: Any) -> IntakeError:
    with pytest.raises(IntakeError) as caught:
        read(body, content_type, **options)
    return caught.value


def form(*files: tuple[str, bytes], **data: str) -> tuple[bytes, str]:
    """Encode a form as a client does."""
    parts = [("file", (name, content)) for name, content in files]
    request = httpx.Request("POST", "http://localhost/", files=parts, data=data)
    return request.read(), request.headers["content-type"]


# ---------------------------------------------------------------- JSON


def grids() -> st.SearchStrategy[list[list[Any]]]:
    pixel = st.none() | st.just([None] * 3) | st.lists(REAL, min_size=3, max_size=3)
    return st.integers(1, 5).flatmap(
        lambda width: st.lists(st.lists(pixel, min_size=width, max_size=width), min_size=1, max_size=6)
    )


@given(grids())
def test_a_grid_becomes_the_same_array_with_nan_in_holes(grid: list[list[Any]]) -> None:
    (image,) = scans(dumped(range_images=[{"points": grid}])).range_images
    expected = [[[np.nan] * 3 if pixel is None or None in pixel else pixel for pixel in row] for row in grid]
    assert image.pose is None
    assert np.array_equal(image.points, np.array(expected, float), equal_nan=True)
    assert image.points.flags.c_contiguous


@given(grids(), st.data(), NOT_A_NUMBER)
def test_anything_but_a_number_in_a_grid_is_found_where_it_is(
    grid: list[list[Any]], data: st.DataObject, wrong: Any
) -> None:
    row, column = data.draw(st.integers(0, len(grid) - 1)), data.draw(st.integers(0, len(grid[0]) - 1))
    k = data.draw(st.integers(0, 2))
    grid[row][column] = [1.0, 0.0, 2.0]
    grid[row][column][k] = wrong
    error = refusal(dumped(range_images=[{"points": [[[0, 0, 0]]]}, {"points": grid}]))
    at = ["body", "range_images", 1, "points", row, column]
    assert (error.status, error.kind) == (422, "invalid-points")
    assert places(error) == [at if wrong is None else [*at, k]]


@pytest.mark.parametrize(
    ("grid", "at"),
    [
        ([], []),
        ([[]], [0]),
        ([[[1, 2, 3]], [[1, 2, 3], None]], [1]),
        ([[[1, 2, 3]], None], [1]),
        ([[[1, 2, 3], 5]], [0, 1]),
        ([[[1, 2]]], [0, 0]),
        ("grid", []),
        ({"0": []}, []),
    ],
)
def test_a_grid_has_rows_of_one_length(grid: object, at: list[int]) -> None:
    error = refusal(dumped(range_images=[{"points": grid}]))
    assert places(error) == [["body", "range_images", 0, "points", *at]]


def test_a_mesh_becomes_arrays() -> None:
    (mesh,) = scans(dumped(meshes=[MESH])).meshes
    assert mesh.vertices.tolist() == MESH["vertices"]
    assert mesh.faces.tolist() == MESH["faces"]
    assert mesh.faces.dtype == np.int64


@pytest.mark.parametrize("wrong", [3, -1, 2**70, 1.0, True, "1", None, 1e300])
def test_an_index_that_is_none_is_found_where_it_is(wrong: object) -> None:
    error = refusal(dumped_any(meshes=[MESH, MESH | {"faces": [[0, 1, 2], [2, wrong, 0]]}]))
    assert (error.status, error.kind) == (422, "invalid-points")
    assert places(error) == [["body", "meshes", 1, "faces", 1, 1]]


def dumped_any(**document: object) -> bytes:
    """Write JSON with integers of any size."""
    return json.dumps(document).encode()


def test_slices_have_points_of_the_plane_or_of_space_or_none() -> None:
    rows = [[1, 2], [3, 4]]
    given = [
        {"height": 1, "points": rows},
        {"height": 2.5, "points": []},
        {"height": 3, "points": [[1, 2, 3]]},
    ]
    found = scans(dumped(slices=given)).slices
    assert [one.height for one in found] == [1.0, 2.5, 3.0]
    assert [one.points.shape for one in found] == [(2, 2), (0, 2), (1, 3)]


def test_contours_are_rows_or_objects() -> None:
    rows = [[0, 0], [3, 0], [3, 4]]
    given = [
        {"height": 0, "curves": [rows, {"vertices": rows, "closed": False}, [*rows, rows[0]]]},
        {"height": 1, "curves": []},
    ]
    one, other = scans(dumped(contours=given)).contours
    assert [curve.closed for curve in one.curves] == [True, False, True]
    assert [curve.length for curve in one.curves] == [12.0, 7.0, 12.0]
    assert [curve.vertices.tolist() for curve in one.curves] == [rows] * 3  # none repeats its first vertex
    assert [curve.component for curve in one.curves] == [0, 1, 2]
    assert other.curves == ()


@pytest.mark.parametrize(
    ("curve", "at"),
    [
        ([[0, 0], [1, True]], [1, 1]),
        ([[0, 0], [1, 1, 1]], [1]),
        ([], []),
        ({"vertices": [[0, 0], [1, "a"]]}, ["vertices", 1, 1]),
        ({"vertices": [[0, 0]], "closed": 1}, ["closed"]),
        ({"vertices": [[0, 0]], "open": False}, ["open"]),
        ({}, ["vertices"]),
        (None, []),
        ("curve", []),
    ],
)
def test_a_curve_that_is_wrong_is_found_where_it_is(curve: object, at: list[Any]) -> None:
    sound = [[0, 0], [1, 0], [1, 1]]
    error = refusal(dumped(contours=[{"height": 0, "curves": [sound, curve]}]))
    assert (error.status, error.kind) == (422, "invalid-points")
    assert places(error) == [["body", "contours", 0, "curves", 1, *at]]


@pytest.mark.parametrize("height", [None, "1", True, [1], 10**400])
def test_a_height_is_a_number(height: object) -> None:
    for name, rest in (("slices", {"points": []}), ("contours", {"curves": []})):
        error = refusal(dumped_any(**{name: [{"height": 0, **rest}, {"height": height, **rest}]}))
        assert places(error) == [["body", name, 1, "height"]]


def test_a_pose_is_a_matrix_or_a_quaternion() -> None:
    turn = Rotation.from_rotvec([0.3, -0.2, 1.0])
    poses = [
        {"rotation": turn.as_matrix().tolist(), "translation": [1, 2, 3]},
        {"quaternion": (5.0 * turn.as_quat()).tolist(), "translation": [1, 2, 3]},
        {"translation": [1, 2, 3]},
        {"rotation": None, "quaternion": None},
        None,
    ]
    given = [{"points": [[[0, 0, 0]]], "pose": pose} for pose in poses]
    matrix, quaternion, shift, nothing, none = (
        one.pose for one in scans(dumped(range_images=given)).range_images
    )
    assert np.allclose(matrix.rotation, turn.as_matrix())
    assert np.allclose(quaternion.rotation, turn.as_matrix())
    assert np.array_equal(shift.rotation, np.eye(3))
    assert shift.translation.tolist() == [1.0, 2.0, 3.0]
    assert nothing.translation.tolist() == [0.0, 0.0, 0.0]
    assert none is None


@pytest.mark.parametrize(
    ("pose", "at"),
    [
        ({"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, ["rotation"]),  # a mirror
        ({"rotation": [[2, 0, 0], [0, 1, 0], [0, 0, 0.5]]}, ["rotation"]),
        ({"rotation": [[1e200, 0, 0], [0, 1, 0], [0, 0, 1]]}, ["rotation"]),
        ({"rotation": [[1, 0, 0], [0, 1, 0]]}, ["rotation"]),
        ({"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, True]]}, ["rotation", 2, 2]),
        ({"quaternion": [0, 0, 0, 0]}, ["quaternion"]),
        ({"quaternion": [0, 0, 1]}, ["quaternion"]),
        ({"translation": [0, 0]}, ["translation"]),
        ({"quaternion": [0, 0, 0, 1], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, []),
        ({"scale": 2}, ["scale"]),
        ([], []),
    ],
)
def test_a_pose_that_is_no_motion_is_refused(pose: object, at: list[Any]) -> None:
    error = refusal(dumped(range_images=[{"points": [[[0, 0, 0]]], "pose": pose}]))
    assert places(error) == [["body", "range_images", 0, "pose", *at]]


def test_parameters_come_in_the_body_or_in_the_query() -> None:
    body = dumped(meshes=[MESH], parameters={"axis": [0, 1, 0], "heights": [1, 2.5]}, include=["slices"])
    given = read(body)
    assert given.parameters == SurfaceParameters(axis=(0, 1, 0), heights=(1, 2.5))
    assert given.include == {"slices"}
    queried = read(OBJ, "model/obj", query={"axis": "0,1,0", "heights": "[1, 2.5]", "include": "slices"})
    assert (queried.parameters, queried.include) == (given.parameters, given.include)


@pytest.mark.parametrize("axis", ["0,0", "0,0,0,1", "a,b,c", "nan,0,0", "0;0;1", "0,0,1e999"])
def test_an_axis_in_the_query_that_is_none_is_refused_there(axis: str) -> None:
    error = refusal(OBJ, "model/obj", query={"axis": axis})
    assert (error.status, error.kind) == (422, "invalid-parameter")
    assert {tuple(place) for place in places(error)} == {("query", "axis")}


@pytest.mark.parametrize(
    "document",
    [
        {"points": [[1, 2]]},
        {"meshes": {}},
        {"meshes": None},
        {"meshes": [None]},
        {"meshes": [[]]},
        {"slices": [3]},
        {"range_images": ["a"]},
        {"contours": [{"height": 1}]},
        {"meshes": [MESH | {str(k): k for k in range(1000)}]},
        {"slices": [{"height": k, "points": []} for k in range(20_000)]},
    ],
)
def test_other_documents_are_refused(document: dict[str, Any]) -> None:
    error = refusal(dumped(**document), limits=Limits(100_000, 10_000_000))
    assert error.status == 422
    assert len(error.errors) <= 20


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(
                ["vertices", "faces", "points", "pose", "height", "curves", "closed", "quaternion"]
            ),
            inner,
            max_size=4,
        )
    ),
    max_leaves=20,
)


@settings(deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(["meshes", "range_images", "slices", "contours"]), json_values | st.lists(json_values)
    )
)
def test_any_document_is_read_or_refused(document: dict[str, Any]) -> None:
    found = outcome(dumped_any(**document))
    if isinstance(found, IntakeError):
        assert found.status == 422
        assert all(item["loc"][0] == "body" for item in found.errors)
    else:
        assert isinstance(found.data, Scans)


# ---------------------------------------------------------------- limits


@pytest.mark.parametrize(
    "document",
    [
        {"meshes": [MESH] * 4},
        {"meshes": [MESH | {"faces": [[0, 1, 2]] * 30}]},
        {"range_images": [{"points": [[[0, 0, 0]] * 4] * 3}]},
        {"slices": [{"height": 0, "points": [[0, 0]] * 6}, {"height": 1, "points": [[0, 0]] * 6}]},
        {"contours": [{"height": 0, "curves": [[[0, 0]] * 6, {"vertices": [[0, 0]] * 6}]}]},
        {"contours": [{"height": 0, "curves": [[[0, 0]]] * 6}]},
        {"slices": [{"height": k, "points": []} for k in range(12)]},
    ],
)
def test_all_points_together_are_counted(document: dict[str, Any]) -> None:
    assert refusal(dumped(**document), limits=Limits(11, 10**6)).kind == "too-many-points"
    assert read(dumped(**document), limits=Limits(40, 10**6)).points is None


def test_holes_of_range_images_count_a_quarter() -> None:
    rows = [[None] * 10, [[0, 0, 0], [1, 0, 0], [0, 1, 0], *[None] * 7], [None] * 10]
    document = {"range_images": [{"points": rows}]}
    assert refusal(dumped(**document), limits=Limits(6, 10**6)).kind == "too-many-points"
    assert read(dumped(**document), limits=Limits(7, 10**6)).points is None


def test_files_are_counted_together() -> None:
    body, media_type = form(("a.ply", write_range_ply(IMAGE)), ("b.obj", OBJ))
    assert refusal(body, media_type, limits=Limits(6, 10**6)).kind == "too-many-points"
    assert scans(body, media_type, limits=Limits(7, 10**6)).meshes
    zipped, media_type = form(*[(f"{k}.obj.gz", gzip.compress(OBJ)) for k in range(5)])
    assert refusal(zipped, media_type, limits=Limits(100, 4 * len(OBJ))).kind == "too-many-bytes"


# ---------------------------------------------------------------- files


@pytest.mark.parametrize(("content", "media_type"), [(OBJ, "model/obj"), (STL, "model/stl")])
def test_a_mesh_may_be_the_whole_body(content: bytes, media_type: str) -> None:
    (mesh,) = scans(content, media_type).meshes
    assert len(mesh.faces) in {1, 2}


def test_a_range_grid_may_be_the_whole_body() -> None:
    (image,) = scans(write_range_ply(IMAGE), "application/x-ply").range_images
    assert np.array_equal(image.points, SEEN, equal_nan=True)


def test_poses_find_their_scans() -> None:
    turn = Rotation.from_rotvec([0.1, 0.7, -1.2]).as_matrix()
    poses = {"b.ply": Pose(turn, np.array([1.0, -2.0, 0.5])), "a.ply": Pose(np.eye(3), np.zeros(3))}
    others = {"c.ply": Pose(np.eye(3), np.ones(3))}
    body, media_type = form(
        ("b.ply.gz", gzip.compress(write_range_ply(IMAGE))),
        ("poses.conf", write_conf(poses | others)),
        ("scans/a.ply", write_range_ply(IMAGE)),
        ("plain.obj", OBJ),
        parameters='{"levels": 3}',
    )
    given = read(body, media_type)
    assert isinstance(given.data, Scans)
    b, a = given.data.range_images
    assert np.allclose(b.pose.rotation, turn)
    assert b.pose.translation.tolist() == [1.0, -2.0, 0.5]
    assert np.allclose(a.pose.rotation, np.eye(3))
    assert given.parameters == SurfaceParameters(levels=3)
    assert len(given.data.meshes) == 1


def test_a_mesh_that_a_pose_names_is_moved() -> None:
    turn = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix()
    conf = write_conf({"a.obj": Pose(turn, np.array([5.0, 0.0, 0.0]))})
    (mesh,) = scans(*form(("a.obj", OBJ), ("a.conf", conf))).meshes
    assert sorted(map(tuple, mesh.vertices.round(12).tolist())) == [
        (4, 0, 0),
        (4, 1, 0),
        (5, 0, 0),
        (5, 1, 0),
    ]


def test_a_json_file_is_a_json_body() -> None:
    (mesh,) = scans(*form(("a.json", dumped(meshes=[MESH])))).meshes
    assert mesh.faces.tolist() == MESH["faces"]
    error = refusal(*form(("a.json", dumped(meshes=[MESH])), ("b.obj", OBJ)))
    assert (error.status, places(error)) == (422, [["body", "file", 0]])


@pytest.mark.parametrize(
    ("files", "status", "at"),
    [
        ([("a.ply", write_range_ply(IMAGE)), ("b.conf", b"bmesh c.ply 0 0 0 0 0 0 1")], 422, [0]),
        ([("a.obj", OBJ), ("b.ply", b"ply\n")], 400, [1]),
        ([("a.obj", OBJ), ("b.ply", write_range_ply(IMAGE)[:-3])], 400, [1]),
        ([("a.obj", OBJ), ("b.conf", b"bmesh a.obj 0 0\n")], 422, [1, 0]),
        ([("a.obj", OBJ), ("b.conf", b"camera 0\nbmesh a.obj 0 0 0 0 0 0 0\n")], 422, [1, 1]),
        ([("a.csv", b"1,2\n")], 415, [0]),
        ([("a.obj", OBJ), ("cloud", b"")], 415, [1]),
        ([("a.stl.gz", STL)], 400, [0]),
    ],
)
def test_a_file_that_cannot_be_read_is_named(
    files: list[tuple[str, bytes]], status: int, at: list[int]
) -> None:
    error = refusal(*form(*files))
    assert error.status == status
    assert places(error) == [["body", "file", *at]]


def test_other_media_types_are_told_what_is_read() -> None:
    error = refusal(b"1,2\n", "text/csv")
    assert error.status == 415
    assert all(name in error.detail for name in ("model/stl", "application/x-ply", "multipart/form-data"))


def test_inputs_may_be_files_in_an_envelope() -> None:
    value = {"value": base64.b64encode(STL).decode(), "mediaType": "model/stl", "encoding": "base64"}
    body = orjson.dumps({"inputs": {"meshes": value, "parameters": {"levels": 4}}})
    found = read(body, envelope="inputs")
    assert isinstance(found.data, Scans)
    assert len(found.data.meshes[0].faces) == 1
    wrong = refusal(orjson.dumps({"inputs": {"meshes": [MESH | {"faces": [[0, 1, 5]]}]}}), envelope="inputs")
    assert places(wrong) == [["body", "inputs", "meshes", 0, "faces", 0, 2]]
