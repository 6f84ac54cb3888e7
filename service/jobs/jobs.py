"""Jobs as the web process sees them: ordered, followed, listed, dismissed; computed elsewhere.

Every call to the database happens in a thread, so that none holds up the event loop.
"""

from __future__ import annotations

import logging
import re
import sqlite3
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from typing import Any, TypeVar

import sqlalchemy as sa
from anyio import to_thread
from dbos import WorkflowStatus
from dbos import error as engine_errors

from service.errors import JobsUnavailable, KeyReused, NoSuchJob, QueueFull
from service.jobs import engine
from service.jobs.expiry import Expiry
from service.jobs.order import Job, Order, State, engine_states
from service.jobs.perform import input_folder, job_folder
from service.settings import Settings
from service.store import Store
from service.work.body import Body

__all__ = ["Jobs", "Page"]

T = TypeVar("T")
_log = logging.getLogger("service.jobs")

_KEYS = uuid.UUID("6f6e8b0b-54a8-4c0e-9d3a-6f0c8bb0d5b1")
"""Name space of the jobs that clients have named by a key of their own."""
_COUNT_SECONDS = 0.5
_RETRY_SECONDS = 5
_SECONDS_PER_MEGABYTE = 4.0
_LONGEST_PENALTY = 600.0
_NAME = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
"""Of all jobs: no database need see what clients put in its place."""
_TIME = re.compile(r"[0-9]{10,14}")
_ERA = 1_577_836_800  # 2020-01-01: priorities must fit into 31 bits


@dataclass(frozen=True, slots=True)
class Page:
    """Some jobs, the latest first, and what to ask for the next with (None: there are no more)."""

    jobs: list[Job]
    cursor: str | None


