"""Functions that the tests let workers call."""

from __future__ import annotations

import os
import time
from pathlib import Path


def add(a: int, b: int) -> int:
    return a + b


def pid() -> int:
    return os.getpid()


def environment(name: str) -> str | None:
    return os.environ.get(name)


def busy(seconds: float) -> int:
    """Compute for a while, never letting go of the interpreter for long."""
    end = time.monotonic() + seconds
    rounds = 0
    while time.monotonic() < end:
        rounds += 1
    return rounds


def die() -> None:
    os.kill(os.getpid(), 9)


def die_once(marker: str) -> str:
    """Die, but not a second time."""
    if Path(marker).exists():
        return "survived"
    Path(marker).touch()
    os.kill(os.getpid(), 9)
    return "unreachable"


def fail() -> None:
    raise LookupError("a defect")


def echo(content: bytes) -> bytes:
    return content


def chatter() -> str:
    print("printed by a library")  # noqa: T201 # that is what is tested
    os.write(1, b"written by a library\n")
    return "quiet"


def slow_start(log: str) -> None:
    """Warm up: leave a trace with the time."""
    with Path(log).open("a") as file:
        file.write(f"{os.getpid()} {time.monotonic()}\n")


def never_starts() -> None:
    raise RuntimeError("cannot warm up")
