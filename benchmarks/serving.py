"""A service in processes of its own, with handles to end each of them."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import psutil
from fastapi import FastAPI

from service.app import create_app

__all__ = ["Service", "app", "serving"]

START_SECONDS = 300.0  # the workers compile on a first start
TABLE = "TAPELINE_BENCHMARK_TABLE"


class Service:
    """One service after the other on the same data and the same port.

    Parameters
    ----------
    directory : Path
        With database and store.
    table : str
        Import path of the table of processes.
    settings : object
        Settings by name.
    """

    def __init__(self, directory: Path, table: str, **settings: object) -> None:
        self._port = _free_port()
        self._table = table
        given = {"data_dir": directory, "port": self._port, "log_level": "error", **settings}
        self._settings = {f"TAPELINE_{name.upper()}": str(value) for name, value in given.items()}
        self.address = f"http://127.0.0.1:{self._port}"
        self.start()

    def start(self) -> None:
        """Start it, without waiting for anything."""
        environment = {**os.environ, **self._settings, TABLE: self._table}
        command = [sys.executable, "-m", "uvicorn", "benchmarks.serving:app", "--factory"]
        command += ["--port", str(self._port), "--log-level", "error"]
        self._server = subprocess.Popen(command, env=environment)  # noqa: S603 # ourselves
        self.server = psutil.Process(self._server.pid)

    def wait(self) -> None:
        """Wait until it is warm."""
        end = time.monotonic() + START_SECONDS
        while time.monotonic() < end and self._server.poll() is None:
            try:
                if httpx.get(f"{self.address}/readyz").status_code == httpx.codes.OK:
                    return
            except httpx.TransportError:
                pass  # not listening yet
            time.sleep(0.05)
        message = "the service did not become ready"
        raise RuntimeError(message)

    @property
    def worker(self) -> psutil.Process | None:
        """The process that leads the computations of jobs, if there is one now."""
        try:
            return next((one for one in self.server.children() if "service.jobs" in one.cmdline()), None)
        except psutil.Error:
            return None

    @property
    def computations(self) -> list[psutil.Process]:
        """The processes that compute jobs now: those that another has been the pattern of."""
        worker = self.worker
        try:
            patterns = worker.children() if worker else []
            return [one for pattern in patterns for one in pattern.children()]
        except psutil.Error:
            return []

    def kill(self) -> None:
        """End it at once, in the middle of everything."""
        self._server.kill()
        self._server.wait()

    def stop(self) -> None:
        """Tell it to end."""
        self._server.send_signal(signal.SIGTERM)
        try:
            self._server.wait(20)
        except subprocess.TimeoutExpired:
            self.kill()


@contextmanager
def serving(table: str, **settings: object) -> Iterator[Service]:
    """Run a service on data of its own, warm."""
    with tempfile.TemporaryDirectory() as directory:
        service = Service(Path(directory), table, **settings)
        try:
            service.wait()
            yield service
        finally:
            service.stop()


def app() -> FastAPI:
    """Make the application of the table that the environment names."""
    return create_app(processes=os.environ[TABLE])


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
