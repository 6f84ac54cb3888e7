"""The process that computations are forked from, and their first steps.

Imported by the fork server, which so becomes warm: it has one thread only, for
what has several cannot be forked safely.
"""

from __future__ import annotations

import ctypes
import faulthandler
import gc
import logging
import multiprocessing
import os
import resource
import signal
import sys
import threading
import traceback
from contextlib import suppress
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

__all__ = ["NICENESS", "ONE_THREAD", "TABLE", "enter", "ready", "resolve"]

TABLE = "TAPELINE_PROCESS_TABLE"
"""Variable by which the fork server learns what to warm up."""
NICENESS = 5
"""Long work steps back where somebody waits for an answer."""
ONE_THREAD = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "VECLIB", "NUMEXPR", "BLIS", "NUMBA")
}

_PR_SET_PDEATHSIG = 1
_BETWEEN_REPORTS = 0.2  # seconds
_log = logging.getLogger("service.jobs")


def resolve(path: str) -> Any:
    """Import what ``module:name`` names."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


def ready(*, progress: object) -> bool:
    """Tell that a process forked from the warm one runs."""
    return progress is not None


def enter(answers: Connection, function: str, arguments: tuple[object, ...], memory: int) -> None:
    """Begin a computation: the whole life of a forked process."""
    _follow_parents()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the worker's to handle
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    faulthandler.enable()
    _step_back(memory)
    progress = _Progress(answers)
    try:
        answer: tuple[str, object] = "answer", resolve(function)(*arguments, progress=progress)
    except BaseException:
        answer = "failure", traceback.format_exc()
    progress.close()
    with suppress(OSError):
        answers.send(answer)
    os._exit(0)  # no finaliser of a library may hold us up


class _Progress:
    """Sends on how far the work is, several times a second at most."""

    def __init__(self, answers: Connection) -> None:
        self._answers = answers
        self._latest: tuple[float, str] | None = None
        self._over = threading.Event()
        self._sender = threading.Thread(target=self._send, daemon=True, name="progress")
        self._sender.start()

    def __call__(self, fraction: float, message: str) -> None:
        self._latest = fraction, message

    def _send(self) -> None:
        sent = None
        while not self._over.wait(_BETWEEN_REPORTS):
            latest = self._latest
            if latest != sent:
                sent = latest
                with suppress(OSError):  # the worker has just died, and we are about to
                    self._answers.send(("progress", *latest))  # type: ignore[misc]

    def close(self) -> None:
        self._over.set()
        self._sender.join()


def _follow_parents() -> None:
    """End with the worker, in every case."""
    _end_with_parent()
    parent = multiprocessing.parent_process()  # the worker itself, for where there is no such call
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True, name="follow-parent").start()


def _end_with_parent() -> None:
    """Let the kernel end us with our parent, also in the middle of a compiled loop (Linux).

    It is the thread that began us which counts: the fork server is begun by a worker's main thread.
    """
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)


def _step_back(memory: int) -> None:
    """Take a little less of everything than those who wait for us."""
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")
    if sys.platform == "linux":  # elsewhere the limit is not kept
        limit = _data_bytes() + memory
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))


def _data_bytes() -> int:
    """Bytes of memory that the warm process brought along."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData:"):
            return int(line.split()[1]) * 1024
    return 0


def _warm_up() -> None:
    """Import and compile, in the fork server only."""
    _end_with_parent()
    os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    table = resolve(os.environ[TABLE])
    try:
        resolve("service.work.tasks:warm")(table)
    except Exception:  # computations will say what is wrong, each for itself
        _log.exception("the processes could not be warmed up")
    gc.collect()
    gc.freeze()  # what is shared stays shared: the collector does not touch it in the forked ones


def _is_fork_server() -> bool:
    return TABLE in os.environ and "multiprocessing.forkserver" in " ".join(sys.orig_argv)


if _is_fork_server():
    _warm_up()
