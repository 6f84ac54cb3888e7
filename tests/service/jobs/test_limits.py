"""What keeps one client's jobs from harming another's: limits, the queue's length and order, expiry."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from conftest import Serve
from dbos import DBOSClient
from expect import is_problem

from jobs.client import ASYNC, begun, body, ended, gone, lives, order, ordered, until
from jobs.restarting import Service
from service.jobs import engine
from service.jobs.expiry import Expiry
from service.jobs.jobs import _priority
from service.store import Store

LARGE = [[float(k), 0.5] for k in range(60_000)]


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("limits")


@pytest.fixture(scope="module")
def service(serve: Serve, directory: Path) -> Iterator[Service]:
    with Service(serve, directory, job_memory=256 * 2**20, job_seconds=4) as service:
        service.warm()
        yield service


@pytest.fixture(scope="module")
def client(service: Service) -> httpx.Client:
    return service.client


def test_a_job_that_takes_too_much_memory_fails_alone(client: httpx.Client, tmp_path: Path) -> None:
    other, process = begun(client, tmp_path, seconds=1.5)
    greedy = ordered(client, megabytes=1000)
    assert ended(client, greedy)["status"] == "failed"
    is_problem(client.get(f"{greedy}/results"), 503, "out-of-memory")
    assert not gone(process)
    assert ended(client, other)["status"] == "successful"
    assert ended(client, ordered(client, megabytes=100))["status"] == "successful"


def test_a_job_that_takes_too_long_fails_alone(client: httpx.Client, tmp_path: Path) -> None:
    slow, process = begun(client, tmp_path, seconds=600)
    other = ordered(client, seconds=0.5)
    assert ended(client, slow)["status"] == "failed"
    assert gone(process)
    is_problem(client.get(f"{slow}/results"), 503, "deadline-exceeded")
    assert ended(client, other)["status"] == "successful"


def test_a_small_job_overtakes_large_ones(client: httpx.Client, tmp_path: Path) -> None:
    busy = [begun(client, tmp_path, seconds=3)[0] for _ in range(2)]
    large = [client.post("/trial", json=body(LARGE), headers=ASYNC).headers["location"] for _ in range(4)]
    small = ordered(client)
    for job in busy:
        client.delete(job)
    began = [ended(client, job)["started"] for job in large]
    assert sum(ended(client, small)["started"] > other for other in began) <= 1  # two compute at a time


def test_large_jobs_do_not_wait_for_ever() -> None:
    sizes = [0, 10**6, 10**7, 10**8, 10**9, 10**15]
    places = [_priority(size) for size in sizes]
    assert places == sorted(places)
    assert places[0] < places[2] < places[3]
    assert places[-1] - places[0] <= 601  # one that comes so much later goes behind
    assert all(0 < place < 2**31 for place in places)


# --- the queue ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def waiting(serve: Serve) -> Iterator[httpx.Client]:
    """A service whose jobs all wait."""
    with (
        serve(job_workers=0, workers=1, job_queue_length=40, ready=False) as (url, _),
        httpx.Client(base_url=url, timeout=60) as client,
    ):
        until(lambda: lives(client))
        yield client


def pages(client: httpx.Client, **query: object) -> Iterator[list[str]]:
    """Go from page to page; yield the addresses of the jobs on each."""
    answer = client.get("/jobs", params=query)  # type: ignore[arg-type]
    while True:
        assert answer.status_code == 200, answer.text
        following = [link["href"] for link in answer.json()["links"] if link["rel"] == "next"]
        assert following == [link["url"] for link in answer.links.values()]
        yield [f"/jobs/{one['jobID']}" for one in answer.json()["jobs"]]
        if not following:
            return
        answer = client.get(following[0])


def test_pages_show_each_job_once_while_others_come_and_change(waiting: httpx.Client) -> None:
    jobs = [ordered(waiting) for _ in range(20)]
    for job in jobs[::2]:
        waiting.delete(job)
    for query in ({}, {"limit": 1}, {"limit": 7}, {"limit": 20}, {"limit": 1000}):
        shown = [job for page in pages(waiting, **query) for job in page]
        assert shown == jobs[::-1]
    shown = []
    for page in pages(waiting, limit=3):
        shown += page
        ordered(waiting)  # latest of all: it has no place on the pages that follow
    assert shown == jobs[::-1]
    dismissed = [job for page in pages(waiting, status="dismissed", limit=3) for job in page]
    assert dismissed == jobs[::-1][1::2]
    both = [job for page in pages(waiting, status=["dismissed", "accepted"], limit=4) for job in page]
    assert both[-20:] == jobs[::-1]
    assert list(pages(waiting, status="running")) == [[]]
    assert list(pages(waiting, process="partition")) == [[]]
    assert len(next(pages(waiting, process=["trial", "none"]))) > 20


@pytest.mark.parametrize(
    "query",
    [{"cursor": text} for text in ("", "x", "0.0.0", "1.2", "9" * 30 + ".0.x", "-1764754567000.1.x", "é.1.x")]
    + [{"limit": 0}, {"limit": 1001}, {"limit": "x"}, {"status": "unknown"}, {"states": "running"}],
)
def test_a_listing_that_cannot_be_asked_for_is_refused(
    waiting: httpx.Client, query: dict[str, object]
) -> None:
    is_problem(waiting.get("/jobs", params=query), 422, "invalid-parameter")  # type: ignore[arg-type]


def test_a_full_queue_refuses_and_has_room_again_when_a_job_leaves_it(waiting: httpx.Client) -> None:
    key = {**ASYNC, "idempotency-key": "kept"}
    known = ordered(waiting, key)
    jobs = [known]
    while (answer := order(waiting)).status_code == 201:
        jobs.append(answer.headers["location"])
    is_problem(answer, 429, "queue-full")
    assert int(answer.headers["retry-after"]) >= 1
    count = sum(map(len, pages(waiting, status="accepted")))
    assert count == 40
    assert ordered(waiting, key) == known  # it has its place
    waiting.delete(jobs[-1])
    until(lambda: order(waiting).status_code == 201, 10)
    is_problem(order(waiting), 429, "queue-full")


# --- expiry ---------------------------------------------------------------------------------------


@pytest.fixture
def database(directory: Path, service: Service) -> Iterator[DBOSClient]:
    assert service.pid  # it has made the database
    connection = engine.connect(f"sqlite:///{directory}/jobs.sqlite")
    yield connection
    connection.destroy()


@pytest.fixture
def store(directory: Path) -> Store:
    return Store((directory / "store").as_uri())


def kept(client: httpx.Client, job: str) -> bool:
    return client.get(job).status_code == 200


def test_jobs_expire_by_age_with_their_files(
    client: httpx.Client, database: DBOSClient, store: Store, tmp_path: Path
) -> None:
    job = ordered(client)
    ended(client, job)
    folder = job.removeprefix("/")
    Expiry(database, store, keep_seconds=60, keep_bytes=10**9).sweep()
    assert kept(client, job)
    assert store.folders(folder)
    time.sleep(2.1)  # the database counts in seconds
    running, _ = begun(client, tmp_path, seconds=2)
    Expiry(database, store, keep_seconds=1, keep_bytes=10**9).sweep()
    assert not kept(client, job)
    assert not store.folders(folder)
    assert kept(client, running)
    assert ended(client, running)["status"] == "successful"


def test_the_oldest_finished_jobs_go_when_there_is_no_more_room(
    client: httpx.Client, database: DBOSClient, store: Store, tmp_path: Path
) -> None:
    Expiry(database, store, keep_seconds=60, keep_bytes=0).sweep()
    jobs = [client.post("/trial", json=body(LARGE), headers=ASYNC).headers["location"] for _ in range(3)]
    for job in jobs:
        ended(client, job)
    Expiry(database, store, keep_seconds=60, keep_bytes=10**9).sweep()
    assert not any(store.folders(f"{job.removeprefix('/')}/input") for job in jobs)  # nobody needs them now
    total = sum(entry.size for entry in store.folders("jobs"))
    Expiry(database, store, keep_seconds=60, keep_bytes=total).sweep()
    assert all(kept(client, job) for job in jobs)
    Expiry(database, store, keep_seconds=60, keep_bytes=total - 1).sweep()
    assert [kept(client, job) for job in jobs] == [False, True, True]
    running, _ = begun(client, tmp_path, seconds=3)
    Expiry(database, store, keep_seconds=60, keep_bytes=0).sweep()
    assert [kept(client, job) for job in (*jobs, running)] == [False, False, False, True]
    assert ended(client, running)["status"] == "successful"


def test_what_processes_that_died_have_left_is_tidied_up(database: DBOSClient, store: Store) -> None:
    store.write("jobs/orphan/old/file", b"old")
    store.write("jobs/young/file", b"new")
    old, young = store.staging / "tapeline-old", store.staging / "tapeline-young"
    for file in (old, young):
        file.write_bytes(b"upload")
    with store.local("jobs/orphan/old/file") as file:
        for one in (file, old):
            os.utime(one, (0, time.time() - 7200))
    Expiry(database, store, keep_seconds=60, keep_bytes=10**9).sweep()
    assert [store.has("jobs/orphan/old/file"), store.has("jobs/young/file")] == [False, True]
    assert [old.exists(), young.exists()] == [False, True]
