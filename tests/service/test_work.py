"""What clients see of the pool, through a server of its own for each case."""

from __future__ import annotations

import os
import signal
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path

import httpx
import pytest
from conftest import Serve
from expect import is_problem

POINTS = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.25]]


def post(url: str, **parameters: object) -> httpx.Response:
    return httpx.post(f"{url}/trial", json={"points": POINTS, "parameters": parameters}, timeout=60)


@contextmanager
def meanwhile(work: Callable[[], httpx.Response]) -> Iterator[Future[httpx.Response]]:
    """Let a request go on while the block runs."""
    with ThreadPoolExecutor(1) as threads:
        yield threads.submit(work)


def worker(url: str, directory: Path, seconds: float = 0.0) -> int:
    """Return the worker that takes a request, as soon as it has begun; the request goes on in a thread."""
    sign = directory / str(uuid.uuid4())
    threading.Thread(target=_post_in_vain, args=(url, str(sign), seconds), daemon=True).start()
    until(lambda: sign.exists() and sign.read_text() != "")
    return int(sign.read_text())


def _post_in_vain(url: str, sign: str, seconds: float) -> None:
    with suppress(httpx.TransportError):  # some servers are killed
        post(url, sign=sign, seconds=seconds)


def workers(url: str, directory: Path, count: int = 2) -> set[int]:
    """Return the processes of all workers."""
    seen: set[int] = set()

    def look() -> bool:
        with ThreadPoolExecutor(count) as threads:
            seen.update(threads.map(lambda _: worker(url, directory, 0.1), range(count)))
        return len(seen) == count

    until(look)
    return seen


def gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.02)


@pytest.fixture(scope="module")
def url(serve: Serve) -> Iterator[str]:
    with serve() as (address, _):
        yield address


def test_slow_work_holds_up_neither_other_requests_nor_the_event_loop(serve: Serve, tmp_path: Path) -> None:
    with serve() as (url, server):
        busy = worker(url, tmp_path, seconds=600.0)
        for _ in range(20):
            assert httpx.get(f"{url}/healthz").json() == {"status": "ok"}
            assert worker(url, tmp_path) != busy
        server.kill()  # nobody waits for the slow one


def test_a_worker_killed_in_the_middle_is_replaced_and_its_request_answered(url: str, tmp_path: Path) -> None:
    sign = tmp_path / "sign"
    with meanwhile(lambda: post(url, sign=str(sign), seconds=1.0)) as slow:
        until(lambda: sign.exists() and sign.read_text() != "")
        killed = int(sign.read_text())
        os.kill(killed, signal.SIGKILL)
        assert post(url).status_code == 200
        assert slow.result().status_code == 200
    until(lambda: httpx.get(f"{url}/readyz").json() == {"status": "ready", "workers": 2})
    assert killed not in workers(url, tmp_path)


def test_a_request_that_kills_its_workers_is_told_so_and_harms_no_other(url: str, tmp_path: Path) -> None:
    sign = tmp_path / "sign"
    with meanwhile(lambda: post(url, sign=str(sign), seconds=1.0)) as other:
        until(sign.exists)
        response = post(url, outcome="death")
        is_problem(response, 503, "worker-lost")
        assert int(response.headers["retry-after"]) >= 1
        assert other.result().status_code == 200
        assert post(url).status_code == 200


def test_what_takes_too_long_becomes_a_job_and_frees_the_worker(serve: Serve) -> None:
    with serve(deadline_seconds=1.0, workers=1) as (url, _):
        response = post(url, seconds=600.0)
        assert response.status_code == 201
        assert httpx.get(f"{url}{response.headers['location']}").json()["status"] == "accepted"
        until(lambda: httpx.get(f"{url}/readyz").status_code == 200)
        assert post(url).status_code == 200


def test_a_full_queue_is_429(serve: Serve, tmp_path: Path) -> None:
    with serve(workers=1, queue_length=1) as (url, server), ThreadPoolExecutor(5) as threads:
        worker(url, tmp_path, seconds=600.0)
        sent = [threads.submit(post, url) for _ in range(5)]
        refused = list(islice(as_completed(sent), 4))
        for answer in refused:
            is_problem(answer.result(), 429, "queue-full")
            assert int(answer.result().headers["retry-after"]) >= 1
        assert sum(not one.done() for one in sent) == 1  # it waits
        server.kill()


def test_until_the_workers_are_warm_the_server_lives_but_is_not_ready(serve: Serve) -> None:
    with serve(ready=False) as (url, _):
        until(lambda: lives(url))
        seen = [httpx.get(f"{url}/readyz")]
        answer = post(url)  # it waits for the workers
        assert answer.status_code == 200
        until(lambda: httpx.get(f"{url}/readyz").status_code == 200)
        for response in seen:
            if response.status_code != 200:
                is_problem(response, 503, "not-ready")
                assert response.headers["retry-after"]


def lives(url: str) -> bool:
    try:
        return httpx.get(f"{url}/healthz").status_code == 200
    except httpx.TransportError:
        return False


def test_a_client_that_leaves_frees_its_place_in_the_queue_and_its_worker(
    serve: Serve, tmp_path: Path
) -> None:
    with serve(workers=1, queue_length=2) as (url, _):
        before = worker(url, tmp_path)
        for _ in range(2):  # the first computes, the second waits
            with pytest.raises(httpx.ReadTimeout):
                httpx.post(
                    f"{url}/trial", json={"points": POINTS, "parameters": {"seconds": 600}}, timeout=0.5
                )
        assert post(url).status_code == 200
        assert worker(url, tmp_path) != before


def test_workers_end_with_a_server_that_is_killed(serve: Serve, tmp_path: Path) -> None:
    with serve() as (url, server):
        idle_and_busy = workers(url, tmp_path)
        assert worker(url, tmp_path, seconds=600.0) in idle_and_busy
        server.kill()
        server.wait()
        until(lambda: all(map(gone, idle_and_busy)))


def test_workers_end_with_a_server_that_is_told_to_stop(serve: Serve, tmp_path: Path) -> None:
    with serve() as (url, server):
        left = workers(url, tmp_path)
        server.send_signal(signal.SIGINT)
        server.wait(20)
        assert all(map(gone, left))
