from __future__ import annotations

import io
import re
import subprocess
import sys
import uuid

import httpx
import numpy as np
import pytest
from expect import is_problem

from service.answers import ExampleAnswer, ExampleList, Landing, PartitionAnswer
from service.app import create_app
from service.processes import PROCESSES
from service.settings import Settings

POINTS = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.25]]


def test_the_web_process_imports_nothing_that_only_workers_need() -> None:
    code = "import sys, service.app; service.app.create_app(); print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)  # noqa: S603 # own
    loaded = run.stdout
    assert {"numba", "scipy", "matplotlib", "shapely"}.isdisjoint(loaded.split())


def test_each_process_has_its_route() -> None:
    app = create_app(Settings())
    assert {row.path for row in PROCESSES} <= set(app.openapi()["paths"])


def test_a_cloud_is_answered(client: httpx.Client) -> None:
    response = client.post("/trial", json={"points": POINTS})
    assert response.status_code == 200
    assert response.headers["content-type"] == "application/json"
    assert PartitionAnswer.model_validate(response.json()).labels == [-1, -1, -1]


def test_steps_are_timed_for_the_browser(client: httpx.Client) -> None:
    timing = client.post("/trial", json={"points": POINTS}).headers["server-timing"]
    assert re.fullmatch(r"intake;dur=[\d.]+, compute;dur=[\d.]+, render;dur=[\d.]+", timing)


def test_every_answer_has_an_id_of_its_own(client: httpx.Client) -> None:
    first, second = (client.get("/healthz").headers["x-request-id"] for _ in range(2))
    assert uuid.UUID(first) != uuid.UUID(second)


@pytest.mark.parametrize("query", ["?format=csv", "?format=CSV"])
def test_format_wins_over_accept(client: httpx.Client, query: str) -> None:
    response = client.post(f"/trial{query}", json={"points": POINTS}, headers={"Accept": "application/json"})
    assert response.headers["content-type"].startswith("text/csv")


def test_accept_chooses_the_form(client: httpx.Client) -> None:
    response = client.post("/trial", json={"points": POINTS}, headers={"Accept": "text/csv, */*;q=0.1"})
    assert response.headers["content-type"].startswith("text/csv")
    assert "Accept" in response.headers["vary"]


def test_a_body_in_chunks_and_one_kept_on_disk_are_read_like_others(client: httpx.Client) -> None:
    points = np.random.default_rng(0).normal(size=(20_000, 3))
    text = "\n".join(",".join(map(repr, map(float, row))) for row in points).encode()
    assert 1024 * 1024 < len(text) < 2_000_000
    chunks = (text[start : start + 10_000] for start in range(0, len(text), 10_000))
    response = client.post("/trial", content=chunks, headers={"Content-Type": "text/csv"})
    assert len(response.json()["labels"]) == 20_000


def test_landing_has_links_that_work(client: httpx.Client) -> None:
    response = client.get("/")
    assert response.headers["content-type"] == "application/json"
    landing = Landing.model_validate(response.json())
    assert {row.path for row in PROCESSES} <= {link.href for link in landing.links}
    for link in landing.links:
        if link.rel != "process":
            assert client.get(link.href).status_code == 200


def test_browsers_get_a_page(client: httpx.Client) -> None:
    response = client.get("/", headers={"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"})
    assert response.headers["content-type"].startswith("text/html")
    for path in re.findall(r'href="([^"]+)"', response.text):
        assert client.get(path).status_code == 200


def test_the_documentation_needs_no_other_server(client: httpx.Client) -> None:
    page = client.get("/docs").text
    assets = re.findall(r'(?:src|href)="([^"]+)"', page)
    assert len(assets) >= 2
    for asset in assets:
        assert asset.startswith("/")
        assert client.get(asset).status_code == 200


def test_examples_are_listed_and_every_one_can_be_drawn(client: httpx.Client) -> None:
    listed = ExampleList.model_validate(client.get("/examples").json()).examples
    assert {"circle", "spiral"} <= {example.name for example in listed}
    for example in listed:
        drawn = ExampleAnswer.model_validate(client.get(f"/examples/{example.name}?n=40").json())
        assert len(drawn.points) == len(drawn.truth.curve_of) == 40
        assert drawn.parameters == example.defaults.model_copy(update={"n": 40})


