"""The real processes, through HTTP."""

from __future__ import annotations

import gzip
import io
import json
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
import shapely
from expect import is_problem

from core.errors import DegenerateInput
from core.methods import pca, skeleton
from core.results import Reconstruction
from service.answers import SkeletonAnswer
from service.processes import PROCESSES, Process, process
from service.render import FORMS

OF_POINTS = [row for row in PROCESSES if row.takes == "points"]
METHODS = [row for row in OF_POINTS if row.id.startswith("reconstruct")]
each_method = pytest.mark.parametrize("row", METHODS, ids=lambda row: row.id)
SKELETON = "/reconstruct/skeleton"


NPY = "application/x-npy"


@pytest.fixture(scope="module")
def cloud(client: httpx.Client) -> np.ndarray:
    drawn = client.get("/examples/spiral?n=800&format=npy")
    points: np.ndarray = np.load(io.BytesIO(drawn.content))
    return points


@pytest.fixture(scope="module")
def trials(cloud: np.ndarray) -> dict[str, dict[str, Any]]:
    """Bodies by what a process takes."""
    height, around = np.mgrid[-1.0:1.0:7j, 0.0 : 2.0 * np.pi : 31j]
    grid = np.dstack((np.cos(around), np.sin(around), height))
    images = {"range_images": [{"points": grid.tolist()}], "parameters": {"levels": 3}}
    return {"points": {"points": cloud.tolist()}, "scans": images}


def npy(points: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, points)
    return file.getvalue()


def text(points: np.ndarray, separator: str) -> bytes:
    return "\n".join(separator.join(map(repr, row)) for row in points.tolist()).encode()


def test_rows_are_told_apart_by_id_and_path() -> None:
    assert len({row.id for row in PROCESSES}) == len({row.path for row in PROCESSES}) == len(PROCESSES)
    assert all(process(row.id) is row for row in PROCESSES)
    with pytest.raises(KeyError):
        process("nothing")


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_a_row_names_a_function_and_forms_that_exist(row: Process) -> None:
    assert callable(row.resolve())
    assert set(row.forms) <= set(FORMS)


@pytest.mark.parametrize("row", OF_POINTS, ids=lambda row: row.id)
@pytest.mark.parametrize("name", ["circle", "spiral", "helix"])
def test_answers_are_as_documented(client: httpx.Client, row: Process, name: str) -> None:
    points = client.get(f"/examples/{name}?n=600").json()["points"]
    response = client.post(row.path, json={"points": points, "include": sorted(row.include)})
    assert response.status_code == 200, response.text
    row.answer.model_validate(response.json())


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_every_form_that_is_offered_is_given(
    client: httpx.Client, row: Process, trials: dict[str, dict[str, Any]]
) -> None:
    body = trials[row.takes]
    for form in row.forms:
        by_query = client.post(f"{row.path}?format={form}", json=body)
        by_header = client.post(row.path, json=body, headers={"Accept": FORMS[form]})
        assert by_query.status_code == by_header.status_code == 200
        assert by_query.headers["content-type"].split(";")[0] == FORMS[form]
        assert by_query.content == by_header.content


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_the_documented_example_works(client: httpx.Client, row: Process) -> None:
    document = client.get("/openapi.json").json()
    for path in (row.path, f"/processes/{row.id}/execution"):
        body = document["paths"][path]["post"]["requestBody"]["content"]["application/json"]
        (name,) = body["examples"]
        example = document["components"]["examples"][name]
        response = client.post(path, json=example["value"])
        assert response.status_code == 200, response.text
        row.answer.model_validate(response.json())


@each_method
def test_the_answer_does_not_depend_on_the_form_of_the_body(
    client: httpx.Client, cloud: np.ndarray, row: Process
) -> None:
    def answer(content: bytes, media_type: str, **headers: str) -> Any:
        sent = {"Content-Type": media_type, **headers}
        response = client.post(f"{row.path}?refine=false", content=content, headers=sent)
        assert response.status_code == 200, response.text
        return response.json()

    expected = answer(npy(cloud), "application/x-npy")
    assert len(expected["curves"]) == 1
    assert answer(text(cloud, ","), "text/csv") == expected
    assert answer(text(cloud, " "), "text/plain") == expected
    assert answer(gzip.compress(npy(cloud)), "application/x-npy", **{"Content-Encoding": "gzip"}) == expected
    as_json = client.post(row.path, json={"points": cloud.tolist(), "parameters": {"refine": False}})
    as_form = client.post(
        row.path,
        files={"file": ("cloud.npy", npy(cloud))},
        data={"parameters": '{"refine": false}'},
    )
    assert as_json.json() == as_form.json() == expected


