from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

import httpx
import pytest

HERE = Path(__file__).parent
Server = tuple[str, subprocess.Popen[bytes]]
Serve = Callable[..., AbstractContextManager[Server]]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _wait_until_ready(url: str, process: subprocess.Popen[bytes], log: Path) -> None:
    end = time.monotonic() + 300  # compiling every kernel on a slow machine
    while time.monotonic() < end and process.poll() is None:
        try:
            if httpx.get(f"{url}/readyz").status_code == 200:
                return
        except httpx.TransportError:
            pass
        time.sleep(0.05)
    pytest.fail(f"the server did not become ready:\n{log.read_text()}")


@contextmanager
def _serve(directory: Path, *arguments: str, ready: bool = True, **settings: object) -> Iterator[Server]:
    """Run a server of its own on loopback, with settings by their names in lower case."""
    port = _free_port()
    given = {"port": port, "workers": 2, "job_workers": 0, "data_dir": directory / f"data-{port}", **settings}
    environment = {f"TAPELINE_{name.upper()}": str(value) for name, value in given.items()}
    path = os.pathsep.join([str(HERE), str(HERE.parents[1])])
    log = directory / f"{port}.log"
    with log.open("wb") as stderr:
        process = subprocess.Popen(  # noqa: S603 # our own server
            [sys.executable, "-W", "error", HERE / "server.py", *arguments],
            env={**os.environ, **environment, "PYTHONPATH": path},
            cwd=directory,
            stderr=stderr,
        )
        url = f"http://127.0.0.1:{port}"
        try:
            if ready:
                _wait_until_ready(url, process, log)
            yield url, process
        finally:
            process.terminate()
            process.wait(20)


@pytest.fixture(scope="session")
def serve(tmp_path_factory: pytest.TempPathFactory) -> Serve:
    """Return the function that starts servers; their logs are in the ``directory`` of the tests."""
    directory = tmp_path_factory.mktemp("server")

    def start(*arguments: str, ready: bool = True, **settings: object) -> AbstractContextManager[Server]:
        return _serve(directory, *arguments, ready=ready, **settings)

    return start


@pytest.fixture(scope="session")
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture(scope="session")
def url(serve: Serve, stack: ExitStack) -> str:
    """Address of a server with the real processes, and the one for the tests."""
    address, _ = stack.enter_context(
        serve("all", max_points=20_000, max_bytes=2_000_000, cors_origins="https://pages.example")
    )
    return address


@pytest.fixture(scope="session")
def client(url: str, stack: ExitStack) -> httpx.Client:
    return stack.enter_context(httpx.Client(base_url=url, timeout=60))