class Jobs:
    """All jobs of this service.

    Parameters
    ----------
    settings : Settings
        With addresses of database and store.
    processes : iterable of str
        The ids of the processes.
    """

    def __init__(self, settings: Settings, processes: list[str]) -> None:
        assert settings.database_url is not None  # noqa: S101 # the caller has placed them
        assert settings.store_url is not None  # noqa: S101
        self._database = settings.database_url
        self._most = settings.job_queue_length
        self._client = engine.connect(self._database)
        self.store_url = settings.store_url
        self.store = Store(settings.store_url)
        self._expiry = Expiry(self._client, self.store, settings.keep_seconds, settings.keep_bytes)
        self._workflows = {engine.workflow(process): process for process in processes}
        self._prepared = False
        self._counted = 0.0
        self._waiting = 0

    async def order(self, order: Order, body: Body, key: str | None = None) -> Job:
        """Take an order; the same key and body give the same job.

        Raises
        ------
        QueueFull
            When as many jobs wait as may wait.
        KeyReused
            When the key came with another request before.
        JobsUnavailable
            When the database cannot be reached.
        """
        return await self._in_thread(partial(self._order, order, body, key))

    def _order(self, order: Order, body: Body, key: str | None) -> Job:
        job = str(uuid.uuid4() if key is None else uuid.uuid5(_KEYS, key))
        known = self._known(job) if key is not None else None
        if known is None:
            self._require_room()
            name = f"{input_folder(job)}/{uuid.uuid4().hex}.body"
            if body.path is None:
                self.store.write(name, body.content)
            else:
                self.store.take(name, body.path)
            with suppress(engine_errors.DBOSConflictingWorkflowError):  # the key is another process's
                self._enqueue(job, order.model_copy(update={"body": name}), body)
            known = self._known(job)  # another request with the same key may have been quicker
        if known is None:
            raise JobsUnavailable("the job was not taken; try again later", _RETRY_SECONDS)
        if key is not None and known.digest != body.digest:
            detail = "this Idempotency-Key came with another request before; take a new one for a new request"
            raise KeyReused(detail)
        return known

    def _enqueue(self, job: str, order: Order, body: Body) -> None:
        told: dict[str, Any] = {"process": order.process, "digest": body.digest, "created": engine.now()}
        if order.envelope is not None:
            told["enveloped"] = True
        self._client.enqueue(
            {
                "workflow_name": engine.workflow(order.process),
                "queue_name": engine.JOBS,
                "workflow_id": job,
                "priority": _priority(body.size),
                "attributes": told,
            },
            order.model_dump(mode="json"),
        )
        self._waiting += 1

    def _require_room(self) -> None:
        """Refuse when the queue is full; counted now and then, for a full queue takes long to count."""
        if time.monotonic() - self._counted > _COUNT_SECONDS:
            rows = self._client.list_queued_workflows(
                queue_name=engine.JOBS, status="ENQUEUED", limit=self._most + 1, load_input=False
            )
            self._waiting, self._counted = len(rows), time.monotonic()
        if self._waiting >= self._most:
            raise QueueFull("as many jobs wait as may wait; try again later", _RETRY_SECONDS)

    async def find(self, job: str) -> Job:
        """Return a job.

        Raises
        ------
        NoSuchJob
            When there is none of this name, or none any more.
        """
        found = await self.look([job]) if _NAME.fullmatch(job) else []
        if not found:
            raise NoSuchJob("there is no such job; finished jobs are kept for a while only")
        return found[0]

    async def look(self, jobs: list[str]) -> list[Job]:
        """Return those of some jobs that there are."""
        return await self._in_thread(lambda: [Job.of(row) for row in self._rows(jobs)])

    def _rows(self, jobs: list[str]) -> list[WorkflowStatus]:
        rows = self._client.list_workflows(workflow_ids=jobs, load_input=False)
        return [row for row in rows if row.name in self._workflows]

    def _known(self, job: str) -> Job | None:
        return next((Job.of(row) for row in self._rows([job])), None)

    async def page(self, states: list[State], processes: list[str], limit: int, cursor: str | None) -> Page:
        """List jobs, the latest first.

        Raises
        ------
        ValueError
            For a cursor that is none of ours.
        """
        return await self._in_thread(partial(self._list, states, processes, limit, cursor))

    def _list(self, states: list[State], processes: list[str], limit: int, cursor: str | None) -> Page:
        last = _read_cursor(cursor)
        names = [name for name, process in self._workflows.items() if not processes or process in processes]
        ask = partial(
            self._client.list_workflows,
            status=[name for state in states for name in engine_states(state)] or None,
            name=names or ["none"],
            sort_desc=True,
            load_input=False,
        )
        rows: list[WorkflowStatus] = []
        if last is not None:
            rows = [row for row in _of_moment(ask, last[0]) if _place(row) < last]
        if len(rows) <= limit:
            more = ask(end_time=None if last is None else _text(last[0] - 1), limit=limit + 1)
            if len(more) > limit:  # the last moment may not be whole
                moment = more[-1].created_at or 0
                more = [row for row in more if row.created_at != moment] + _of_moment(ask, moment)
            rows += more
        rows.sort(key=_place, reverse=True)
        found = [Job.of(row) for row in rows[:limit]]
        return Page(found, _cursor(rows[limit - 1]) if len(rows) > limit else None)

    async def dismiss(self, job: str) -> Job:
        """End a job; what it has left is removed.

        Raises
        ------
        NoSuchJob
            When there is none of this name.
        """
        found = await self.find(job)
        if not found.final:
            await self._in_thread(lambda: self._client.cancel_workflow(job, cancel_children=True))
            found = await self.find(job)  # it may have been finished meanwhile
        if found.state == "dismissed":
            await self._in_thread(lambda: self.store.remove(job_folder(job)))
            return found
        await self._in_thread(lambda: self._expiry.remove([job]))
        return _dismissed(found)

    async def _in_thread(self, call: Callable[[], T]) -> T:
        try:
            return await to_thread.run_sync(lambda: self._prepared_call(call))
        except (sa.exc.SQLAlchemyError, sqlite3.Error, engine_errors.DBOSException, OSError) as error:
            _log.error("jobs: %s", str(error).partition("\n")[0])
            detail = "jobs cannot be kept now; try again later, or send less at a time"
            raise JobsUnavailable(detail, _RETRY_SECONDS) from error

    def _prepared_call(self, call: Callable[[], T]) -> T:
        if not self._prepared:
            engine.prepare(self._database)
            self._prepared = True
        return call()

    def close(self) -> None:
        """Close the connections."""
        self._client.destroy()


def _dismissed(job: Job) -> Job:
    now = datetime.now(UTC)
    return replace(job, state="dismissed", message="dismissed", finished=now, updated=now, outcome={})


def _priority(size: int) -> int:
    """Order the queue by when a job should be done: large ones later, but none waits for ever.

    The number is a time in seconds; the least is served first.
    """
    penalty = min(_SECONDS_PER_MEGABYTE * size / 1e6, _LONGEST_PENALTY)
    return int(time.time() - _ERA + penalty)


Place = tuple[int, int, str]
"""Of a job among all: when the database took it, when we did, and its name.

The clock of SQLite counts in seconds: many jobs may have come at one moment.
"""


def _place(row: WorkflowStatus) -> Place:
    return row.created_at or 0, (row.attributes or {}).get("created", 0), row.workflow_id


def _of_moment(ask: Callable[..., list[WorkflowStatus]], moment: int) -> list[WorkflowStatus]:
    return ask(start_time=_text(moment), end_time=_text(moment))


def _text(milliseconds: int) -> str:
    return datetime.fromtimestamp(milliseconds / 1000, UTC).isoformat()


def _cursor(row: WorkflowStatus) -> str:
    return "{}.{}.{}".format(*_place(row))


def _read_cursor(cursor: str | None) -> Place | None:
    """Read the place of the last job of the page before."""
    if cursor is None:
        return None
    taken, created, job = [*cursor.split(".", 2), "", ""][:3]
    if not (_TIME.fullmatch(taken) and _TIME.fullmatch(created)):
        raise ValueError("the cursor is none of ours")
    return int(taken), int(created), job
