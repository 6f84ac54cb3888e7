"""What a job is: the order that a client gave, and where it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict

if TYPE_CHECKING:
    from dbos import WorkflowStatus

__all__ = ["FINAL", "STATES", "Job", "Order", "State", "engine_states"]

State = Literal["accepted", "running", "successful", "failed", "dismissed"]
STATES: tuple[State, ...] = get_args(State)
FINAL: frozenset[State] = frozenset(("successful", "failed", "dismissed"))

_STATES: dict[str, State] = {
    "DELAYED": "accepted",
    "ENQUEUED": "accepted",
    "PENDING": "running",
    "SUCCESS": "successful",
    "ERROR": "failed",
    "MAX_RECOVERY_ATTEMPTS_EXCEEDED": "failed",
    "CANCELLED": "dismissed",
}
"""What the engine says → what OGC API – Processes says."""


class Order(BaseModel):
    """A request for a process, as it came; the body lies in the store under ``body``.

    Small enough for the database: nothing in it grows with the number of points.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    process: str
    body: str
    content_type: str | None
    content_encoding: str | None
    query: tuple[tuple[str, str], ...]
    form: str
    envelope: str | None
    decided: bool = True
    max_points: int
    max_bytes: int


@dataclass(frozen=True, slots=True)
class Job:
    """A job as the database has it; times are in UTC.

    Attributes
    ----------
    progress : int
        Percent.
    digest : str
        Of everything that the client sent, where a key came with it.
    outcome : mapping
        What the computation left: ``run``, the folder of its results, or ``problem``.
    enveloped : bool
        Whether it was ordered by an execute request of OGC API – Processes.
    """

    id: str
    process: str
    state: State
    message: str
    progress: int
    created: datetime
    started: datetime | None
    finished: datetime | None
    updated: datetime
    digest: str
    outcome: Mapping[str, Any]
    enveloped: bool = False

    @property
    def final(self) -> bool:
        """Whether nothing will change any more."""
        return self.state in FINAL

    @classmethod
    def of(cls, row: WorkflowStatus) -> Job:
        """Read what the engine says of a job."""
        told: dict[str, Any] = row.attributes or {}
        state = _STATES[row.status]
        created = _time(told.get("created")) or datetime.now(UTC)
        started = _time(told.get("started"))
        outcome = _outcome(state, row)
        finished = _time(outcome.get("finished") or row.completed_at) if state in FINAL else None
        return cls(
            id=row.workflow_id,
            process=told.get("process", ""),
            state=state,
            message=_message(state, told, row),
            progress=100 if state == "successful" else int(told.get("progress", 0)),
            created=created,
            started=started,
            finished=finished,
            updated=max(filter(None, (created, _time(row.updated_at), started, finished))),
            digest=told.get("digest", ""),
            outcome=outcome,
            enveloped=bool(told.get("enveloped")),
        )


def engine_states(state: State) -> list[str]:
    """Name what the engine calls a state."""
    return [name for name, ours in _STATES.items() if ours == state]


def _time(milliseconds: int | None) -> datetime | None:
    return None if milliseconds is None else datetime.fromtimestamp(milliseconds / 1000, UTC)


def _message(state: State, told: Mapping[str, Any], row: WorkflowStatus) -> str:
    if state == "accepted":
        return "waits for a worker" if not told.get("started") else "waits for another worker"
    if state == "failed":
        return str(_outcome(state, row)["problem"].get("detail", "failed"))
    if state == "running":
        return str(told.get("message", "begins"))
    return {"successful": "done", "dismissed": "dismissed"}[state]


LOST: dict[str, Any] = {
    "status": 503,
    "kind": "worker-lost",
    "title": "The computation was interrupted",
    "detail": "the machines that computed this job died under it, again and again; send fewer points",
}
"""The problem of a job that took every worker with it."""


def _outcome(state: State, row: WorkflowStatus) -> Mapping[str, Any]:
    if state == "successful":
        return row.output or {}
    if state == "failed":
        told = getattr(row.error, "data", None)
        return told if isinstance(told, dict) else {"problem": LOST}
    return {}
