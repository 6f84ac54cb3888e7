"""OGC API – Processes 1.0: tests after the abstract test suite of 18-062r2, annex A, and of its limits."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Serve
from expect import is_problem
from jobs.client import ASYNC, POINTS, ended, info
from rows import ALL

from service.answers import (
    Conformance,
    JobList,
    PartitionAnswer,
    ProcessDescription,
    ProcessList,
    ResultDocument,
    StatusInfo,
)
from service.processes import Process
from service.render import FORMS

CLASSES = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/"
RELATIONS = "http://www.opengis.net/def/rel/ogc/1.0/"
EXCEPTIONS = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"
TRIAL = "/processes/trial/execution"
TEXT = "\n".join(f"{x},{y}" for x, y in POINTS)


@pytest.fixture(scope="module")
def jobs(serve: Serve) -> Iterator[httpx.Client]:
    """Ask a server that computes jobs, of the trial process only."""
    with serve(job_workers=1) as (url, _), httpx.Client(base_url=url, timeout=60) as client:
        yield client


def request(points: object = POINTS, **parameters: object) -> dict[str, Any]:
    return {"inputs": {"points": points, "parameters": parameters}}


def execute(client: httpx.Client, body: object, **headers: str) -> httpx.Response:
    return client.post(TRIAL, json=body, headers=headers)


def ellipse(count: int = 80) -> list[list[float]]:
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rows: list[list[float]] = np.column_stack([2 * np.cos(angle), np.sin(angle)]).tolist()
    return rows


def scans() -> dict[str, Any]:
    """Return a range image of an elliptic cylinder, as one that turns would be seen."""
    ring = ellipse(30)
    grid = [[[x, y, float(z)] for x, y in (*ring, ring[0])] for z in range(4)]
    return {"range_images": [{"points": grid}], "parameters": {"levels": 3}}


MEMBERS = {"points": {"points"}, "scans": {"meshes", "range_images", "slices", "contours"}}


# --- /conf/core: landing page, conformance, list and description of processes ------------------------


@pytest.mark.parametrize("relation", ["conformance", "processes", "job-list"])
def test_the_landing_document_leads_to_the_standard(client: httpx.Client, relation: str) -> None:
    links = client.get("/").json()["links"]
    (link,) = [link for link in links if link["rel"] == RELATIONS + relation]
    answer = client.get(link["href"])
    assert answer.status_code == 200
    assert answer.headers["content-type"] == link["type"]


def test_the_api_is_described(client: httpx.Client) -> None:
    assert {"service-desc", "service-doc"} <= {link["rel"] for link in client.get("/").json()["links"]}


def test_the_conformance_classes_are_told(client: httpx.Client) -> None:
    told = Conformance.model_validate(client.get("/conformance").json()).conformsTo
    names = {"core", "ogc-process-description", "json", "job-list", "dismiss"}
    assert sorted(told) == sorted(CLASSES + name for name in names)


def test_all_processes_are_listed(client: httpx.Client) -> None:
    listed = ProcessList.model_validate(client.get("/processes").json())
    assert [one.id for one in listed.processes] == [row.id for row in ALL]
    assert [link.rel for link in listed.links] == ["self"]
    for one in listed.processes:
        (own,) = [link for link in one.links if link.rel == "self"]
        assert client.get(own.href).json()["id"] == one.id


@pytest.mark.parametrize("limit", [1, 2, len(ALL)])
def test_pages_of_the_list_lead_from_one_to_the_next(client: httpx.Client, limit: int) -> None:
    found: list[str] = []
    address: str | None = f"/processes?limit={limit}"
    while address:
        page = ProcessList.model_validate(client.get(address).json())
        assert len(page.processes) <= limit
        found += [one.id for one in page.processes]
        address = next((link.href for link in page.links if link.rel == "next"), None)
    assert found == [row.id for row in ALL]


@pytest.mark.parametrize("query", ["limit=0", "limit=x", "limit=1001", "offset=-1", "f=html"])
def test_a_page_out_of_range_is_refused(client: httpx.Client, query: str) -> None:
    is_problem(client.get(f"/processes?{query}"), 422, "invalid-parameter")


@pytest.mark.parametrize("row", ALL, ids=lambda row: row.id)
def test_a_description_says_what_the_table_does(client: httpx.Client, row: Process) -> None:
    answer = client.get(f"/processes/{row.id}")
    assert answer.headers["content-type"] == "application/json"
    told = ProcessDescription.model_validate(answer.json())
    assert (told.id, told.title, told.description) == (row.id, row.title, row.description)
    assert told.jobControlOptions == ["sync-execute", "async-execute", "dismiss"]
    assert told.outputTransmission == ["value"]
    members = MEMBERS[row.takes]
    assert told.inputs.keys() == members | {"parameters"} | ({"include"} if row.include else set())
    needed = {name for name, one in told.inputs.items() if one.minOccurs}
    assert needed == (members if row.takes == "points" else set())
    assert told.inputs["parameters"].schema_["properties"].keys() == row.parameters.model_fields.keys()
    (form,) = [told.outputs["result"].schema_]
    assert [one["contentMediaType"] for one in form["oneOf"]] == [FORMS[name] for name in row.forms]
    (link,) = [link for link in told.links if link.rel == RELATIONS + "execute"]
    assert client.options(link.href).headers["allow"] == "OPTIONS, POST"


@pytest.mark.parametrize(("method", "path"), [("GET", "/processes/no"), ("POST", "/processes/no/execution")])
def test_an_unknown_process_is_a_problem_of_the_standard(
    client: httpx.Client, method: str, path: str
) -> None:
    is_problem(client.request(method, path, json={}), 404, EXCEPTIONS + "no-such-process")


# --- /conf/core: execution at once ------------------------------------------------------------------


@pytest.mark.parametrize("row", [row for row in ALL if row.id != "trial"], ids=lambda row: row.id)
def test_a_raw_answer_is_that_of_the_process_itself(client: httpx.Client, row: Process) -> None:
    inputs = {"points": ellipse()} if row.takes == "points" else scans()
    for form in ("json", row.forms[-1]):
        directly = client.post(row.path, json=inputs, params={"format": form})
        answer = client.post(
            f"/processes/{row.id}/execution", json={"inputs": inputs}, headers={"Accept": FORMS[form]}
        )
        assert answer.status_code == directly.status_code == 200
        assert answer.headers["content-type"] == directly.headers["content-type"]
        assert answer.content == directly.content


@pytest.mark.parametrize("said", [{}, {"outputs": {}}, {"outputs": {"result": {}}}, {"response": "raw"}])
def test_the_output_is_answered_whether_asked_for_or_not(client: httpx.Client, said: dict[str, Any]) -> None:
    answer = execute(client, request() | said)
    assert answer.headers["content-type"] == "application/json"
    assert PartitionAnswer.model_validate(answer.json()).labels == [-1, -1, -1]


def in_form(media_type: str, **other: object) -> dict[str, Any]:
    return {
        "outputs": {"result": {"format": {"mediaType": media_type}, "transmissionMode": "value"}},
        **other,
    }


@pytest.mark.parametrize(
    ("asked", "headers", "answered"),
    [
        ("text/csv", {}, "text/csv"),
        ("Text/CSV; charset=utf-8", {"accept": "*/*"}, "text/csv"),
        ("text/csv", {"accept": "application/json"}, "application/json"),
        ("application/json", {"accept": "text/csv, */*;q=0.1"}, "text/csv"),
    ],
)
def test_outputs_name_the_form_where_accept_does_not(
    client: httpx.Client, asked: str, headers: dict[str, str], answered: str
) -> None:
    answer = execute(client, request() | in_form(asked), **headers)
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith(answered)


def test_a_document_holds_the_answer_with_its_media_type(client: httpx.Client) -> None:
    answer = execute(client, request() | {"response": "document"})
    assert answer.headers["content-type"] == "application/json"
    told = ResultDocument.model_validate(answer.json()).result
    assert (told.value, told.mediaType) == (
        client.post("/trial", json={"points": POINTS}).json(),
        FORMS["json"],
    )


@pytest.mark.parametrize("form", ["geojson", "csv", "svg", "png"])
def test_a_document_holds_any_form(client: httpx.Client, form: str) -> None:
    inputs = {"points": ellipse()}
    body = {"inputs": inputs} | in_form(FORMS[form], response="document")
    told = client.post("/processes/partition/execution", json=body).json()["result"]
    ResultDocument.model_validate({"result": told})
    directly = client.post("/partition", json=inputs, params={"format": form})
    assert told.get("encoding") == ("base64" if form == "png" else None)
    if form == "geojson":
        assert told["value"] == directly.json()
    elif form == "png":
        assert base64.b64decode(told["value"]) == directly.content
    else:
        assert told["value"] == directly.text
    assert told["mediaType"] == FORMS[form]


def array() -> bytes:
    file = io.BytesIO()
    np.save(file, np.array(POINTS))
    return file.getvalue()


def data(media_type: str, content: bytes) -> str:
    return f"data:{media_type};base64,{base64.b64encode(content).decode()}"


@pytest.mark.parametrize(
    "points",
    [
        {"value": POINTS},
        {"value": POINTS, "mediaType": "application/json"},
        {"value": TEXT, "mediaType": "text/csv"},
        {"value": base64.b64encode(array()).decode(), "mediaType": "application/x-npy", "encoding": "base64"},
        {"href": "data:application/json,%5B[0,0],[1,0.5],[2,0.25]]"},
        {"href": data("text/csv", TEXT.encode()), "type": "text/csv", "rel": "input"},
        {"href": data("application/x-npy", array())},
    ],
    ids=str,
)
def test_points_come_as_a_value_or_in_a_link(client: httpx.Client, points: object) -> None:
    answer = execute(client, request(points))
    assert answer.status_code == 200, answer.text
    assert answer.content == client.post("/trial", json={"points": POINTS}).content


def test_an_object_comes_as_it_is_or_qualified(client: httpx.Client) -> None:
    parameters = {"outcome": "degenerate"}
    for said in (parameters, {"value": parameters}, {"value": parameters, "mediaType": "application/json"}):
        body = {"inputs": {"points": POINTS, "parameters": said}}
        is_problem(execute(client, body), 422, "degenerate-input")


@pytest.mark.parametrize(
    ("content", "headers"),
    [(TEXT.encode(), {"Content-Type": "text/csv"}), (array(), {"Content-Type": "application/x-npy"})],
)
def test_other_media_types_need_no_envelope(
    client: httpx.Client, content: bytes, headers: dict[str, str]
) -> None:
    answer = client.post(TRIAL, content=content, headers=headers)
    assert PartitionAnswer.model_validate(answer.json()).labels == [-1] * len(POINTS)
    refused = client.post(f"{TRIAL}?outcome=points", content=content, headers=headers)
    assert is_problem(refused, 422)["errors"][0]["loc"] == ["body", "points", 1, 0]


def test_a_form_needs_no_envelope(client: httpx.Client) -> None:
    answer = client.post(TRIAL, files={"file": ("cloud.csv", TEXT)})
    assert PartitionAnswer.model_validate(answer.json()).labels == [-1, -1, -1]


REFUSED: list[tuple[Any, list[str | int]]] = [
    ([], ["body", "inputs"]),
    ({"points": POINTS}, ["body", "inputs"]),
    ({"inputs": []}, ["body", "inputs"]),
    ({"inputs": {}}, ["body", "inputs", "points"]),
    (request([[0, 0], [1, "2"]]), ["body", "inputs", "points", 1, 1]),
    (request(sides=2), ["body", "inputs", "parameters", "sides"]),
    (request(seconds=-1), ["body", "inputs", "parameters", "seconds"]),
    (request() | {"id": "trial"}, ["body", "id"]),
    (request() | {"mode": "async"}, ["body", "mode"]),
    (request() | {"subscriber": {"successUri": "http://127.0.0.1/"}}, ["body", "subscriber"]),
    (request() | {"response": "both"}, ["body", "response"]),
    (request() | {"outputs": {"curves": {}}}, ["body", "outputs", "curves"]),
    (
        request() | {"outputs": {"result": {"transmissionMode": "reference"}}},
        ["body", "outputs", "result", "transmissionMode"],
    ),
    (request() | in_form("image/tiff"), ["body", "outputs", "result", "format", "mediaType"]),
    (request({"href": "http://127.0.0.1:1/cloud.csv"}), ["body", "inputs", "points", "href"]),
    (request({"href": "file:///etc/passwd"}), ["body", "inputs", "points", "href"]),
    (request({"href": 1}), ["body", "inputs", "points", "href"]),
    (request({"href": "data:text/csv;base64,%%%"}), ["body", "inputs", "points", "href"]),
    (request({"value": "?", "encoding": "base64"}), ["body", "inputs", "points", "value"]),
    (request({"value": "0,0", "encoding": "hex"}), ["body", "inputs", "points", "encoding"]),
    (request({"value": 1, "mediaType": "text/csv"}), ["body", "inputs", "points", "value"]),
    (request({"value": POINTS, "mediaType": 1}), ["body", "inputs", "points", "mediaType"]),
    (request({"value": POINTS, "unit": "m"}), ["body", "inputs", "points"]),
]


@pytest.mark.parametrize(("body", "place"), REFUSED, ids=str)
def test_what_is_no_execute_request_is_refused_where_it_is_wrong(
    client: httpx.Client, body: object, place: list[str | int]
) -> None:
    told = is_problem(execute(client, body), 422)
    assert told["errors"][0]["loc"] == place


def test_unknown_media_types_of_inputs_are_refused(client: httpx.Client) -> None:
    for media_type in ("image/png", "multipart/form-data", ""):
        refused = execute(client, request({"href": f"data:{media_type or 'x'},0"}))
        assert is_problem(refused, 415)["errors"][0]["loc"] == ["body", "inputs", "points"]


def test_a_multitude_of_unknown_members_is_not_listed(client: httpx.Client) -> None:
    told = is_problem(execute(client, request() | {f"x{n}": n for n in range(50_000)}), 422, "invalid-input")
    assert len(told["errors"]) == 1


def test_a_document_is_not_forced_on_who_accepts_no_json(client: httpx.Client) -> None:
    told = is_problem(execute(client, request() | {"response": "document"}, accept="text/csv"), 422)
    assert told["errors"][0]["loc"] == ["body", "response"]


def test_errors_of_the_process_are_placed_in_the_envelope(client: httpx.Client) -> None:
    told = is_problem(execute(client, request(outcome="points")), 422, "invalid-points")
    assert told["errors"][0]["loc"] == ["body", "inputs", "points", 1, 0]


def test_what_is_unpacked_from_an_input_counts_against_the_limit(client: httpx.Client) -> None:
    text = "0,0\n" * 20_001
    is_problem(execute(client, request({"value": text, "mediaType": "text/csv"})), 413, "too-many-points")


# --- /conf/core, /conf/job-list, /conf/dismiss: execution as a job ------------------------------------


def test_a_job_is_ordered_and_gives_the_answer(jobs: httpx.Client) -> None:
    answer = execute(jobs, request(), **ASYNC)
    assert answer.status_code == 201
    told = StatusInfo.model_validate_json(answer.content)
    job = answer.headers["location"]
    assert (job, told.processID) == (f"/jobs/{told.jobID}", "trial")
    assert ended(jobs, job)["status"] == "successful"
    results = jobs.get(f"{job}/results")
    assert results.content == jobs.post("/trial", json={"points": POINTS}).content
    assert jobs.get(f"{job}/results?format=csv").headers["content-type"].startswith("text/csv")
    listed = JobList.model_validate(jobs.get("/jobs").json()).jobs
    assert told.jobID in {one.jobID for one in listed}


def test_a_job_answers_in_the_form_that_was_ordered(jobs: httpx.Client) -> None:
    job = execute(jobs, request() | in_form("text/csv"), **ASYNC).headers["location"]
    ended(jobs, job)
    assert jobs.get(f"{job}/results").headers["content-type"].startswith("text/csv")
    results = jobs.get(f"{job}/results", headers={"Accept": "application/json"})
    PartitionAnswer.model_validate(results.json())


def test_a_job_keeps_the_document_that_was_ordered(jobs: httpx.Client) -> None:
    body = request() | in_form("text/csv", response="document")
    job = execute(jobs, body, **ASYNC).headers["location"]
    ended(jobs, job)
    at_once = execute(jobs, body)
    assert at_once.headers["content-type"] == "application/json"
    for headers in ({}, {"Accept": "application/json"}):
        results = jobs.get(f"{job}/results", headers=headers)
        assert results.headers["content-type"] == "application/json"
        assert results.content == at_once.content
    raw = jobs.get(f"{job}/results", headers={"Accept": "text/csv"})
    assert raw.text == at_once.json()["result"]["value"]


def test_a_job_that_is_no_execute_request_fails_with_the_same_problem(jobs: httpx.Client) -> None:
    for body, place in (REFUSED[3], REFUSED[13]):
        job = execute(jobs, body, **ASYNC).headers["location"]
        assert ended(jobs, job)["status"] == "failed"
        assert is_problem(jobs.get(f"{job}/results"), 422)["errors"][0]["loc"] == place


def test_an_early_look_for_results_is_a_problem_of_the_standard_and_the_job_can_be_dismissed(
    jobs: httpx.Client,
) -> None:
    job = execute(jobs, request(seconds=600), **ASYNC).headers["location"]
    is_problem(jobs.get(f"{job}/results"), 404, EXCEPTIONS + "result-not-ready")
    dismissed = jobs.delete(job)
    assert dismissed.status_code == 200
    assert StatusInfo.model_validate_json(dismissed.content).status == "dismissed"
    assert info(jobs, job)["status"] == "dismissed"


def listed(jobs: httpx.Client, **query: str | int) -> list[str]:
    answer = jobs.get("/jobs", params=query | {"limit": 1000})
    assert answer.status_code == 200, answer.text
    return [one.jobID for one in JobList.model_validate(answer.json()).jobs]


def test_jobs_are_listed_by_the_parameters_of_the_standard(jobs: httpx.Client) -> None:
    quick = execute(jobs, request(), **ASYNC).json()["jobID"]
    slow = execute(jobs, request(seconds=1.2), **ASYNC).json()["jobID"]
    times = [ended(jobs, f"/jobs/{one}")["created"] for one in (quick, slow)]
    assert {quick, slow} <= set(listed(jobs, processID="trial", type="process", status="successful"))
    assert listed(jobs, processID="none") == listed(jobs, type="other") == []
    assert {quick, slow} & set(listed(jobs, minDuration=1)) == {slow}
    assert {quick, slow} & set(listed(jobs, maxDuration=1)) == {quick}
    assert {quick, slow} & set(listed(jobs, datetime=f"{times[1]}/..")) == {slow}
    assert {quick, slow} & set(listed(jobs, datetime=f"../{times[0]}")) == {quick}
    assert {quick, slow} <= set(listed(jobs, datetime="/".join(times)))


def test_pages_of_sifted_jobs_lead_from_one_to_the_next(jobs: httpx.Client) -> None:
    for seconds in (0, 1.2, 0):
        ended(jobs, execute(jobs, request(seconds=seconds), **ASYNC).headers["location"])
    found: list[str] = []
    address: str | None = "/jobs?maxDuration=1&limit=1"
    while address:
        page = JobList.model_validate(jobs.get(address).json())
        assert len(page.jobs) <= 1
        found += [one.jobID for one in page.jobs]
        address = next((link.href for link in page.links if link.rel == "next"), None)
    assert found == listed(jobs, maxDuration=1)


@pytest.mark.parametrize(
    "query", ["limit=0", "limit=1001", "datetime=noon", "minDuration=-1", "maxDuration=x", "status=done"]
)
def test_a_list_of_jobs_out_of_range_is_refused(jobs: httpx.Client, query: str) -> None:
    told = is_problem(jobs.get(f"/jobs?{query}"), 422, "invalid-parameter")
    assert told["errors"][0]["loc"][:2] == ["query", query.partition("=")[0]]


# --- /conf/json, and the OpenAPI document ---------------------------------------------------------------


@pytest.mark.parametrize("path", ["/", "/conformance", "/processes", "/processes/trial", "/jobs"])
def test_everything_comes_as_json(client: httpx.Client, path: str) -> None:
    answer = client.get(path, headers={"Accept": "application/json"})
    assert (answer.status_code, answer.headers["content-type"]) == (200, "application/json")


@pytest.mark.parametrize("row", ALL, ids=lambda row: row.id)
def test_execution_is_described_with_the_same_inputs(client: httpx.Client, row: Process) -> None:
    described = client.get("/openapi.json").json()
    schemas, paths = described["components"]["schemas"], described["paths"]
    content = paths[f"/processes/{row.id}/execution"]["post"]["requestBody"]["content"]
    plain = paths[row.path]["post"]["requestBody"]["content"]
    body = schemas[content["application/json"]["schema"]["$ref"].rpartition("/")[2]]
    assert body["properties"]["inputs"] == plain["application/json"]["schema"]
    assert body["required"] == ["inputs"]
    assert body["additionalProperties"] is False
    assert content.keys() == plain.keys()
    assert all(content[name] == plain[name] for name in plain if name != "application/json")
