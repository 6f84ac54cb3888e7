"""Durable jobs on one machine: what kills lose, how soon jobs start and end, and what others feel of them."""

from __future__ import annotations

import argparse
import io
import random
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import httpx
import numpy as np
import psutil
from numpy.typing import NDArray

from benchmarks.goals import Goal, table
from benchmarks.serving import Service, serving
from core.truth import point_set

__all__ = ["Figures", "goals", "main", "measure", "tables"]

LIGHT, WHOLE = "benchmarks.tables:LIGHT", "benchmarks.tables:WHOLE"
ASYNC = {"prefer": "respond-async", "content-type": "application/x-npy"}
FINAL = ("successful", "failed", "dismissed")
STUCK_SECONDS = 180.0
"""A job that is not done so long after the last kill counts as stuck."""
MEGABYTE = 2**20


@dataclass(frozen=True, slots=True)
class Survival:
    """What came of jobs under kills of the service, of its worker, and of single computations."""

    jobs: int
    kills: int
    lost: int
    wrong: int
    stuck: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Delays:
    """Milliseconds: from submission to start when idle, and from dismissal to the end of the process."""

    start: NDArray[np.float64]
    dismissal: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Health:
    """Milliseconds that ``/healthz`` took under load, and how large the upload of that time was."""

    times: NDArray[np.float64]
    upload: int


@dataclass(frozen=True, slots=True)
class Memory:
    """Resident bytes of the web process: warm, after many requests, and after a job of many points."""

    requests: int
    points: int
    warm: int
    after_requests: int
    after_job: int


@dataclass(frozen=True, slots=True)
class Figures:
    """All of them."""

    survival: Survival
    delays: Delays
    health: Health
    memory: Memory


def measure(quick: bool = False) -> Figures:
    """Measure all; a quick run is a tenth."""
    points = 100_000 if quick else 1_000_000
    with serving(LIGHT, workers=2, job_workers=2, max_points=20_000_000) as service:
        delays = measure_delays(service, 5 if quick else 30, points)
    with serving(WHOLE, workers=2, job_workers=2, max_points=20_000_000) as service:
        memory = measure_memory(service, 200 if quick else 2000, points)
        health = measure_health(service, points, (10 if quick else 100) * MEGABYTE)
    survival = measure_survival(20 if quick else 200, 3 if quick else 20)
    return Figures(survival, delays, health, memory)


# --- kills ----------------------------------------------------------------------------------------


def measure_survival(jobs: int, kills: int, seed: int = 0) -> Survival:
    """Order jobs all the time while one process after the other is killed at random."""
    chance = random.Random(seed)
    bodies = [npy(point_set("s_shape", n=n, seed=n).points) for n in (1000, 30_000, 100_000, 200_000)]
    begin = time.monotonic()
    with serving(LIGHT, workers=1, job_workers=2) as service, ThreadPoolExecutor(1) as threads:
        expected = [_answer(service, body) for body in bodies]
        if _end(service, _order_surely(service, bodies[0])) != "successful":
            message = "not even an undisturbed job is done"
            raise RuntimeError(message)
        ordered = threads.submit(_order_all, service, bodies, jobs)
        hit: set[str] = set()
        for _ in range(kills):
            until(lambda: service.computations, STUCK_SECONDS)
            time.sleep(chance.uniform(0.0, 1.0))
            _kill(service, chance, hit)
        service.wait()
        lost = wrong = stuck = 0
        for job, which in ordered.result():
            state = _end(service, job)
            stuck += state not in FINAL
            lost += state in {"failed", "dismissed"}
            if state == "successful":
                wrong += httpx.get(f"{service.address}{job}/results").content != expected[which]
    return Survival(jobs, kills, lost, wrong, stuck, time.monotonic() - begin)


def _answer(service: Service, body: bytes) -> bytes:
    """Compute at once what jobs shall come to as well."""
    headers = {"content-type": "application/x-npy"}
    answer = httpx.post(f"{service.address}/reconstruct/pca", content=body, headers=headers, timeout=60)
    return answer.raise_for_status().content


def _order_all(service: Service, bodies: Sequence[bytes], count: int) -> list[tuple[str, int]]:
    """Order jobs, a few ahead of those that are done; what is refused or cut off is sent again."""
    ordered = []
    for k in range(count):
        which = k % len(bodies)
        ordered.append((_order_surely(service, bodies[which]), which))
        while len(_unfinished(service)) > 8:  # so that there is work for all kills
            time.sleep(0.1)
    return ordered


