"""The worker process: takes calls from its pipe, one at a time, until the pipe ends.

It ends with its parent in every case: at the end of the pipe when it waits; by
a thread that watches the parent's process id when it computes; and at the latest
by the alarm of the call, which no compiled loop can hold up.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

from service.work import frames

__all__ = ["main"]

WATCH_SECONDS = 0.5
ALARM_GRACE_SECONDS = 2.0  # the parent's own deadline comes first and is the one that a client sees


def main(parent: int) -> None:
    """Serve calls until the pipe ends."""
    requests, answers = _take_pipes()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    faulthandler.enable()
    _volunteer_for_the_oom_killer()
    threading.Thread(target=_follow, args=(parent,), daemon=True, name="follow-parent").start()
    with suppress(EOFError, BrokenPipeError):
        while True:
            seconds, function, arguments = frames.read(requests)
            signal.setitimer(signal.ITIMER_REAL, seconds + ALARM_GRACE_SECONDS)
            answer = _call(function, arguments)
            signal.setitimer(signal.ITIMER_REAL, 0)
            frames.write(answers, answer)
    os._exit(0)  # nothing to flush, and no finaliser of a library may hold us up


def _take_pipes() -> tuple[BinaryIO, BinaryIO]:
    """Keep the two pipes to ourselves: what a library prints goes to the server's log instead."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return requests, answers


def _call(function: str, arguments: tuple[Any, ...]) -> object:
    try:
        return _resolve(function)(*arguments)
    except Exception:
        return frames.Failure(traceback.format_exc())


def _resolve(function: str) -> Callable[..., object]:
    module, _, name = function.partition(":")
    found: Callable[..., object] = getattr(import_module(module), name)
    return found


def _follow(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(WATCH_SECONDS)
    os._exit(1)


def _volunteer_for_the_oom_killer() -> None:
    """When memory runs out, a worker dies and not the web process: one request is lost, not all."""
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")


if __name__ == "__main__":
    main(int(sys.argv[1]))
