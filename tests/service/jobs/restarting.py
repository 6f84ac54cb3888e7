"""A service that the tests end in every way and start again where it was."""

from __future__ import annotations

import signal
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

import httpx
import psutil
from conftest import Serve

from jobs.client import ended, gone, ordered, until, worker_of


class Service:
    """One service after the other on the same data.

    Parameters
    ----------
    serve : Serve
    directory : Path
        With database and store.
    settings : object
        Settings by name.
    """

    def __init__(self, serve: Serve, directory: Path, **settings: object) -> None:
        self._serve = serve
        self._settings = {"data_dir": directory, "workers": 1, "job_workers": 2, **settings}
        self._stack = ExitStack()
        self.start()

    def start(self) -> None:
        url, process = self._stack.enter_context(self._serve(**self._settings))
        self.client = self._stack.enter_context(httpx.Client(base_url=url, timeout=60))
        self.pid = process.pid
        self._process = process

    @property
    def worker(self) -> int:
        """The process that computes its jobs."""
        return worker_of(self.pid)

    def warm(self) -> None:
        """Wait until jobs are computed."""
        ended(self.client, ordered(self.client))

    def end(self, number: signal.Signals = signal.SIGKILL) -> None:
        """End the service, and see that nothing of it goes on."""
        left = [one.pid for one in psutil.Process(self.pid).children(recursive=True)]
        self._process.send_signal(number)
        self._process.wait(20)
        until(lambda: all(map(gone, left)))

    def __enter__(self) -> Service:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()
