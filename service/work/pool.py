"""A pool of warm worker processes with a bounded queue and a deadline for each call."""

from __future__ import annotations

import logging
import math
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import anyio
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

from service.errors import DeadlineExceeded, QueueFull, ServiceError, WorkerLost
from service.work.worker import Worker

__all__ = ["Pool", "PoolOptions", "open_pool"]

WARM_UP_SECONDS = 600.0  # compiling every kernel on a slow machine; seconds when they are in the cache
LONGEST_PAUSE_SECONDS = 30.0
_log = logging.getLogger("service.work")


@dataclass(frozen=True, slots=True)
class PoolOptions:
    """How many workers, how many calls may wait for them, and how long a call may take.

    ``warm_up`` is a function ``module:name`` with its arguments that every
    worker calls before it takes work; ``environment`` is added to the workers'.
    """

    workers: int
    queue_length: int
    deadline_seconds: float
    warm_up: tuple[str, tuple[object, ...]] | None = None
    environment: Mapping[str, str] = field(default_factory=dict)


class Pool:
    """Warm workers; get one from :func:`open_pool`."""

    def __init__(
        self,
        options: PoolOptions,
        free: MemoryObjectSendStream[Worker],
        idle: MemoryObjectReceiveStream[Worker],
    ) -> None:
        self._options = options
        self._free = free
        self._idle = idle
        self._warm = 0
        self._taking = 0  # counted here: the stream counts a call only after it has let others run
        self.first_warm = anyio.Event()
        self._mean_seconds = 1.0
        self.ready = False

    @property
    def warm(self) -> int:
        """Number of warm workers, busy or idle."""
        return self._warm

    @property
    def waiting(self) -> int:
        """Number of calls that wait for a worker."""
        return max(self._taking - self._idle.statistics().current_buffer_used, 0)

    async def run(
        self,
        function: str,
        *arguments: object,
        started: anyio.Event | None = None,
        seconds: float | None = None,
    ) -> Any:
        """Call ``module:name`` with arguments in a worker, for so many seconds at most.

        A call whose worker dies is tried once more on another one. A call that
        is cancelled, or that exceeds the deadline, ends its worker; before the
        event ``started`` is set it has none yet.

        Raises
        ------
        QueueFull
            When as many calls wait as may wait.
        DeadlineExceeded
            When waiting and computing took longer than is allowed.
        WorkerLost
            When both workers died.
        TaskFailed
            When the function raised.
        """
        if self._taking >= self._options.queue_length + self._idle.statistics().current_buffer_used:
            raise QueueFull("as many requests wait as may wait; try again later", self._retry_after())
        worker: Worker | None = None
        allowed = self._options.deadline_seconds
        deadline = anyio.current_time() + (allowed if seconds is None else min(seconds, allowed))
        with anyio.CancelScope(deadline=deadline):
            worker = await self._take()
            if started is not None:
                started.set()
            try:
                return await self._call(worker, deadline, function, arguments)
            except WorkerLost:
                _log.warning("worker %d died under a call; trying once more", worker.pid)
            worker = None
            worker = await self._take()
            return await self._call(worker, deadline, function, arguments)
        raise self._late(worker)

    async def _take(self) -> Worker:
        self._taking += 1
        try:
            worker = await self._idle.receive()
            while not worker.alive:  # it died while it waited
                worker = await self._idle.receive()
            return worker
        finally:
            self._taking -= 1

    async def _call(
        self, worker: Worker, deadline: float, function: str, arguments: tuple[object, ...]
    ) -> Any:
        start = anyio.current_time()
        try:
            return await worker.call(deadline - start, function, *arguments)
        finally:
            self._mean_seconds += 0.1 * (anyio.current_time() - start - self._mean_seconds)
            if worker.alive:
                self._free.send_nowait(worker)

    def _late(self, worker: Worker | None) -> DeadlineExceeded:
        allowed = f"{self._options.deadline_seconds:g} s"
        if worker is None:
            message = f"no worker became free within the {allowed} that are allowed; try again later"
            return DeadlineExceeded(message, self._retry_after())
        return DeadlineExceeded(
            f"the work took longer than the {allowed} that are allowed, and was stopped; send fewer points, "
            "or ask the operator of the service for a longer deadline"
        )

    def _retry_after(self) -> int:
        """Seconds until those who wait now should be done."""
        seconds = self._mean_seconds * (self.waiting + 1) / self._options.workers
        return math.ceil(min(max(seconds, 1.0), self._options.deadline_seconds + 1.0))

    async def keep(self, first: bool) -> None:
        """Keep one place of the pool filled with a warm worker, for ever.

        The first place goes first, so that only one worker compiles what the
        others then find in the cache.
        """
        if not first:
            await self.first_warm.wait()
        failures = 0
        while True:
            try:
                async with Worker.start(self._options.environment) as worker:
                    await self._warm_up(worker)
                    failures = 0
                    reason = await self._serve(worker)
                    _log.warning("worker %d ended (%s); starting another", worker.pid, reason)
            except (OSError, ServiceError, TimeoutError) as error:
                failures += 1
                _log.error("a worker did not start: %s", error)
                await anyio.sleep(min(2.0**failures / 10, LONGEST_PAUSE_SECONDS))

    async def _warm_up(self, worker: Worker) -> None:
        if self._options.warm_up is None:
            return
        function, arguments = self._options.warm_up
        with anyio.fail_after(WARM_UP_SECONDS):
            await worker.call(WARM_UP_SECONDS, function, *arguments)

    async def _serve(self, worker: Worker) -> str:
        """Let a warm worker take calls until its process ends."""
        self._warm += 1
        self.ready = self.ready or self._warm == self._options.workers
        self.first_warm.set()
        self._free.send_nowait(worker)
        try:
            return await worker.ended()
        finally:
            self._warm -= 1


@asynccontextmanager
async def open_pool(options: PoolOptions) -> AsyncIterator[Pool]:
    """Start a pool, which warms up while the block runs and ends with it."""
    free, idle = anyio.create_memory_object_stream[Worker](math.inf)
    with free, idle:
        pool = Pool(options, free, idle)
        async with anyio.create_task_group() as group:
            for place in range(options.workers):
                group.start_soon(pool.keep, place == 0)
            try:
                yield pool
            finally:
                group.cancel_scope.cancel()