def test_an_example_is_what_was_asked_for(client: httpx.Client) -> None:
    query = {"n": 100, "sigma": 0, "outliers": 0.1, "seed": 3}
    drawn = ExampleAnswer.model_validate(client.get("/examples/circle", params=query).json())
    on_curve = np.array(drawn.points)[np.array(drawn.truth.curve_of) >= 0]
    assert (len(drawn.points), len(on_curve), drawn.truth.sigma) == (110, 100, 0.0)
    radii = np.linalg.norm(on_curve - np.mean(drawn.truth.curves[0].vertices, axis=0), axis=1)
    assert np.ptp(radii) < 1e-9 * radii.max()


def test_all_forms_of_an_example_hold_the_same_points(client: httpx.Client) -> None:
    points = np.array(client.get("/examples/helix?n=50").json()["points"])
    text = client.get("/examples/helix?n=50", headers={"Accept": "text/csv"}).text
    array = client.get("/examples/helix?n=50", headers={"Accept": "application/x-npy"}).content
    assert np.array_equal(np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1), points)
    assert np.array_equal(np.load(io.BytesIO(array)), points)
    assert client.get("/examples/helix?n=50&format=npy").content == array


@pytest.mark.parametrize(("form", "media_type"), [("csv", "text/csv"), ("npy", "application/x-npy")])
def test_an_example_can_be_posted_as_it_is(client: httpx.Client, form: str, media_type: str) -> None:
    drawn = client.get(f"/examples/spiral?n=200&format={form}")
    assert drawn.headers["content-type"].startswith(media_type)
    response = client.post("/trial", content=drawn.content, headers={"Content-Type": media_type})
    assert len(response.json()["labels"]) == 200


def test_an_unknown_example_is_not_found(client: httpx.Client) -> None:
    is_problem(client.get("/examples/nothing"), 404, "not-found")


@pytest.mark.parametrize(
    "query", ["n=0", "n=x", "n=99999999", "sigma=-1", "sigma=nan", "outliers=inf", "seed=-1", "m=3"]
)
def test_an_example_out_of_range_is_refused_where_it_is_wrong(client: httpx.Client, query: str) -> None:
    document = is_problem(client.get(f"/examples/circle?{query}"), 422, "invalid-parameter")
    assert document["errors"][0]["loc"] == ["query", query.partition("=")[0]]


def test_an_example_in_an_unknown_form_is_refused(client: httpx.Client) -> None:
    is_problem(client.get("/examples/circle?format=bmp"), 422, "invalid-parameter")
    is_problem(client.get("/examples/circle", headers={"Accept": "image/bmp"}), 406, "not-acceptable")


@pytest.mark.parametrize("path", ["/", "/healthz", "/examples", "/examples/circle", "/openapi.json", "/docs"])
def test_what_can_be_got_has_a_head(client: httpx.Client, path: str) -> None:
    response = client.head(path)
    assert (response.status_code, response.content) == (200, b"")
    assert response.headers["content-length"] == client.get(path).headers["content-length"]


@pytest.mark.parametrize(
    ("path", "methods"), [("/trial", "OPTIONS, POST"), ("/examples/circle", "GET, HEAD, OPTIONS")]
)
def test_options_names_the_methods(client: httpx.Client, path: str, methods: str) -> None:
    response = client.options(path)
    assert (response.status_code, response.headers["allow"]) == (204, methods)


def test_pages_of_the_origins_allowed_may_read_answers(client: httpx.Client) -> None:
    asked = {"Origin": "https://pages.example", "Access-Control-Request-Method": "POST"}
    allowed = client.options("/trial", headers=asked | {"Access-Control-Request-Headers": "content-type"})
    assert allowed.status_code == 200
    assert allowed.headers["access-control-allow-origin"] == "https://pages.example"
    answer = client.post("/trial", json={}, headers={"Origin": "https://pages.example"})
    assert answer.headers["access-control-allow-origin"] == "https://pages.example"
    other = client.post("/trial", json={}, headers={"Origin": "https://elsewhere.example"})
    assert "access-control-allow-origin" not in other.headers
