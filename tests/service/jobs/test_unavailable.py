"""Without a database there are no jobs, but everything else works."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from conftest import Serve
from expect import is_problem

from jobs.client import ASYNC, body, lives, order, until

JOB = "/jobs/6f2b1c9e-0000-4000-8000-000000000000"


@pytest.fixture(scope="module")
def client(serve: Serve) -> Iterator[httpx.Client]:
    with socket.socket() as closed:  # bound, but not listening
        closed.bind(("127.0.0.1", 0))
        database = f"postgresql://nobody@127.0.0.1:{closed.getsockname()[1]}/none"
        with (
            serve(job_workers=1, workers=1, database_url=database, job_bytes=10_000) as (url, _),
            httpx.Client(base_url=url, timeout=60) as client,
        ):
            yield client


def unavailable(answer: httpx.Response) -> None:
    is_problem(answer, 503, "jobs-unavailable")
    assert int(answer.headers["retry-after"]) >= 1


def test_quick_work_is_done(client: httpx.Client) -> None:
    for headers in ({}, {"prefer": "wait=10"}, {"prefer": "wait=10", "accept": "text/csv"}):
        assert order(client, headers).status_code == 200
    is_problem(order(client, {}, outcome="degenerate"), 422, "degenerate-input")
    assert client.get("/healthz").status_code == 200


def test_jobs_are_refused(client: httpx.Client) -> None:
    unavailable(order(client, ASYNC))
    unavailable(order(client, {"idempotency-key": "one"}))
    unavailable(client.post("/trial", json=body([[k / 8, 0.5] for k in range(5000)])))
    for address in ("/jobs", JOB, f"{JOB}/results", f"{JOB}/events"):
        unavailable(client.get(address))
    unavailable(client.delete(JOB))


def test_long_work_is_late_for_it_cannot_go_on(client: httpx.Client) -> None:
    is_problem(order(client, {"prefer": "wait=1"}, seconds=600), 503, "deadline-exceeded")
    assert order(client, {}).status_code == 200


def test_a_data_directory_that_cannot_hold_jobs_is_no_defect(serve: Serve, tmp_path: Path) -> None:
    (tmp_path / "jobs.sqlite").mkdir()
    with (
        serve(workers=1, data_dir=tmp_path, ready=False) as (url, _),
        httpx.Client(base_url=url, timeout=60) as client,
    ):
        until(lambda: lives(client))
        unavailable(order(client, ASYNC))
