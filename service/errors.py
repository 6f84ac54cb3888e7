"""The errors of the service itself, on one screen.

::

    ServiceError
    ├── NotFound            there is nothing of that name
    │   ├── NoSuchProcess       in the words of OGC API – Processes
    │   └── NoSuchJob           likewise
    ├── ResultNotReady      the job is not finished
    │   └── ExecutionNotReady   the same of a job ordered through OGC API – Processes
    ├── JobDismissed        the job was dismissed: it has no result
    ├── KeyReused           an idempotency key came with another request
    ├── NotReady            no worker is warm yet
    ├── JobsUnavailable     the database of jobs cannot be reached
    ├── QueueFull           as many requests wait as may wait
    ├── DeadlineExceeded    waiting and computing took longer than is allowed
    ├── WorkerLost          the worker process died under the request, twice
    └── TaskFailed          a task raised what nobody foresaw: a defect of ours

Errors of bodies are :class:`service.intake.IntakeError`, those of geometry are
in :mod:`core.errors`; :mod:`service.problems` says what a client sees of each.
"""

from __future__ import annotations

__all__ = [
    "DeadlineExceeded",
    "ExecutionNotReady",
    "JobDismissed",
    "JobsUnavailable",
    "KeyReused",
    "NoSuchJob",
    "NoSuchProcess",
    "NotFound",
    "NotReady",
    "QueueFull",
    "ResultNotReady",
    "ServiceError",
    "TaskFailed",
    "WorkerLost",
]


class ServiceError(Exception):
    """Root of the errors that the service raises on purpose.

    Parameters
    ----------
    message : str
        What is wrong and what to do about it, for the client.
    retry_after : int, optional
        Seconds after which the same request may succeed.
    """

    def __init__(self, message: str, retry_after: int | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.retry_after = retry_after


class NotFound(ServiceError):
    """There is nothing of that name."""


class NoSuchJob(NotFound):
    """There is no job of that name, or none any more."""


class NoSuchProcess(NotFound):
    """There is no process of that name; the standard prescribes the problem's type."""


class ResultNotReady(ServiceError):
    """The job is not finished."""


class ExecutionNotReady(ResultNotReady):
    """A job is not finished whose order was an execute request; the standard prescribes the type."""


class JobDismissed(ServiceError):
    """The job was dismissed: it has no result."""


class KeyReused(ServiceError):
    """An idempotency key came with another request than before."""


class NotReady(ServiceError):
    """No worker is warm yet."""


class JobsUnavailable(ServiceError):
    """The database of jobs cannot be reached."""


class QueueFull(ServiceError):
    """As many requests wait as may wait."""


class DeadlineExceeded(ServiceError):
    """Waiting and computing took longer than is allowed."""


class WorkerLost(ServiceError):
    """The worker process died while it worked for a request."""


class TaskFailed(ServiceError):
    """A task raised an error that nobody foresaw; the message is its traceback, for the log only."""
