"""What HTTP adds to a reconstruction: the service on loopback against the same call in process."""

from __future__ import annotations

import io
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import httpx
import numpy as np
import orjson
from numpy.typing import NDArray

from core.methods import pca
from core.truth import point_set

__all__ = ["Overhead", "main", "measure", "tables"]

PATH = "/reconstruct/pca"
FAMILY = "s_shape"
START_SECONDS = 300.0  # the workers compile on a first start


@dataclass(frozen=True, slots=True)
class Overhead:
    """Median seconds of the same reconstruction, called and posted."""

    n: int
    call: float
    npy: float
    json: float
    loads: float

    @property
    def npy_ratio(self) -> float:
        """Posting an array, in units of the call in process."""
        return self.npy / self.call

    @property
    def json_loads(self) -> float:
        """What posting JSON adds to posting an array, in units of ``orjson.loads`` of the body."""
        return (self.json - self.npy) / self.loads


def measure(n: int = 100_000, repeats: int = 7, family: str = FAMILY) -> Overhead:
    """Start a service, post the same points as npy and as JSON, and call the function itself in turn."""
    points = point_set(family, n=n).points
    npy, text = _npy(points), orjson.dumps({"points": points}, option=orjson.OPT_SERIALIZE_NUMPY)
    times = np.empty((repeats, 4))
    with _service() as address, httpx.Client(base_url=address, timeout=START_SECONDS) as client:
        _warm_up(client, points, npy, text)
        for row in times:
            row[0] = _seconds(lambda: pca(points))
            row[1] = _seconds(lambda: _post(client, npy, "application/x-npy"))
            row[2] = _seconds(lambda: _post(client, text, "application/json"))
            row[3] = _seconds(lambda: orjson.loads(text))
    return Overhead(n, *(float(one) for one in np.median(times, axis=0)))


def _warm_up(client: httpx.Client, points: NDArray[np.float64], npy: bytes, text: bytes) -> None:
    for _ in range(2):  # every worker, when there are two
        pca(points)
        _post(client, npy, "application/x-npy")
        _post(client, text, "application/json")


def _post(client: httpx.Client, body: bytes, media_type: str) -> bytes:
    return client.post(PATH, content=body, headers={"content-type": media_type}).raise_for_status().content


def _npy(points: NDArray[np.float64]) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, points)
    return buffer.getvalue()


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


@contextmanager
def _service() -> Iterator[str]:
    """Run the service in a process of its own, on a free port of the loopback interface."""
    port = _free_port()
    command = [sys.executable, "-m", "uvicorn", "service.app:create_app", "--factory", "--port", str(port)]
    with tempfile.TemporaryDirectory() as directory:
        environment = {**os.environ, "TAPELINE_DATA_DIR": directory, "TAPELINE_LOG_LEVEL": "warning"}
        with subprocess.Popen([*command, "--log-level", "warning"], env=environment) as server:  # noqa: S603 - ourselves
            try:
                address = f"http://127.0.0.1:{port}"
                _wait(address, server)
                yield address
            finally:
                server.terminate()


def _wait(address: str, server: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline and server.poll() is None:
        try:
            if httpx.get(f"{address}/readyz").status_code == httpx.codes.OK:
                return
        except httpx.TransportError:
            pass  # not listening yet
        time.sleep(0.1)
    message = "the service did not become ready"
    raise RuntimeError(message)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def tables(row: Overhead) -> list[str]:
    """Return a markdown table."""
    return [
        "| N | call in process | POST npy | / call | POST JSON | orjson.loads | (JSON - npy) / loads |",
        "|---|---|---|---|---|---|---|",
        f"| {row.n:,} | {1e3 * row.call:.0f} ms | {1e3 * row.npy:.0f} ms | {row.npy_ratio:.2f} "
        f"| {1e3 * row.json:.0f} ms | {1e3 * row.loads:.0f} ms | {row.json_loads:.2f} |",
    ]


def main(_arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    print("\n".join(tables(measure())))


if __name__ == "__main__":
    main()