@pytest.mark.parametrize("method", [pca, skeleton])
def test_the_service_answers_what_the_library_does(
    client: httpx.Client, cloud: np.ndarray, method: Callable[[np.ndarray], Reconstruction]
) -> None:
    own = method(cloud)
    answer = client.post(f"/reconstruct/{own.method}", json={"points": cloud.tolist()}).json()
    assert answer["method"] == own.method
    assert [curve["vertices"] for curve in answer["curves"]] == [c.vertices.tolist() for c in own.curves]
    assert answer["outliers"] == own.outliers.tolist()


@each_method
def test_stages_come_only_when_asked_for(client: httpx.Client, cloud: np.ndarray, row: Process) -> None:
    body: dict[str, Any] = {"points": cloud.tolist()}
    plain = client.post(row.path, json=body).json()
    asked = client.post(row.path, json=body | {"include": ["stages"]}).json()
    row.answer.model_validate(asked)
    assert asked.pop("stages")["balls"]
    assert asked == plain


@each_method
def test_what_cannot_be_included_is_refused(client: httpx.Client, cloud: np.ndarray, row: Process) -> None:
    response = client.post(row.path, json={"points": cloud.tolist(), "include": ["hair"]})
    document = is_problem(response, 422)
    assert document["errors"][0]["loc"][:2] == ["body", "include"]
    queried = client.post(f"{row.path}?include=hair", content=npy(cloud), headers={"Content-Type": NPY})
    assert is_problem(queried, 422)["errors"][0]["loc"][:2] == ["query", "include"]


