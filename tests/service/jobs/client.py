"""What a client does with jobs, and how to see what becomes of their processes."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import httpx
import psutil

POINTS = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.25]]
ASYNC = {"prefer": "respond-async"}
FINAL = ("successful", "failed", "dismissed")


def body(points: object = POINTS, **parameters: object) -> dict[str, object]:
    return {"points": points, "parameters": parameters}


def order(client: httpx.Client, headers: Mapping[str, str] = ASYNC, **parameters: object) -> httpx.Response:
    """Post a trial, to be computed as a job unless the headers say otherwise."""
    return client.post("/trial", json=body(**parameters), headers=dict(headers))


def ordered(client: httpx.Client, headers: Mapping[str, str] = ASYNC, **parameters: object) -> str:
    """Post a trial as a job, and return its address."""
    answer = order(client, headers, **parameters)
    assert answer.status_code == 201, answer.text
    return answer.headers["location"]


def begun(client: httpx.Client, directory: Path, **parameters: object) -> tuple[str, int]:
    """Post a trial as a job and wait until it computes; return its address and its process."""
    sign = directory / f"sign-{time.monotonic_ns()}"
    job = ordered(client, sign=str(sign), **parameters)
    until(lambda: signed(sign) != 0)
    return job, signed(sign)


def signed(sign: Path) -> int:
    """Return the process that has signed a file, or 0."""
    text = sign.read_text() if sign.exists() else ""
    return int(text or 0)


def info(client: httpx.Client, job: str) -> dict[str, Any]:
    answer = client.get(job)
    assert answer.status_code == 200, answer.text
    document: dict[str, Any] = answer.json()
    return document


def ended(client: httpx.Client, job: str, seconds: float = 60.0) -> dict[str, Any]:
    """Wait for the end of a job."""
    until(lambda: info(client, job)["status"] in FINAL, seconds)
    return info(client, job)


def changes(client: httpx.Client, job: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Follow a job: yield the events and what they tell, until the server ends the stream."""
    with client.stream("GET", f"{job}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        event = ""
        for line in stream.iter_lines():
            name, _, value = line.partition(": ")
            if name == "event":
                event = value
            elif name == "data":
                yield event, json.loads(value)


def lives(client: httpx.Client) -> bool:
    """Whether a service answers, be its workers warm or not."""
    try:
        return client.get("/healthz").status_code == 200
    except httpx.TransportError:
        return False


def until(condition: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.02)


def gone(process: int) -> bool:
    """Whether a process computes no more, be it that nobody has asked yet how it ended."""
    try:
        return psutil.Process(process).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def worker_of(server: int) -> int:
    """Return the process that computes the jobs of a server, once there is one."""
    found: list[int] = []
    until(lambda: found.extend(_workers(server)) or found)
    return found[0]


def _workers(server: int) -> list[int]:
    return [one.pid for one in psutil.Process(server).children() if "service.jobs" in _command(one)]


def _command(process: psutil.Process) -> list[str]:
    try:
        return process.cmdline()
    except psutil.Error:  # it has just ended
        return []
