"""A contestant's process as the benchmark sees it: requests with a limit of time."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.told import Answer, Told

__all__ = ["ENDED", "LATE", "Attempt", "Process"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LATE = "time limit"
ENDED = "process ended"
STARTING = 300.0  # seconds for imports and compiling, which are no part of any time
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA", "RAYON")}


@dataclass(frozen=True, slots=True)
class Attempt:
    """One setting of a contestant on one point set; ``answer`` is None where there is a ``problem``."""

    number: int
    setting: str
    seconds: float
    answer: Answer | None
    problem: str = ""


@dataclass(slots=True)
class Process:
    """A worker that is started when needed, and again after it had to be killed."""

    command: list[str]
    limit: float
    folder: Path
    warm_up: tuple[Floats, Ints, Told] | None = None
    starting: float = STARTING
    _running: subprocess.Popen[str] | None = None
    _lines: queue.Queue[str | None] = field(default_factory=queue.Queue)

    def ask(self, points: Floats, curve_of: Ints, told: Told, only: list[int] | None = None) -> list[Attempt]:
        """Run all settings, or ``only`` those; settings after one that took too long are not tried."""
        if self._running is None:
            self._start()
        if self._running is None:
            return [Attempt(-1, "start", 0.0, None, "does not start")]
        return self._ask(points, curve_of, told, only, self.limit)

    def stop(self) -> None:
        """End the worker, and what it may have started."""
        if self._running is not None:
            os.killpg(self._running.pid, 9)
            self._running.communicate()
            self._running = None

    def _start(self) -> None:
        self._lines = queue.Queue()
        self._running = subprocess.Popen(  # noqa: S603 - our own worker
            self.command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=self.folder,
            env=os.environ | ONE_THREAD,
            start_new_session=True,
        )
        threading.Thread(target=_pump, args=(self._running.stdout, self._lines), daemon=True).start()
        if self.warm_up is not None:
            self._ask(*self.warm_up, None, self.starting)

    def _ask(
        self, points: Floats, curve_of: Ints, told: Told, only: list[int] | None, limit: float
    ) -> list[Attempt]:
        attempts: list[Attempt] = []
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "points.npz"
            np.savez(file, points=points, curve_of=curve_of)
            self._send({"file": str(file), "told": told.as_json(), "only": only})
            words, number = "start", -1
            while True:
                line = self._next(limit if number >= 0 else max(limit, self.starting))
                if line is None or "ended" in line:
                    problem = LATE if line is None else ENDED
                    attempts.append(Attempt(number, words, limit, None, problem))
                    self.stop()
                    return attempts
                if "finished" in line:
                    return attempts
                if "started" in line:
                    words, number = line["setting"], line["started"]
                else:
                    answer = None if line["problem"] else _load(Path(line["file"]))
                    attempts.append(Attempt(number, words, line["seconds"], answer, line["problem"]))

    def _send(self, request: dict[str, Any]) -> None:
        assert self._running is not None  # noqa: S101 - started before
        assert self._running.stdin is not None  # noqa: S101 - a pipe
        try:
            self._running.stdin.write(json.dumps(request) + "\n")
            self._running.stdin.flush()
        except BrokenPipeError:
            pass  # the answer will be that there is none

    def _next(self, limit: float) -> dict[str, Any] | None:
        """Return the next line; None when it takes too long."""
        try:
            line = self._lines.get(timeout=limit)
        except queue.Empty:
            return None
        return {"ended": True} if line is None else dict(json.loads(line))


def _pump(source: IO[str] | None, lines: queue.Queue[str | None]) -> None:
    for line in source or ():
        lines.put(line)
    lines.put(None)


def _load(file: Path) -> Answer:
    with np.load(file) as known:
        if "edges" in known:
            return Answer(vertices=known["vertices"], edges=known["edges"])
        flags = known["closed"]
        return Answer(curves=[(known[f"line_{k}"], bool(one)) for k, one in enumerate(flags)])
