from __future__ import annotations

import gzip
import io
import json
import socket
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest
from expect import is_problem
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core import errors as core_errors
from service import errors as service_errors
from service.intake import IntakeError
from service.problems import TABLE, problem

POINTS = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.25]]
JSON = {"Content-Type": "application/json"}
NPY = {"Content-Type": "application/x-npy"}
CSV = {"Content-Type": "text/csv"}
MARK = "a-word-of-the-client"


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def test_every_error_that_we_raise_has_a_row_of_its_own() -> None:
    names = (set(core_errors.__all__) | set(service_errors.__all__)) - {"TapelineError", "ServiceError"}
    assert names <= {error.__name__ for error in TABLE}


def test_a_problem_type_means_one_thing() -> None:
    meanings: dict[str, set[tuple[int, str]]] = {}
    for status, kind, title in TABLE.values():
        meanings.setdefault(kind, set()).add((status, title))
    intake = IntakeError(422, "invalid-points", "The points are not valid", "")
    assert (intake.status, intake.title) in meanings[intake.kind]
    assert all(len(found) == 1 for found in meanings.values())


def test_a_core_error_keeps_its_own_kind_and_place() -> None:
    told = problem(core_errors.DegenerateInput("two points", ("points", 1), "too-few-points"))
    assert (told.status, told.kind) == (422, "too-few-points")
    assert told.errors == ({"loc": ["body", "points", 1], "msg": "two points", "type": "too_few_points"},)


@pytest.mark.parametrize(
    ("outcome", "status", "kind", "loc"),
    [
        ("degenerate", 422, "degenerate-input", ["body", "points"]),
        ("points", 422, "invalid-points", ["body", "points", 1, 0]),
        ("parameter", 422, "invalid-parameter", ["body", "parameters", "seconds"]),
    ],
)
def test_what_the_core_refuses_says_where(
    client: httpx.Client, outcome: str, status: int, kind: str, loc: list[str | int]
) -> None:
    body = {"points": POINTS, "parameters": {"outcome": outcome}}
    document = is_problem(client.post("/trial", json=body), status, kind)
    assert [item["loc"] for item in document["errors"]] == [loc]


def test_parameters_of_the_query_are_refused_there(client: httpx.Client) -> None:
    response = client.post("/trial?outcome=parameter&seconds=0", content="0 0\n1 1\n", headers=CSV)
    document = is_problem(response, 422, "invalid-parameter")
    assert document["errors"][0]["loc"] == ["query", "seconds"]


def test_a_defect_is_told_without_its_details(client: httpx.Client) -> None:
    response = client.post("/trial", json={"points": POINTS, "parameters": {"outcome": "defect"}})
    is_problem(response, 500, "internal-error")
    assert "secret" not in response.text


def test_too_little_memory_is_told(client: httpx.Client) -> None:
    response = client.post("/trial", json={"points": POINTS, "parameters": {"outcome": "memory"}})
    is_problem(response, 503, "out-of-memory")


@pytest.mark.parametrize("path", ["/nothing", "/trial/", "/examples/", "/%00", "/%ff%fe", "/docs/../etc"])
def test_what_is_not_there_is_404(client: httpx.Client, path: str) -> None:
    is_problem(client.get(path), 404, "not-found")


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("GET", "/trial", "OPTIONS, POST"),
        ("DELETE", "/examples/circle", "GET, HEAD, OPTIONS"),
    ],
)
def test_a_wrong_method_is_405_with_the_right_ones(
    client: httpx.Client, method: str, path: str, allowed: str
) -> None:
    response = client.request(method, path)
    is_problem(response, 405, "method-not-allowed")
    assert response.headers["allow"] == allowed


def test_a_form_that_is_not_offered_is_406(client: httpx.Client) -> None:
    answer = client.post("/trial", json={"points": POINTS}, headers={"Accept": "image/png"})
    is_problem(answer, 406, "not-acceptable")
    is_problem(client.post("/trial?format=png", json={"points": POINTS}), 406, "not-acceptable")
    is_problem(client.post("/trial?format=nix", json={"points": POINTS}), 422)


