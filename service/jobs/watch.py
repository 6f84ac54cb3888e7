"""Following jobs: one look at the database for all that anybody waits for."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass, field

import anyio

from service.errors import JobsUnavailable
from service.jobs.jobs import Jobs
from service.jobs.order import Job

__all__ = ["Watch"]

LOOK_SECONDS = 0.1


@dataclass(slots=True)
class _Followed:
    """A job that somebody follows; the event comes with its next change."""

    latest: Job | None = None
    changed: anyio.Event = field(default_factory=anyio.Event)
    followers: int = 0


class Watch:
    """Tells of changes of jobs.

    Parameters
    ----------
    jobs : Jobs
    """

    def __init__(self, jobs: Jobs) -> None:
        self._jobs = jobs
        self._followed: dict[str, _Followed] = {}
        self._wanted = anyio.Event()

    async def run(self) -> None:
        """Look again and again, for ever, while anybody follows anything."""
        while True:
            if not self._followed:
                self._wanted = anyio.Event()
                await self._wanted.wait()
            asked = dict(self._followed)  # others may come while we look
            try:
                found = {job.id: job for job in await self._jobs.look(list(asked))}
            except JobsUnavailable:
                await anyio.sleep(10 * LOOK_SECONDS)
                continue
            for name, one in asked.items():
                if found.get(name) != one.latest:
                    one.latest = found.get(name)
                    one.changed.set()
                    one.changed = anyio.Event()
            await anyio.sleep(LOOK_SECONDS)

    async def changes(self, job: Job) -> AsyncIterator[Job]:
        """Yield a job as it is, and again whenever it has changed, until it is final or gone."""
        one = self._followed.setdefault(job.id, _Followed(job))  # what others follow too may be older
        one.followers += 1
        self._wanted.set()
        seen = None
        try:
            while True:
                latest = one.latest
                if latest is None:
                    return
                if latest != seen:
                    seen = latest
                    yield latest
                if latest.final:
                    return
                if one.latest == seen:
                    await one.changed.wait()
        finally:
            one.followers -= 1
            if one.followers == 0:
                self._followed.pop(job.id, None)

    async def finished(self, job: Job, seconds: float) -> Job:
        """Wait for the end of a job, but no longer than so many seconds; return it as it is then."""
        latest = job
        with anyio.move_on_after(seconds):
            async for change in self.changes(job):
                latest = change
        return latest
