"""The real processes, through HTTP."""

from __future__ import annotations

import gzip
import io
from typing import Any

import httpx
import numpy as np
import pytest
from expect import is_problem

from core.errors import DegenerateInput
from core.methods import pca
from core.parameters import PcaParameters
from service.processes import PROCESSES, Process, process
from service.render import FORMS


@pytest.fixture(scope="module")
def cloud(client: httpx.Client) -> np.ndarray:
    drawn = client.get("/examples/spiral?n=800&format=npy")
    points: np.ndarray = np.load(io.BytesIO(drawn.content))
    return points


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


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
@pytest.mark.parametrize("name", ["circle", "spiral", "helix"])
def test_answers_are_as_documented(client: httpx.Client, row: Process, name: str) -> None:
    points = client.get(f"/examples/{name}?n=600").json()["points"]
    response = client.post(row.path, json={"points": points, "include": sorted(row.include)})
    assert response.status_code == 200, response.text
    row.answer.model_validate(response.json())


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_every_form_that_is_offered_is_given(client: httpx.Client, row: Process, cloud: np.ndarray) -> None:
    for form in row.forms:
        by_query = client.post(f"{row.path}?format={form}", json={"points": cloud.tolist()})
        by_header = client.post(row.path, json={"points": cloud.tolist()}, headers={"Accept": FORMS[form]})
        assert by_query.status_code == by_header.status_code == 200
        assert by_query.headers["content-type"].split(";")[0] == FORMS[form]
        assert by_query.content == by_header.content


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_the_documented_example_works(client: httpx.Client, row: Process) -> None:
    examples = client.get("/openapi.json").json()["components"]["examples"]
    for example in examples.values():
        assert client.post(row.path, json=example["value"]).status_code == 200


def test_the_answer_does_not_depend_on_the_form_of_the_body(client: httpx.Client, cloud: np.ndarray) -> None:
    def answer(content: bytes, media_type: str, **headers: str) -> Any:
        sent = {"Content-Type": media_type, **headers}
        response = client.post("/reconstruct/pca?refine=false", content=content, headers=sent)
        assert response.status_code == 200, response.text
        return response.json()

    expected = answer(npy(cloud), "application/x-npy")
    assert len(expected["curves"]) == 1
    assert answer(text(cloud, ","), "text/csv") == expected
    assert answer(text(cloud, " "), "text/plain") == expected
    assert answer(gzip.compress(npy(cloud)), "application/x-npy", **{"Content-Encoding": "gzip"}) == expected
    as_json = client.post(
        "/reconstruct/pca", json={"points": cloud.tolist(), "parameters": {"refine": False}}
    )
    as_form = client.post(
        "/reconstruct/pca",
        files={"file": ("cloud.npy", npy(cloud))},
        data={"parameters": '{"refine": false}'},
    )
    assert as_json.json() == as_form.json() == expected


def test_the_service_answers_what_the_library_does(client: httpx.Client, cloud: np.ndarray) -> None:
    answer = client.post("/reconstruct/pca", json={"points": cloud.tolist()}).json()
    own = pca(cloud, PcaParameters())
    assert [curve["vertices"] for curve in answer["curves"]] == [c.vertices.tolist() for c in own.curves]
    assert answer["outliers"] == own.outliers.tolist()


def test_stages_come_only_when_asked_for(client: httpx.Client, cloud: np.ndarray) -> None:
    body: dict[str, Any] = {"points": cloud.tolist()}
    assert "stages" not in client.post("/reconstruct/pca", json=body).json()
    asked = client.post("/reconstruct/pca", json=body | {"include": ["stages"]}).json()
    assert asked["stages"]["balls"]


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
    ],
    ids=["one", "two", "same", "collinear", "huge", "tiny", "largest", "far"],
)
@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_extreme_points_have_a_sound_answer_or_are_refused(
    client: httpx.Client, row: Process, points: list[list[float]]
) -> None:
    response = client.post(row.path, json={"points": points})
    if response.status_code == 200:
        row.answer.model_validate(response.json())
    else:
        document = is_problem(response, 422)
        assert document["errors"]


def test_points_that_determine_no_curve_are_told_so(client: httpx.Client) -> None:
    response = client.post("/reconstruct/pca", json={"points": [[1.0, 1.0]] * 20})
    is_problem(response, 422, DegenerateInput.kind)
