"""The web process's hold on one worker process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Any, Self

import anyio
from anyio.abc import ByteReceiveStream, ByteSendStream, Process
from anyio.streams.buffered import BufferedByteReceiveStream

from service.errors import TaskFailed, WorkerLost
from service.work import frames

__all__ = ["Worker"]

_THREADS = ("OMP", "OPENBLAS", "MKL", "VECLIB", "NUMEXPR", "BLIS")


class Worker:
    """A worker process, which takes one call at a time.

    A call that is cancelled, or whose process dies, ends the process: nobody
    knows then how much of an answer is still in the pipe.
    """

    def __init__(self, process: Process, requests: ByteSendStream, answers: ByteReceiveStream) -> None:
        self._process = process
        self._requests = requests
        self._answers = BufferedByteReceiveStream(answers)
        self._killed = False

    @classmethod
    @asynccontextmanager
    async def start(cls, environment: Mapping[str, str]) -> AsyncIterator[Self]:
        """Start a process, and end it with the block."""
        # Were the start itself cancelled, nobody would know of the process that it has made.
        with anyio.CancelScope(shield=True):
            process = await anyio.open_process(
                [sys.executable, "-P", "-m", "service.work.child", str(os.getpid())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=None,  # the server's own: its log
                env=_environment(environment),
            )
        assert process.stdin is not None  # noqa: S101 # both are pipes, as ordered above
        assert process.stdout is not None  # noqa: S101
        worker = cls(process, process.stdin, process.stdout)
        try:
            yield worker
        finally:
            worker.kill()
            with anyio.CancelScope(shield=True):
                await process.aclose()

    @property
    def alive(self) -> bool:
        """Whether the process has not been ended, as far as is known."""
        return not self._killed and self._process.returncode is None

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    async def call(self, seconds: float, function: str, *arguments: object) -> Any:
        """Call ``module:name`` with arguments in the process and return what it returns.

        The process ends itself a little after ``seconds``, should nobody have done so by then.

        Raises
        ------
        WorkerLost
            When the process died.
        TaskFailed
            When the function raised.
        """
        request = frames.dump((max(seconds, 0.0), function, arguments))
        try:
            await self._requests.send(request)
            (length,) = frames.HEADER.unpack(await self._answers.receive_exactly(frames.HEADER.size))
            answer = frames.load(await self._answers.receive_exactly(length))
        except (anyio.BrokenResourceError, anyio.ClosedResourceError, anyio.IncompleteRead) as error:
            self.kill()
            message = "the process that computed the answer ended; try again later, or send fewer points"
            raise WorkerLost(message, retry_after=1) from error
        except BaseException:
            self.kill()
            raise
        if isinstance(answer, frames.Failure):
            raise TaskFailed(answer.text)
        return answer

    async def ended(self) -> str:
        """Wait until the process has ended, and say how."""
        code = await self._process.wait()
        return signal.Signals(-code).name if code < 0 else f"exit code {code}"

    def kill(self) -> None:
        """End the process at once."""
        self._killed = True
        with suppress(ProcessLookupError):
            self._process.kill()


def _environment(extra: Mapping[str, str]) -> dict[str, str]:
    """One thread a worker: the pool has a worker for each core already."""
    limits = {f"{name}_NUM_THREADS": "1" for name in _THREADS} | {"VECLIB_MAXIMUM_THREADS": "1"}
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)  # noqa: PTH109 # sys.path has text
    return {**os.environ, **limits, "NUMBA_NUM_THREADS": "1", "PYTHONPATH": path, **extra}
