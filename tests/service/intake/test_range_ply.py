from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.surface.results import RangeImage
from service.intake import IntakeError
from service.intake.range_ply import decode_conf, decode_range_ply, is_range_ply

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def written(grid: np.ndarray, order: str = "ascii", end: str = "\n", extra: bool = False) -> bytes:
    """A range grid as a PLY file; ``extra`` adds a property before x and one behind z."""
    rows, columns = grid.shape[:2]
    seen = np.isfinite(grid[:, :, 0]).ravel()
    vertices = grid.reshape(-1, 3)[seen]
    names = ["confidence", "x", "y", "z", "intensity"] if extra else ["x", "y", "z"]
    header = [
        "ply",
        f"format {order} 1.0",
        "comment made by a test",
        "obj_info is_mesh 0",
        f"obj_info num_cols {columns}",
        f"obj_info num_rows {rows}",
        f"element vertex {len(vertices)}",
        *(f"property {'double' if name in 'xyz' else 'uchar'} {name}" for name in names),
        f"element range_grid {rows * columns}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    head = end.join(header) + end
    mark = ORDERS[order]
    number = np.cumsum(seen) - 1
    if order == "ascii":
        pad = ("7 ", " 9") if extra else ("", "")
        lines = [pad[0] + " ".join(map(repr, row)) + pad[1] for row in vertices.tolist()]
        lines += [f"1 {number[k]}" if seen[k] else "0" for k in range(len(seen))]
        return (head + end.join(lines) + end).encode()
    kinds = [(name, mark + "f8" if name in "xyz" else "u1") for name in names]
    table = np.zeros(len(vertices), kinds)
    for k, name in enumerate("xyz"):
        table[name] = vertices[:, k]
    lists = [
        b"\1" + np.array(number[k], mark + "i4").tobytes() if seen[k] else b"\0" for k in range(len(seen))
    ]
    return head.encode() + table.tobytes() + b"".join(lists)


def some_grid(seed: int, rows: int = 5, columns: int = 7, share: float = 0.4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    grid = rng.normal(size=(rows, columns, 3))
    grid[rng.random((rows, columns)) < share] = np.nan
    return grid


def refusal(body: bytes, max_points: int | None = None) -> IntakeError:
    with pytest.raises(IntakeError) as caught:
        decode_range_ply(body, None, max_points)
    return caught.value


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 12),
    st.integers(1, 12),
    st.floats(0.0, 1.0),
    st.sampled_from(sorted(ORDERS)),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
)
def test_every_form_of_range_grid_is_read(
    seed: int, rows: int, columns: int, share: float, order: str, end: str, extra: bool
) -> None:
    grid = some_grid(seed, rows, columns, share)
    body = written(grid, order, end, extra)
    assert is_range_ply(body)
    image = decode_range_ply(body)
    assert isinstance(image, RangeImage)
    assert image.pose is None
    np.testing.assert_array_equal(image.points, grid)


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_a_file_cut_off_anywhere_is_unreadable(order: str) -> None:
    whole = written(some_grid(3), order)
    tail = 1 if order == "ascii" else 0  # the end of the last line says nothing
    for length in range(0, len(whole) - tail, 3):
        assert refusal(whole[:length].rstrip() if order == "ascii" else whole[:length]).status in {400, 422}
    assert refusal(whole[: len(whole) - 4]).status in {400, 422}


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_what_follows_the_grid_is_not_ignored(order: str) -> None:
    assert refusal(written(some_grid(3), order) + (b"0\n" if order == "ascii" else b"\0")).status == 400


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"ply\n", b"plot\n"),
        (b"format ascii", b"format utf8"),
        (b"format ascii 1.0\n", b""),
        (b"num_cols 7", b"num_cols 8"),
        (b"num_cols 7", b"num_cols -7"),
        (b"num_cols 7", b"num_cols seven"),
        (b"obj_info num_rows 5\n", b""),
        (b"element range_grid 35", b"element range_grid 34"),
        (b"element range_grid 35", b"element range_grid 99999999999999"),
        (b"element range_grid 35", b"element range_grid 9999999999999999999999"),
        (b"element range_grid", b"element face"),
        (b"property double x", b"property double u"),
        (b"property double x", b"property double y"),
        (b"property double x", b"property quad x"),
        (b"property double x", b"property list uchar double x"),
        (b"list uchar int", b"list uchar float"),
        (b"property list uchar int vertex_indices", b"property int vertex_indices"),
        (b"end_header", b"end"),
        (b"0\n", b"zero\n"),
        (b"0\n", b"0.5\n"),
        (b"0\n", b"-1\n"),
        (b"0\n", b"2 0 0\n"),
    ],
)
def test_what_is_no_range_grid_is_unreadable(old: bytes, new: bytes) -> None:
    body = written(some_grid(3))
    changed = (
        body[:-1][::-1].replace(old[::-1], new[::-1], 1)[::-1] if old == b"0\n" else body.replace(old, new, 1)
    )
    assert changed not in (body, body[:-1])
    assert refusal(changed).status == 400


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_points_must_be_finite_and_pixels_must_name_points(order: str) -> None:
    grid = some_grid(5)
    grid[0, 0] = [0.0, np.inf, 0.0]
    assert (refusal(written(grid, order)).status, refusal(written(grid, order)).kind) == (
        422,
        "invalid-points",
    )