@pytest.mark.parametrize(
    "points",
    [
        [[0.0, 0.0]],
        [[0.0, 0.0], [1.0, 1.0]],
        [[3.0, 3.0]] * 50,
        [[float(k), 2.0 * k] for k in range(50)],
        [[k * 1e300, k * 1e300] for k in range(50)],
        [[k * 1e-320, 0.0] for k in range(50)],
        [[(-1) ** k * 1.7e308, (k % 3) * 8e307] for k in range(60)],
        [[1e15 + k % 7, 1e15 + k % 11] for k in range(200)],
        [[float(k // 20), float(k % 20)] for k in range(400)],
        [[float(k % 9), 0.0, 1.0] for k in range(90)],
        [[float(k), 0.0] for k in range(40)] + [[0.0, float(k)] for k in range(40)],
        [[0.0, 0.0]] * 200 + [[float(k), 0.001 * k * k] for k in range(200)],
    ],
    ids=[
        "one",
        "two",
        "same",
        "collinear",
        "huge",
        "tiny",
        "largest",
        "far",
        "grid",
        "line",
        "angle",
        "repeated",
    ],
)
@pytest.mark.parametrize("row", OF_POINTS, ids=lambda row: row.id)
def test_extreme_points_have_a_sound_answer_or_are_refused(
    client: httpx.Client, row: Process, points: list[list[float]]
) -> None:
    response = client.post(row.path, json={"points": points})
    if response.status_code == 200:
        row.answer.model_validate(response.json())
    else:
        document = is_problem(response, 422)
        assert document["errors"]


@each_method
def test_points_that_determine_no_curve_are_told_so(client: httpx.Client, row: Process) -> None:
    response = client.post(row.path, json={"points": [[1.0, 1.0]] * 20})
    is_problem(response, 422, DegenerateInput.kind)


@each_method
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_points_that_are_not_finite_are_refused(
    client: httpx.Client, cloud: np.ndarray, row: Process, value: float
) -> None:
    spoilt = cloud.copy()
    spoilt[17, 1] = value
    response = client.post(row.path, content=npy(spoilt), headers={"Content-Type": NPY})
    document = is_problem(response, 422, "invalid-points")
    assert document["errors"][0]["loc"] == ["body", "points", 17, 1]


def out_of_range(row: Process) -> list[tuple[str, object]]:
    """A wrong value for each parameter of a process, by what its schema says."""
    wrong: list[tuple[str, object]] = [("depth", 1)]
    for name, schema in row.parameters.model_json_schema()["properties"].items():
        kind = next(one for one in schema.get("anyOf", [schema]) if one.get("type") != "null")
        wrong.append((name, "no such thing"))
        wrong += [(name, kind[limit]) for limit in ("exclusiveMinimum",) if limit in kind]
        wrong += [(name, kind["minimum"] - 1)] if "minimum" in kind else []
        wrong += [(name, kind["maximum"] + 1)] if "maximum" in kind else []
    return wrong


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_every_parameter_out_of_range_is_refused_where_it_is(client: httpx.Client, row: Process) -> None:
    body, content, media_type = {
        "points": ({"points": [[0.0, 0.0], [1.0, 0.0]]}, b"0,0\n1,0\n", "text/csv"),
        "scans": ({}, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "model/obj"),
    }[row.takes]
    for name, value in out_of_range(row):
        response = client.post(row.path, json={**body, "parameters": {name: value}})
        document = is_problem(response, 422, "invalid-parameter")
        assert [item["loc"] for item in document["errors"]] == [["body", "parameters", name]]
        queried = client.post(
            row.path, params={name: value}, content=content, headers={"Content-Type": media_type}
        )
        document = is_problem(queried, 422, "invalid-parameter")
        assert [item["loc"] for item in document["errors"]] == [["query", name]]


# --- the tape polygon and its skeleton ----------------------------------------------------------------


def drawn(client: httpx.Client, name: str) -> list[list[float]]:
    points: list[list[float]] = client.get(f"/examples/{name}").json()["points"]
    return points


@pytest.fixture(scope="module")
def eight(client: httpx.Client) -> list[list[float]]:
    return drawn(client, "figure_8")


def test_a_figure_8_is_read_in_every_legal_way(client: httpx.Client, eight: list[list[float]]) -> None:
    counts = {}
    for mode in ("through", "split", "waist", "graph"):
        body = {"points": eight, "parameters": {"crossings": mode}}
        answer = SkeletonAnswer.model_validate(client.post(SKELETON, json=body).json())
        counts[mode] = len(answer.curves), len(answer.crossings)
        assert all(curve.closed for curve in answer.curves) or mode == "graph"
    assert counts == {"through": (1, 1), "split": (2, 0), "waist": (1, 0), "graph": (2, 0)}


def test_the_tape_holds_the_samples_and_the_skeleton(client: httpx.Client, eight: list[list[float]]) -> None:
    answer = client.post(SKELETON, json={"points": eight}).json()
    tape = shapely.from_geojson(json.dumps(answer["tape"]))
    assert tape.is_valid
    assert shapely.get_num_interior_rings(shapely.get_parts(tape)).tolist() == [2]
    assert answer["containment"]["covered"]
    inside = shapely.contains_xy(tape, np.array(eight))
    assert answer["containment"]["samples_inside"] == pytest.approx(inside.mean(), abs=0.002)
    lines = [shapely.LineString(edge["vertices"]) for edge in answer["graph"]["edges"]]
    assert tape.buffer(1e-9).covers(shapely.union_all(lines))


def test_the_graph_hangs_together(client: httpx.Client, eight: list[list[float]]) -> None:
    graph = client.post(SKELETON, json={"points": eight}).json()["graph"]
    ends = [node for edge in graph["edges"] for node in edge["nodes"]]
    assert [ends.count(k) for k in range(len(graph["nodes"]))] == [node["degree"] for node in graph["nodes"]]
    for edge in graph["edges"]:
        places = [graph["nodes"][k]["location"] for k in edge["nodes"]]
        assert np.allclose([edge["vertices"][0], edge["vertices"][-1]], places)
        assert len(edge["widths"]) == len(edge["vertices"])
        assert edge["length"] == pytest.approx(shapely.LineString(edge["vertices"]).length)


def test_the_triangles_are_those_of_the_samples(client: httpx.Client, eight: list[list[float]]) -> None:
    stages = client.post(SKELETON, json={"points": eight, "include": ["stages"]}).json()["stages"]
    delaunay = {name: np.array(values) for name, values in stages["delaunay"].items()}
    corners = np.array(eight)[delaunay["triangles"]]
    hull = shapely.MultiPoint(eight).convex_hull
    assert shapely.area(shapely.polygons(corners)).sum() == pytest.approx(hull.area)
    kept = delaunay["enclosed"] | delaunay["small_area"] | delaunay["short_edges"]
    assert (kept <= delaunay["accepted"]).all()
    assert not delaunay["accepted"].all()


def test_curves_in_tilted_planes_have_tapes_there(client: httpx.Client) -> None:
    body = {"points": drawn(client, "tilted"), "include": ["stages"]}
    answer = client.post(SKELETON, json=body).json()
    SkeletonAnswer.model_validate(answer)
    (frame,) = answer["frames"]
    ring = np.array(answer["tape"]["coordinates"][0][0])
    assert ring.shape[1] == 3
    off = np.abs((ring - frame["origin"]) @ frame["axes"][2])
    assert off.max() < 1e-6 * np.ptp(ring, axis=0).max()
    assert {len(place) for edge in answer["stages"]["voronoi"] for place in edge} == {3}


@pytest.mark.parametrize("form", ["svg", "png", "geojson", "csv"])
@pytest.mark.parametrize("name", ["figure_8", "tilted"])
def test_stages_can_be_had_in_every_form(client: httpx.Client, name: str, form: str) -> None:
    body = {"points": drawn(client, name), "include": ["stages"]}
    response = client.post(f"{SKELETON}?format={form}", json=body)
    assert response.status_code == 200
    plain = client.post(f"{SKELETON}?format={form}", json={"points": body["points"]})
    assert (response.content == plain.content) == (form in {"geojson", "csv"})
