"""Jobs by when they came and how long they took, as OGC API – Processes 1.0 (18-062r2 §12) lists them.

The database knows neither: jobs are looked at page by page, so many pages at
most. A page may then hold few jobs, or none, and yet lead on.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Self

from service.jobs.jobs import Jobs, Page
from service.jobs.order import Job, State

__all__ = ["Sieve", "sifted"]

_MOST_PAGES = 50
_OPEN = {"", ".."}
_SLACK = timedelta(minutes=1)
"""By how much the clock of the database, by which jobs are in order, may differ from ours."""


@dataclass(frozen=True, slots=True)
class Sieve:
    """Which jobs pass.

    Attributes
    ----------
    since, until : datetime or None
        Bounds of when a job was created, both included.
    least, most : float or None
        Bounds of how long it has computed, in seconds; what has not begun does not pass.
    """

    since: datetime | None = None
    until: datetime | None = None
    least: float | None = None
    most: float | None = None

    @classmethod
    def read(cls, interval: str | None, least: float | None, most: float | None) -> Self:
        """Read an instant or an interval: two of them with a slash between, ``..`` or nothing for open.

        >>> Sieve.read("2026-01-01T00:00:00Z/..", None, None).until is None
        True

        Raises
        ------
        ValueError
            For what is no date with a time and an offset (RFC 3339).
        """
        if interval is None:
            return cls(least=least, most=most)
        first, slash, second = interval.partition("/")
        if not slash:
            return cls(_instant(first), _instant(first), least, most)
        since = None if first in _OPEN else _instant(first)
        until = None if second in _OPEN else _instant(second)
        if since is None and until is None:
            raise ValueError("an interval has one end at least")
        return cls(since, until, least, most)

    def passes(self, job: Job) -> bool:
        """Tell whether a job passes."""
        if self.since is not None and job.created < self.since:
            return False
        if self.until is not None and job.created > self.until:
            return False
        if self.least is None and self.most is None:
            return True
        seconds = _seconds(job)
        if seconds is None:
            return False
        return (self.least is None or seconds >= self.least) and (self.most is None or seconds <= self.most)


def _instant(text: str) -> datetime:
    try:
        read = datetime.fromisoformat(text)
    except ValueError:
        read = datetime.min
    if read.tzinfo is None:
        raise ValueError("a date has a time and an offset, such as 2026-01-31T12:00:00Z")
    return read


def _seconds(job: Job) -> float | None:
    """Say how long a job has computed."""
    if job.started is None or (job.final and job.finished is None):
        return None
    end = job.finished or datetime.now(UTC)
    return (end - job.started).total_seconds()


async def sifted(
    jobs: Jobs, states: list[State], processes: list[str], limit: int, cursor: str | None, sieve: Sieve
) -> Page:
    """List the jobs that pass, the latest first.

    Raises
    ------
    ValueError
        For a cursor that is none of ours.
    """
    found: list[Job] = []
    for _ in range(_MOST_PAGES):
        page = await jobs.page(states, processes, limit - len(found), cursor)
        found += [job for job in page.jobs if sieve.passes(job)]
        cursor = page.cursor
        if cursor is None or len(found) == limit:
            break
        if sieve.since is not None and page.jobs[-1].created < sieve.since - _SLACK:
            return Page(found, None)  # those that follow are older still
    return Page(found, cursor)
