from __future__ import annotations

import subprocess
import sys
import zipfile
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from io import BytesIO

import numpy as np
import orjson
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from core import divisions
from core.division import Division
from core.methods import diagnose, partition, pca, reconstruct, skeleton
from core.parameters import PartitionParameters, PcaParameters, ReconstructParameters, SkeletonParameters
from core.results import Curve, Graph, GraphNode, Warn
from core.surface.results import ContourLevel, Mesh, Pose, RangeImage, Slice, Surface, SurfaceReport
from core.truth import point_set
from service.processes import PROCESSES, process
from service.store.frozen import FrozenError, freeze, thaw

NUMBERS = (
    hnp.boolean_dtypes()
    | hnp.integer_dtypes()
    | hnp.unsigned_integer_dtypes()
    | hnp.floating_dtypes()
    | hnp.complex_number_dtypes()
)
ARRAYS = NUMBERS.flatmap(
    lambda dtype: hnp.arrays(dtype, hnp.array_shapes(min_dims=0, max_dims=4, min_side=0))
)
TEXTS = st.text(st.characters(exclude_categories=["Cs"]))
PLAIN = st.none() | st.booleans() | st.integers() | st.floats() | TEXTS | st.binary() | ARRAYS
SCALARS = NUMBERS.flatmap(lambda dtype: hnp.arrays(dtype, ())).map(lambda array: array[()])
KEYS = TEXTS | st.integers() | st.tuples(st.integers(), TEXTS)
VALUES = st.recursive(
    PLAIN | SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(KEYS, inner, max_size=4)
    ),
    max_leaves=12,
)


