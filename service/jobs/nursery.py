"""One killable process for each computation, born warm.

A process that has imported and compiled everything is forked for each
computation (``multiprocessing``'s fork server): that costs milliseconds, gives
each computation limits of its own, and gives back all of its memory. Nothing
but the end of its process stops a compiled loop.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerProcess
from typing import Any

from service.jobs import cradle

__all__ = ["Ended", "Limits", "Nursery"]

WARM_UP_SECONDS = 600.0  # compiling every kernel on a slow machine

Report = Callable[[float, str], None]


@dataclass(frozen=True, slots=True)
class Limits:
    """What one computation may take."""

    seconds: float
    memory: int


class Ended(Exception):
    """The process ended before it had an answer.

    ``late`` when its time was up, ``killed`` when we were told to, ``by_force`` when somebody else did so
    (the system, when memory is short), else by itself (a crash).
    """

    def __init__(
        self, reason: str, *, late: bool = False, killed: bool = False, by_force: bool = False
    ) -> None:
        super().__init__(reason)
        self.late = late
        self.killed = killed
        self.by_force = by_force


class Nursery:
    """Processes by the name of what they compute.

    Parameters
    ----------
    table : str
        Import path of the table of processes, which is warmed up once.
    limits : Limits
    """

    def __init__(self, table: str, limits: Limits) -> None:
        os.environ[cradle.TABLE] = table
        os.environ.update(cradle.ONE_THREAD)
        self._context = get_context("forkserver")
        self._context.set_forkserver_preload([cradle.__name__])
        self._limits = limits
        self._lock = threading.Lock()
        self._running: dict[str, ForkServerProcess] = {}
        self._killed: set[ForkServerProcess] = set()

    def warm(self) -> None:
        """Wait until the process that the others are forked from has compiled everything."""
        self.run("warm", "service.jobs.cradle:ready", (), lambda _fraction, _message: None, WARM_UP_SECONDS)

    @property
    def names(self) -> list[str]:
        """What is being computed now."""
        with self._lock:
            return [name for name in self._running if name != "warm"]

    def run(
        self,
        name: str,
        function: str,
        arguments: tuple[object, ...],
        report: Report,
        seconds: float | None = None,
    ) -> Any:
        """Call ``module:name`` with arguments and ``progress=`` in a process of its own.

        It may take so many seconds, or those of the limits.

        Raises
        ------
        Ended
            When there is no answer.
        RuntimeError
            When the function raised; the message is the traceback.
        """
        ours, theirs = self._context.Pipe(duplex=False)
        process = self._context.Process(
            target=cradle.enter, args=(theirs, function, arguments, self._limits.memory), name=name
        )
        self.kill(name)  # an earlier one, which others had taken over and given back
        with self._lock:  # forks one after the other
            process.start()
            self._running[name] = process
        theirs.close()
        try:
            return self._attend(process, ours, report, seconds or self._limits.seconds)
        finally:
            process.kill()
            process.join()
            with self._lock:
                self._killed.discard(process)
                if self._running.get(name) is process:
                    del self._running[name]
            process.close()
            ours.close()

    def _attend(self, process: ForkServerProcess, ours: Connection, report: Report, seconds: float) -> Any:
        deadline = time.monotonic() + seconds
        while connection.wait([ours], max(deadline - time.monotonic(), 0.0)):
            try:
                kind, *told = ours.recv()
            except (EOFError, OSError):
                process.join()
                by_force = process.exitcode == -signal.SIGKILL
                raise Ended(
                    _how(process.exitcode), killed=process in self._killed, by_force=by_force
                ) from None
            if kind == "progress":
                report(*told)
            elif kind == "answer":
                return told[0]
            else:
                raise RuntimeError(told[0])
        raise Ended("its time was up", late=True)

    def kill(self, name: str) -> None:
        """End what computes this, if anything does."""
        with self._lock:
            process = self._running.get(name)
            if process is not None:
                self._killed.add(process)
                process.kill()


def _how(code: int | None) -> str:
    return signal.Signals(-code).name if code is not None and code < 0 else f"exit code {code}"