def _order_surely(service: Service, body: bytes) -> str:
    headers = {**ASYNC, "idempotency-key": str(uuid.uuid4())}
    while True:
        try:
            answer = httpx.post(
                f"{service.address}/reconstruct/pca", content=body, headers=headers, timeout=60
            )
            if answer.status_code == httpx.codes.CREATED:
                return str(answer.headers["location"])
        except httpx.TransportError:
            pass  # it has just been killed
        time.sleep(0.1)


def _unfinished(service: Service) -> list[Any]:
    try:
        query = {"status": ["accepted", "running"]}
        return list(httpx.get(f"{service.address}/jobs", params=query, timeout=60).json()["jobs"])
    except (httpx.TransportError, KeyError):
        return [None] * 100  # nobody knows


def _kill(service: Service, chance: random.Random, hit: set[str]) -> None:
    """Kill the service, its worker, or one of the computations, each as likely.

    A job whose own process dies twice is given up by design, for it may be the
    cause. So no other computation is killed before all that may have been hit
    are done; the worker is, instead.
    """
    victim = chance.choice(("service", "worker", "computation"))
    if victim == "service":
        service.kill()
        service.start()
        return
    process = service.worker
    unfinished = {one["jobID"] if one else "unknown" for one in _unfinished(service)}
    if victim == "computation" and not unfinished & {"unknown", *hit} and (found := service.computations):
        process = chance.choice(found)
        hit |= unfinished
    with suppress(psutil.NoSuchProcess):  # it was quicker
        if process is not None:
            process.kill()


def _end(service: Service, job: str) -> str:
    """Wait for the end of a job; return its state then, or when it is stuck."""
    end = time.monotonic() + STUCK_SECONDS
    while True:
        state = str(httpx.get(f"{service.address}{job}", timeout=60).json().get("status", "failed"))
        if state in FINAL or time.monotonic() > end:
            return state
        time.sleep(0.05)


# --- delays ---------------------------------------------------------------------------------------


