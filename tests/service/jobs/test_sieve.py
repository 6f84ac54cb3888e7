from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest

from service.jobs import Job, Sieve, State

NOON = datetime(2026, 1, 31, 12, tzinfo=UTC)


def job(state: State = "successful", started: bool = True, seconds: float = 10.0) -> Job:
    """Make a job created at noon that began at once."""
    begin = NOON if started else None
    end = NOON + timedelta(seconds=seconds) if state in {"successful", "failed", "dismissed"} else None
    return Job("1", "trial", state, "", 0, NOON, begin, end, NOON, "", {})


@pytest.mark.parametrize(
    ("interval", "passes"),
    [
        ("2026-01-31T12:00:00Z", True),
        ("2026-01-31T13:00:00+01:00", True),
        ("2026-01-31T12:00:01Z", False),
        ("2026-01-31T11:00:00Z/2026-01-31T13:00:00Z", True),
        ("2026-01-31T12:00:00Z/2026-01-31T12:00:00Z", True),
        ("2026-01-31T12:00:01Z/2026-01-31T13:00:00Z", False),
        ("2026-01-31T11:00:00Z/..", True),
        ("2026-01-31T11:00:00Z/", True),
        ("../2026-01-31T11:00:00Z", False),
        ("/2026-01-31T12:00:00Z", True),
    ],
)
def test_jobs_pass_by_when_they_were_created(interval: str, passes: bool) -> None:
    assert Sieve.read(interval, None, None).passes(job()) is passes


@pytest.mark.parametrize("interval", ["", "..", "../..", "/", "noon", "2026-01-31", "2026-01-31T12:00:00"])
def test_what_is_no_time_is_refused(interval: str) -> None:
    with pytest.raises(ValueError, match=r"one end at least|a time and an offset"):
        Sieve.read(interval, None, None)


@pytest.mark.parametrize(
    ("least", "most", "passes"),
    [
        (10, None, True),
        (10.5, None, False),
        (None, 10, True),
        (None, 9, False),
        (5, 15, True),
        (11, 15, False),
    ],
)
def test_jobs_pass_by_how_long_they_took(least: float | None, most: float | None, passes: bool) -> None:
    assert Sieve(least=least, most=most).passes(job()) is passes


def test_what_runs_has_taken_the_time_since_it_began_and_what_waits_none() -> None:
    assert Sieve(least=3600).passes(job("running"))
    assert not Sieve(most=3600).passes(job("running"))
    assert not Sieve(least=0).passes(job("accepted", started=False))
    assert not Sieve(least=0).passes(job("dismissed", started=False))