@pytest.mark.parametrize("media_type", [None, "", "text/html", "nonsense", "application/json/x", "image/png"])
def test_another_media_type_is_415(client: httpx.Client, media_type: str | None) -> None:
    headers = {} if media_type is None else {"Content-Type": media_type}
    is_problem(client.post("/trial", content=b"0 0\n1 1\n", headers=headers), 415, "unsupported-media-type")


def test_another_content_encoding_is_415(client: httpx.Client) -> None:
    headers = JSON | {"Content-Encoding": "br"}
    is_problem(client.post("/trial", content=b"x", headers=headers), 415, "unsupported-content-encoding")


UNREADABLE = {
    "nothing": (b"", JSON),
    "half an object": (b'{"points": [[0, 0]', JSON),
    "garbage": (bytes(range(256)), JSON),
    "deep": (b"[" * 100_000, JSON),
    "NaN literal": (b'{"points": [[0, NaN], [1, 1]]}', JSON),
    "Infinity literal": (b'{"points": [[0, -Infinity], [1, 1]]}', JSON),
    "no array": (b"\x93NUMPY garbage", NPY),
    "half an array": (npy(np.zeros((5, 2)))[:-8], NPY),
    "half a gzip": (gzip.compress(b'{"points": [[0, 0]]}')[:-9], JSON | {"Content-Encoding": "gzip"}),
    "no gzip": (b"plain", JSON | {"Content-Encoding": "gzip"}),
    "no form": (b"--x", {"Content-Type": "multipart/form-data; boundary=y"}),
    "no boundary": (b"--x", {"Content-Type": "multipart/form-data"}),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_an_unreadable_body_is_400(client: httpx.Client, name: str) -> None:
    content, headers = UNREADABLE[name]
    is_problem(client.post("/trial", content=content, headers=headers), 400, "unreadable-body")


INVALID = {
    "no object": ([1, 2], ["body"]),
    "no points": ({}, ["body", "points"]),
    "null": ({"points": None}, ["body", "points"]),
    "empty": ({"points": []}, ["body", "points"]),
    "flat": ({"points": [1, 2, 3]}, ["body", "points", 0]),
    "string": ({"points": [[0, 0], [1, MARK]]}, ["body", "points", 1, 1]),
    "number as string": ({"points": [[0, 0], [1, "2"]]}, ["body", "points", 1, 1]),
    "boolean": ({"points": [[0, 0], [True, 2]]}, ["body", "points", 1, 0]),
    "hole": ({"points": [[0, 0], [None, 2]]}, ["body", "points", 1, 0]),
    "one number": ({"points": [[0, 0], [1]]}, ["body", "points", 1]),
    "four numbers": ({"points": [[0, 0, 0, 0]]}, ["body", "points", 0]),
    "mixed lengths": ({"points": [[0, 0], [0, 0, 1]]}, ["body", "points", 1]),
    "unknown field": ({"points": POINTS, MARK: 1}, ["body", MARK]),
    "unknown parameter": ({"points": POINTS, "parameters": {"depth": 1}}, ["body", "parameters", "depth"]),
    "parameter of another type": (
        {"points": POINTS, "parameters": {"seconds": MARK}},
        ["body", "parameters", "seconds"],
    ),
    "parameter out of range": (
        {"points": POINTS, "parameters": {"seconds": -1}},
        ["body", "parameters", "seconds"],
    ),
    "parameters of no kind": ({"points": POINTS, "parameters": []}, ["body", "parameters"]),
    "include": ({"points": POINTS, "include": ["stages"]}, ["body", "include"]),
}


@pytest.mark.parametrize("name", INVALID)
def test_invalid_input_is_422_and_says_where(client: httpx.Client, name: str) -> None:
    body, loc = INVALID[name]
    document = is_problem(client.post("/trial", json=body), 422)
    assert document["errors"][0]["loc"][: len(loc)] == loc
    assert name == "unknown field" or MARK not in str(document)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite_are_422(client: httpx.Client, value: float) -> None:
    points = np.zeros((4, 3))
    points[2, 1] = value
    document = is_problem(client.post("/trial", content=npy(points), headers=NPY), 422, "invalid-points")
    assert document["errors"][0]["loc"] == ["body", "points", 2, 1]


def test_a_number_beyond_the_floats_is_422(client: httpx.Client) -> None:
    response = client.post("/trial", content=b'{"points": [[0, 1e999], [1, 1]]}', headers=JSON)
    is_problem(response, 422, "invalid-points")


def test_too_many_points_are_413(client: httpx.Client) -> None:
    for count, status in ((20_000, 200), (20_001, 413)):
        body = npy(np.zeros((count, 2), np.float32))
        assert client.post("/trial", content=body, headers=NPY).status_code == status
    is_problem(client.post("/trial", content=body, headers=NPY), 413, "too-many-points")


def test_too_many_bytes_are_413_however_they_come(client: httpx.Client) -> None:
    large = b"0 0\n" * 600_000
    is_problem(client.post("/trial", content=large, headers=CSV), 413, "too-many-bytes")
    chunks = (large[start : start + 50_000] for start in range(0, len(large), 50_000))
    is_problem(client.post("/trial", content=chunks, headers=CSV), 413, "too-many-bytes")
    packed = CSV | {"Content-Encoding": "gzip"}
    is_problem(client.post("/trial", content=gzip.compress(large), headers=packed), 413, "too-many-bytes")


def test_a_body_announced_as_too_large_is_refused_before_it_comes(url: str) -> None:
    target = urlsplit(url)
    head = b"POST /trial HTTP/1.1\r\nHost: x\r\nContent-Type: text/csv\r\nContent-Length: 99999999999\r\n\r\n"
    with socket.create_connection((target.hostname, target.port), timeout=20) as connection:
        connection.sendall(head)
        assert connection.recv(12) == b"HTTP/1.1 413"


def test_a_client_that_leaves_in_the_middle_of_its_body_harms_nobody(client: httpx.Client, url: str) -> None:
    target = urlsplit(url)
    with socket.create_connection((target.hostname, target.port)) as connection:
        connection.sendall(b"POST /trial HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n0 0")
    assert client.post("/trial", json={"points": POINTS}).status_code == 200


fuzz = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
media_types = st.sampled_from(
    ["application/json", "text/csv", "text/plain", "application/x-npy", "multipart/form-data; boundary=a"]
)


@fuzz
@given(
    body=st.binary(max_size=200) | st.text(max_size=80).map(str.encode),
    media_type=media_types,
    encoding=st.sampled_from(["", "", "gzip", "identity"]),
)
def test_no_body_is_a_defect(client: httpx.Client, body: bytes, media_type: str, encoding: str) -> None:
    headers = {"Content-Type": media_type, "Content-Encoding": encoding}
    response = client.post("/trial", content=body, headers=headers)
    if response.status_code != 200:
        assert response.status_code in {400, 413, 415, 422}
        is_problem(response, response.status_code)


names = st.sampled_from(["points", "parameters", "include", "seconds", "a"])
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(names, inner),
    max_leaves=12,
)
rows = st.lists(st.lists(st.floats(), min_size=2, max_size=3), max_size=4)


@fuzz
@given(points=values | rows, parameters=values)
def test_no_json_is_a_defect(client: httpx.Client, points: object, parameters: object) -> None:
    body = json.dumps({"points": points, "parameters": parameters}).encode()
    response = client.post("/trial", content=body, headers=JSON)
    if response.status_code != 200:
        assert response.status_code in {400, 422}
        is_problem(response, response.status_code)


queries = st.lists(
    st.tuples(st.sampled_from(["seconds", "include", "format", "x"]), st.text(max_size=6)), max_size=3
)


@fuzz
@given(query=queries)
def test_no_query_is_a_defect(client: httpx.Client, query: list[tuple[str, str]]) -> None:
    response = client.post("/trial", params=query, content=b"0 0\n1 1\n", headers=CSV)
    if response.status_code != 200:
        assert response.status_code in {406, 422}
        is_problem(response, response.status_code)