def measure_delays(service: Service, repeats: int, points: int) -> Delays:
    """Order small jobs one after the other, then dismiss large ones while they are computed."""
    small = npy(point_set("s_shape", n=100).points)
    large = npy(point_set("s_shape", n=points).points)
    with httpx.Client(base_url=service.address, timeout=60) as client:
        for _ in range(3):
            _finish(client, small)
        starts = [_finish(client, small) for _ in range(repeats)]
        ends = [_dismiss(service, client, large) for _ in range(max(repeats // 3, 3))]
    return Delays(np.array(starts), np.array(ends))


def _finish(client: httpx.Client, body: bytes) -> float:
    """Let a job be done; return the milliseconds from its order to its start, as it tells them."""
    job = client.post("/reconstruct/pca", content=body, headers=ASYNC).headers["location"]
    while (told := client.get(job).json())["status"] not in FINAL:
        time.sleep(0.02)
    created, started = (datetime.fromisoformat(told[name]) for name in ("created", "started"))
    return 1e3 * (started - created).total_seconds()


def _dismiss(service: Service, client: httpx.Client, body: bytes) -> float:
    """Dismiss a job in the middle; return the milliseconds until its process is no more."""
    job = client.post("/reconstruct/pca", content=body, headers=ASYNC).headers["location"]
    until(lambda: service.computations, STUCK_SECONDS)
    (process,) = service.computations
    time.sleep(0.3)  # it is past reading its input
    begin = time.perf_counter()
    client.delete(job)
    while process.is_running() and process.status() != psutil.STATUS_ZOMBIE:
        time.sleep(0.001)
    return 1e3 * (time.perf_counter() - begin)


# --- what others feel -----------------------------------------------------------------------------


def measure_health(service: Service, points: int, upload: int) -> Health:
    """Ask for the health all the time while two large jobs are computed and a large body arrives."""
    large = npy(point_set("s_shape", n=points, outliers=0.05).points)
    body = npy(np.random.default_rng(0).uniform(size=(upload // 16, 2)))
    with httpx.Client(base_url=service.address, timeout=300) as client:
        jobs = [
            client.post("/reconstruct", content=large, headers=ASYNC).headers["location"] for _ in range(2)
        ]
        until(lambda: len(service.computations) == 2, STUCK_SECONDS)
        with _asking(service) as times:
            time.sleep(1.0)
            jobs.append(client.post("/partition", content=body, headers=ASYNC).headers["location"])
            jobs.append(client.post("/partition", content=_slowly(body), headers=ASYNC).headers["location"])
            time.sleep(1.0)
        for job in jobs:
            client.delete(job)
    return Health(np.array(times), len(body))


@contextmanager
def _asking(service: Service) -> Iterator[list[float]]:
    """Ask a hundred times a second while the block runs; collect the milliseconds."""
    times: list[float] = []
    over = threading.Event()

    def ask() -> None:
        with httpx.Client(base_url=service.address, timeout=60) as client:
            while not over.wait(0.01):
                begin = time.perf_counter()
                client.get("/healthz").raise_for_status()
                times.append(1e3 * (time.perf_counter() - begin))

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield times
    finally:
        over.set()
        thread.join()


def _slowly(body: bytes, seconds: float = 5.0) -> Iterator[bytes]:
    """Send a body as over a line that takes so long."""
    chunk = len(body) // 100 + 1
    for start in range(0, len(body), chunk):
        yield body[start : start + chunk]
        time.sleep(seconds / 100)


def measure_memory(service: Service, requests: int, points: int) -> Memory:
    """Watch the web process over many requests of all kinds, and over a job of many points."""
    small = npy(point_set("s_shape", n=200).points)
    with httpx.Client(base_url=service.address, timeout=600) as client:
        job = client.post("/partition", content=small, headers=ASYNC).headers["location"]
        visits: list[Callable[[], httpx.Response]] = [
            lambda: client.post("/partition", content=small, headers={"content-type": "application/x-npy"}),
            lambda: client.get(job),
            lambda: client.get("/jobs"),
            lambda: client.get("/nowhere"),
            lambda: client.post("/partition", content=b"?", headers={"content-type": "application/x-npy"}),
        ]
        _visit(visits, 100)
        warm = service.server.memory_info().rss
        _visit(visits, requests)
        after_requests = service.server.memory_info().rss
        large = npy(point_set("s_shape", n=points).points)
        job = client.post("/partition", content=large, headers=ASYNC).headers["location"]
        while client.get(job).json()["status"] not in FINAL:
            time.sleep(0.1)
        client.get(f"{job}/results").raise_for_status()
        after_job = service.server.memory_info().rss
    return Memory(requests, points, warm, after_requests, after_job)


def _visit(visits: Sequence[Callable[[], httpx.Response]], count: int) -> None:
    for k in range(count):
        visits[k % len(visits)]()


# --- tables ---------------------------------------------------------------------------------------


def goals(figures: Figures) -> list[Goal]:
    """Put what was measured beside what is to be reached."""
    survival, delays, memory = figures.survival, figures.delays, figures.memory
    under = f"of {survival.jobs} jobs under {survival.kills} kills"
    rows = [
        (f"lost {under}", survival.lost, 0, ".0f"),
        (f"with another result {under}", survival.wrong, 0, ".0f"),
        (f"stuck {under}", survival.stuck, 0, ".0f"),
        ("submission to start when idle, median, ms", np.median(delays.start), 150, ".0f"),
        ("submission to start when idle, slowest, ms", delays.start.max(), 150, ".0f"),
        ("dismissal to free core, slowest, ms", delays.dismissal.max(), 1000, ".0f"),
        ("/healthz under load, p99, ms", np.quantile(figures.health.times, 0.99), 50, ".1f"),
        (
            f"growth of the web process over {memory.requests} requests, MB",
            (memory.after_requests - memory.warm) / 1e6,
            5,
            ".1f",
        ),
        (
            f"growth of the web process over a job of {memory.points:,} points, MB",
            (memory.after_job - memory.after_requests) / 1e6,
            5,
            ".1f",
        ),
    ]
    return [Goal(what, float(value), bound, at_most=True, shown=shown) for what, value, bound, shown in rows]


def tables(figures: Figures) -> list[str]:
    """Return markdown tables."""
    health, memory = figures.health, figures.memory
    return [
        *table(goals(figures)),
        "",
        f"The kills took {figures.survival.seconds:.0f} s, restarts included. {len(health.times)} requests "
        f"for /healthz: median {np.median(health.times):.1f} ms, slowest {health.times.max():.0f} ms, while "
        f"two jobs were computed and {health.upload / 1e6:.0f} MB arrived twice, at once and over five "
        f"seconds. The web process has {memory.warm / 1e6:.0f} MB.",
    ]


def npy(points: NDArray[np.float64]) -> bytes:
    """Write points as a body."""
    buffer = io.BytesIO()
    np.save(buffer, points)
    return buffer.getvalue()


def until(condition: Callable[[], object], seconds: float) -> None:
    """Wait for something that must come about."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            message = "it did not come about"
            raise RuntimeError(message)
        time.sleep(0.01)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.jobs", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer jobs, kills and requests")
    print("\n".join(tables(measure(quick=parser.parse_args(arguments).quick))))


if __name__ == "__main__":
    main()