def assert_same(one: object, other: object) -> None:
    """Equal in every type and to the last bit."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        assert one.shape == other.shape
        assert one.tobytes() == other.tobytes()
    elif isinstance(one, np.generic):
        assert one.tobytes() == other.tobytes()
    elif isinstance(one, float):
        assert np.float64(one).tobytes() == np.float64(other).tobytes() or np.isnan([one, other]).all()
    elif is_dataclass(one):
        for each in fields(one):
            assert_same(getattr(one, each.name), getattr(other, each.name))
    elif isinstance(one, tuple | list):
        assert len(one) == len(other)
        for mine, its in zip(one, other, strict=True):
            assert_same(mine, its)
    elif isinstance(one, dict):
        assert_same(list(one), list(other))
        assert_same(list(one.values()), list(other.values()))
    elif isinstance(one, shapely.Geometry):
        assert shapely.to_wkb(one) == shapely.to_wkb(other)
    else:
        assert one == other


@cache
def tilted_eight() -> np.ndarray:
    points = point_set("figure_8", n=900, sigma=0.01).points
    return np.column_stack([points, points @ [0.5, 0.25]])


@given(VALUES)
@settings(max_examples=60, deadline=None)
def test_plain_values_come_back_to_the_last_bit(value: object) -> None:
    assert_same(thaw(freeze(value)), value)
    assert_same(thaw(memoryview(freeze(value))), value)


@given(ARRAYS, st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_arrays_keep_their_order_in_memory_and_can_be_written_to(array: np.ndarray, random: object) -> None:
    axes = random.sample(range(array.ndim), array.ndim)
    turned = array.transpose(axes)
    back = thaw(freeze(turned))
    assert_same(back, turned)
    assert back.flags.writeable
    if turned.size > 1:
        wide = [axis for axis in range(turned.ndim) if turned.shape[axis] > 1]
        assert (
            np.argsort([-back.strides[axis] for axis in wide], kind="stable").tolist()
            == np.argsort([-turned.strides[axis] for axis in wide], kind="stable").tolist()
        )


def test_sums_over_turned_arrays_do_not_change() -> None:
    points = np.asfortranarray(np.random.default_rng(0).normal(size=(1000, 3)))
    back = thaw(freeze(points))
    assert back.flags.f_contiguous
    assert back.mean().tobytes() == points.mean().tobytes()


def test_parts_of_arrays_are_kept_without_the_rest() -> None:
    whole = np.arange(1_000_000.0)
    part = whole[400:10:-3]
    assert len(freeze(part)) < 5000
    assert_same(thaw(freeze(part)), part.copy())


def test_an_array_that_occurs_often_is_kept_once() -> None:
    array = np.random.default_rng(0).normal(size=1000)
    assert len(freeze((array,) * 50)) < 2 * len(freeze(array))


@pytest.mark.parametrize(
    "result",
    [
        lambda: partition(tilted_eight(), PartitionParameters(min_component_size=5)),
        lambda: pca(tilted_eight(), stages=True),
        lambda: skeleton(tilted_eight(), stages=True),
        lambda: reconstruct(tilted_eight()),
        lambda: diagnose(tilted_eight()),
    ],
    ids=["partition", "pca", "skeleton", "reconstruct", "diagnose"],
)
def test_results_come_back_to_the_last_bit(result: object) -> None:
    value = result()
    assert_same(thaw(freeze(value)), value)


@pytest.mark.parametrize(
    ("division", "parameters"),
    [(divisions.SKELETON, SkeletonParameters()), (divisions.DIAGNOSE, process("diagnose").parameters())],
    ids=["skeleton", "diagnose"],
)
def test_parts_and_what_solving_them_gives_come_back_to_the_last_bit(
    division: Division, parameters: SkeletonParameters
) -> None:
    ring = point_set("circle", n=120, sigma=0.01).points
    points = np.concatenate([ring + 6.0 * np.array([k % 4, k // 4]) for k in range(10)])
    parts = division.split(points, parameters)
    assert_same(thaw(freeze(parts)), parts)
    here = [division.solve(part, None) for part in parts]
    there = [thaw(freeze(division.solve(thaw(freeze(part)), None))) for part in parts]
    assert_same(there, here)
    assert_same(division.join(points, parameters, there), division.join(points, parameters, here))


def test_surfaces_come_back_to_the_last_bit() -> None:
    rng = np.random.default_rng(0)
    curve = Curve(rng.normal(size=(9, 3)), True, 0, 1.0, 7, float("nan"), None)
    level = ContourLevel(0.5, (curve, curve), warnings=(Warn("gap", "Too wide.", (0.0, float("inf"), 1.0)),))
    report = SurfaceReport(True, True, 1, 2, 0, 1.0, 2.0, 0, (0.25, 0.5), None)
    scan = RangeImage(np.where(rng.random((5, 4, 1)) < 0.3, np.nan, 1.0) * rng.normal(size=(5, 4, 3)))
    posed = RangeImage(scan.points, Pose(np.eye(3), np.zeros(3)))
    piece = Slice(
        0.5, rng.normal(size=(3, 3)), (rng.normal(size=(2, 3)), rng.normal(size=(0, 3))), (True, False)
    )
    surface = Surface(Mesh(rng.normal(size=(6, 3)), rng.integers(0, 6, (8, 3))), report, (level,))
    value = (surface, scan, posed, piece)
    assert_same(thaw(freeze(value)), value)


@pytest.mark.parametrize("kind", [row.parameters for row in PROCESSES], ids=[row.id for row in PROCESSES])
def test_parameters_come_back_equal(kind: type) -> None:
    assert_same(thaw(freeze((kind(), 1))), (kind(), 1))


def test_given_parameters_come_back_equal() -> None:
    for value in (
        PcaParameters(radius=1e-300, step=2, max_uses=3, planar=False, seed=2**32 - 1),
        SkeletonParameters(crossings="waist", f_a=0.1 + 0.2, prune=0.0),
        ReconstructParameters(method="pca", epsilon=1.5),
    ):
        assert_same(thaw(freeze(value)), value)


def test_geometries_come_back_ring_by_ring() -> None:
    holed = shapely.Polygon(shapely.box(0, 0, 4, 4).exterior, [[(1, 1), (1, 2), (2, 2 + 1e-16)]])
    value = (shapely.MultiPolygon([holed, shapely.box(5, 5, 6, 6)]), shapely.Point(0.1, 0.2, 0.3))
    assert_same(thaw(freeze(value)), value)


def test_a_hundred_thousand_nodes_share_one_member() -> None:
    places = np.random.default_rng(0).normal(size=(100_000, 2))
    graph = Graph(tuple(GraphNode(place, 0.5, 3, 0) for place in places), ())
    content = freeze(graph)
    with zipfile.ZipFile(BytesIO(content)) as archive:
        assert archive.namelist() == ["value.json", "0.npy"]
        assert np.array_equal(np.load(BytesIO(archive.read("0.npy"))), places.ravel())
    back = thaw(content)
    assert np.array_equal([node.location for node in back.nodes], places)


def test_the_same_value_gives_the_same_bytes() -> None:
    assert freeze(pca(tilted_eight())) == freeze(pca(tilted_eight()))


# ---------------------------------------------------------------- what is refused


@dataclass(frozen=True)
class Stranger:
    value: int


@pytest.mark.parametrize(
    "value",
    [
        object(),
        {1, 2},
        Stranger(1),
        PROCESSES[0],
        np.array([None, 1]),
        np.ma.masked_array([1.0], [True]),
        len,
        Warn,
        1j,
    ],
    ids=repr,
)
def test_what_has_no_place_in_results_is_refused(value: object) -> None:
    with pytest.raises(TypeError):
        freeze((1, [value]))


def file_of(value: object, *classes: object, **members: bytes) -> bytes:
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("value.json", orjson.dumps({"value": value, "version": 1, "classes": classes}))
        for name, content in members.items():
            archive.writestr(name.replace("_", "") + ".npy", content)
    return file.getvalue()


@pytest.mark.parametrize(
    "name",
    [
        "os:system",
        "subprocess:Popen",
        "builtins:eval",
        "core.results:dataclass",
        "core.results:ComponentSampling",  # lives in another module
        "core.methods:pca",
        "core.parameters:_Nothing",
        "core.nowhere:Curve",
        "core.results:Curve.__init__",
        "core_:Curve",
        "service.processes:Process",
        "service.store.frozen:FrozenError",
        "core.results",
        "",
    ],
)
def test_nothing_but_dataclasses_of_the_core_and_parameters_may_be_named(name: str) -> None:
    with pytest.raises(FrozenError):
        thaw(file_of({"$": [0]}, (name, ())))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no zip",
        file_of({"?": 1}),
        file_of({"$": [0, 1]}, ("core.results:Warn", ("nonsense",))),
        file_of({"$": [0, "code"]}, ("core.results:Warn", ("code",))),
        file_of({"&": [0, {"epsilon": -1.0}]}, ("core.parameters:PcaParameters", ())),
        file_of({"#": [0, 0, None, 3]}),
        file_of({"#": [0, 0, None, 3]}, _0=b"\x93NUMPY nonsense"),
        file_of({"n": "one"}),
        file_of({}),
        file_of(1).replace(b'"version":1', b'"version":9'),
    ],
)
def test_damaged_files_are_told_as_such(content: bytes) -> None:
    with pytest.raises(FrozenError):
        thaw(content)


def test_arrays_of_objects_are_never_unpickled() -> None:
    file = BytesIO()
    np.lib.format.write_array(file, np.array([Stranger(1)], object), allow_pickle=True)
    with pytest.raises(FrozenError):
        thaw(file_of({"#": [0, 0, None, 1]}, _0=file.getvalue()))


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_a_file_that_was_cut_short_is_told_as_such(data: st.DataObject) -> None:
    content = freeze((np.arange(5.0), "text", Warn("code", "message", (1.0, 2.0))))
    with pytest.raises(FrozenError):
        thaw(content[: data.draw(st.integers(0, len(content) - 1))])


def test_neither_shapely_nor_numba_is_imported_before_it_is_needed() -> None:
    code = "import sys, service.store.frozen; print({'shapely', 'numba', 'scipy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert run.stdout == "set()\n"
