"""Every process of a service is killed in the middle of its work; no job is lost, doubled, or held up."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from conftest import Serve
from expect import is_problem

from jobs.client import begun, ended, gone, info, ordered, signed, until
from jobs.restarting import Service


@pytest.fixture(scope="module")
def service(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with Service(serve, tmp_path_factory.mktemp("crashes")) as service:
        service.warm()
        yield service


def kill(process: int) -> None:
    os.kill(process, signal.SIGKILL)


def all_done(service: Service, jobs: list[str]) -> None:
    """Check that jobs come to an end, each with the one result that it must have."""
    client = service.client
    for job in jobs:
        told = ended(client, job)
        assert told["status"] == "successful", told
        assert client.get(f"{job}/results").json()["labels"] == [-1, -1, -1]
    for state in ("accepted", "running"):
        assert client.get("/jobs", params={"status": state}).json()["jobs"] == []


def test_a_computation_that_is_killed_is_done_once_more(service: Service, tmp_path: Path) -> None:
    job, process = begun(service.client, tmp_path, seconds=1.5)
    (sign,) = tmp_path.iterdir()
    kill(process)
    until(lambda: signed(sign) not in {0, process})
    all_done(service, [job])


def test_a_computation_that_dies_twice_fails_and_harms_no_other(service: Service, tmp_path: Path) -> None:
    other, process = begun(service.client, tmp_path, seconds=2.0)
    deadly = ordered(service.client, outcome="death")
    assert ended(service.client, deadly)["status"] == "failed"
    is_problem(service.client.get(f"{deadly}/results"), 503, "worker-lost")
    assert info(service.client, other)["status"] == "running"
    assert not gone(process)
    all_done(service, [other])


def test_jobs_survive_the_process_that_leads_their_computations(service: Service, tmp_path: Path) -> None:
    running = [begun(service.client, tmp_path, seconds=1.5) for _ in range(2)]
    waiting = ordered(service.client)
    before = service.worker
    kill(before)
    until(lambda: all(gone(process) for _, process in running), 10)
    assert info(service.client, waiting)["status"] == "accepted"
    all_done(service, [*(job for job, _ in running), waiting])
    assert service.worker != before


def test_jobs_survive_the_process_that_others_are_forked_from(service: Service, tmp_path: Path) -> None:
    job, process = begun(service.client, tmp_path, seconds=1.5)
    (pattern,) = psutil.Process(process).parents()[:1]
    assert pattern.pid != service.worker
    pattern.kill()
    until(lambda: gone(process), 10)
    all_done(service, [job])


def test_jobs_survive_a_service_that_is_told_to_stop(service: Service, tmp_path: Path) -> None:
    running = [begun(service.client, tmp_path, seconds=1.5)[0] for _ in range(2)]
    waiting = ordered(service.client)
    created = info(service.client, waiting)["created"]
    service.end(signal.SIGTERM)
    service.start()
    all_done(service, [*running, waiting])
    assert info(service.client, waiting)["created"] == created


def test_of_many_jobs_under_random_kills_none_is_lost_and_none_stuck(
    service: Service, tmp_path: Path
) -> None:
    chance = random.Random(7)
    signs = [tmp_path / str(k) for k in range(30)]
    jobs = [ordered(service.client, seconds=chance.uniform(0, 0.6), sign=str(sign)) for sign in signs]
    for victim in ("child", "worker", "service"):
        time.sleep(chance.uniform(0.2, 1.0))
        until(lambda: running(service))
        if victim == "child":
            children = {process for process in map(signed, signs) if process and not gone(process)}
            for process in children:
                kill(process)
        elif victim == "worker":
            kill(service.worker)
        else:
            service.end()
            service.start()
    all_done(service, jobs)
    assert len(set(jobs)) == len(jobs)


def running(service: Service) -> bool:
    return bool(service.client.get("/jobs", params={"status": "running"}).json()["jobs"])