def test_a_pixel_that_names_no_point_is_refused() -> None:
    body = written(np.zeros((1, 1, 3)))
    for wrong in (b"1 1\n", b"1 -1\n"):
        assert refusal(body.replace(b"1 0\n", wrong)).status == 422


def test_too_many_points_are_refused() -> None:
    grid = some_grid(1)
    seen = int(np.isfinite(grid[:, :, 0]).sum())
    assert refusal(written(grid), seen - 1).status == 413
    assert decode_range_ply(written(grid), None, seen).points.shape == (5, 7, 3)


def test_four_holes_count_as_a_point() -> None:
    grid = np.full((8, 10, 3), np.nan)
    grid[2:4, 2:4] = np.random.default_rng(0).normal(size=(2, 2, 3))
    assert refusal(written(grid), 19).status == 413
    assert decode_range_ply(written(grid), None, 20).points.shape == (8, 10, 3)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(sorted(ORDERS)))
def test_bytes_changed_by_chance_are_read_or_refused(seed: int, order: str) -> None:
    rng = np.random.default_rng(seed)
    body = bytearray(written(some_grid(seed % 7), order))
    for place in rng.integers(0, len(body), size=3):
        body[place] = rng.integers(0, 256)
    image = read_or_refused(bytes(body))
    assert image is None or image.points.shape[2] == 3


def read_or_refused(body: bytes) -> RangeImage | None:
    """The image, or None when it was refused with one of the statuses for it."""
    try:
        return decode_range_ply(body)
    except IntakeError as error:
        if error.status not in {400, 422}:
            raise
        return None


def test_a_mesh_is_no_range_grid() -> None:
    assert not is_range_ply(b"ply\nformat ascii 1.0\nelement vertex 0\nelement face 0\nend_header\n")
    assert not is_range_ply(b"solid ply range_grid")


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_conf_file_gives_the_motion_back_of_its_quaternion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, shift, scale = Rotation.random(rng=rng), rng.normal(size=3), float(rng.uniform(0.1, 10))
    line = " ".join(map(repr, [*shift.tolist(), *(scale * turn.as_quat()).tolist()]))
    text = f"camera 0 0 0 0 0 0 1\n\nbmesh a.ply 0 0 0 0 0 0 1\r\nbmesh b.ply {line}\n"
    poses = decode_conf(text.encode())
    assert list(poses) == ["a.ply", "b.ply"]
    np.testing.assert_array_equal(poses["a.ply"].rotation, np.eye(3))
    assert poses["b.ply"].rotation == pytest.approx(turn.as_matrix().T, abs=1e-12)
    assert poses["b.ply"].translation == pytest.approx(shift)


@pytest.mark.parametrize(
    "text",
    [
        "bmesh",
        "bmesh a.ply",
        "bmesh a.ply 0 0 0 0 0 0",
        "bmesh a.ply 0 0 0 0 0 0 1 2",
        "bmesh a.ply 0 0 0 0 0 0 0",
        "bmesh a.ply 0 0 zero 0 0 0 1",
        "bmesh a.ply 0 0 nan 0 0 0 1",
        "bmesh a.ply 0 0 0 inf 0 0 1",
        "mesh? a.ply 0 0 0 0 0 0 1",
    ],
)
def test_a_pose_that_cannot_be_read_is_refused_with_its_line(text: str) -> None:
    with pytest.raises(IntakeError) as caught:
        decode_conf(b"# poses\n" + text.encode())
    assert caught.value.status == 422
    assert caught.value.errors[0]["loc"] == ["body", "conf", 1]


def test_a_conf_file_is_text_of_some_length() -> None:
    for body, status in ((b"\xff\xfe\x00", 400), (b"#" * 1_000_001, 413)):
        with pytest.raises(IntakeError) as caught:
            decode_conf(body)
        assert caught.value.status == status
