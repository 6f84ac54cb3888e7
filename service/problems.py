"""Errors as problem documents (RFC 9457): one table from error to status, type and title.

Errors of bodies (:class:`service.intake.IntakeError`) bring all three along;
every other error that a client may see has a row here, and what has none is a
defect of ours: logged with its traceback, and answered without it.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import orjson
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Match
from starlette.types import ExceptionHandler

from core.errors import DegenerateInput, InvalidInput, InvalidParameter, InvalidPoints
from service.errors import (
    DeadlineExceeded,
    ExecutionNotReady,
    JobDismissed,
    JobsUnavailable,
    KeyReused,
    NoSuchJob,
    NoSuchProcess,
    NotFound,
    NotReady,
    QueueFull,
    ResultNotReady,
    ServiceError,
    TaskFailed,
    WorkerLost,
)
from service.intake import ErrorItem, IntakeError

__all__ = ["HANDLERS", "MEDIA_TYPE", "TABLE", "Problem", "problem", "respond"]

MEDIA_TYPE = "application/problem+json"
_log = logging.getLogger("service")

_OGC = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0"
"""Under this the standard has types of its own, where it prescribes them."""

TABLE: dict[type[Exception], tuple[int, str, str]] = {
    InvalidInput: (422, "invalid-input", "The input is not valid"),
    InvalidPoints: (422, "invalid-points", "The points are not valid"),
    InvalidParameter: (422, "invalid-parameter", "A parameter is not valid"),
    DegenerateInput: (422, "degenerate-input", "The points determine no curve"),
    NotFound: (404, "not-found", "There is nothing here"),
    NoSuchJob: (404, f"{_OGC}/no-such-job", "There is no such job"),
    NoSuchProcess: (404, f"{_OGC}/no-such-process", "There is no such process"),
    ResultNotReady: (404, "result-not-ready", "There is no result yet"),
    ExecutionNotReady: (404, f"{_OGC}/result-not-ready", "There is no result yet"),
    JobDismissed: (404, "job-dismissed", "The job was dismissed"),
    KeyReused: (422, "idempotency-key-reused", "The key belongs to another request"),
    QueueFull: (429, "queue-full", "Too many requests are waiting"),
    NotReady: (503, "not-ready", "The service is not ready yet"),
    JobsUnavailable: (503, "jobs-unavailable", "No jobs can be taken now"),
    DeadlineExceeded: (503, "deadline-exceeded", "The answer took too long"),
    WorkerLost: (503, "worker-lost", "The computation was interrupted"),
    MemoryError: (503, "out-of-memory", "There is not enough memory for this request"),
    TaskFailed: (500, "internal-error", "The service has a defect"),
    Exception: (500, "internal-error", "The service has a defect"),
}
"""Error → status, problem type and title; an error takes the row of its nearest class."""

_HTTP: dict[int, tuple[str, str, str]] = {
    400: ("bad-request", "The request cannot be read", "the request cannot be read"),
    404: ("not-found", "There is nothing here", "there is nothing at this path; / lists what there is"),
    405: ("method-not-allowed", "The method is not allowed here", "the header Allow lists the methods"),
}
"""What the framework raises: status → problem type, title and detail."""

_OTHER_HTTP = ("bad-request", "The request cannot be answered", "the request cannot be answered")

_METHODS = ("DELETE", "GET", "PATCH", "POST", "PUT")

_DETAILS: dict[type[Exception], str] = {
    MemoryError: "send fewer points",
    Exception: "this is no fault of the request; it has been logged under the instance given here",
}
"""Details for errors whose own message is not for clients."""


@dataclass(frozen=True, slots=True)
class Problem:
    """What a client is told of an error; ``kind`` becomes the member ``type``."""

    status: int
    kind: str
    title: str
    detail: str
    errors: Sequence[ErrorItem] = ()
    headers: Mapping[str, str] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Write as JSON values, for the database of jobs."""
        return asdict(self)

    @classmethod
    def of_json(cls, told: Mapping[str, Any]) -> Problem:
        """Read what `to_json` wrote."""
        known = {one.name for one in fields(cls)}
        return cls(**{name: value for name, value in told.items() if name in known})


def problem(error: Exception, where: tuple[str, ...] = ("body",)) -> Problem:
    """Say what a client is told of an error.

    Parameters
    ----------
    error : Exception
    where : tuple of str
        What the ``loc`` of a core error is relative to.
    """
    if isinstance(error, IntakeError):
        return Problem(error.status, error.kind, error.title, error.detail, tuple(error.errors))
    if isinstance(error, RequestValidationError):
        return _invalid_query(error)
    if isinstance(error, HTTPException):
        return _of_framework(error)
    row = next(kind for kind in type(error).__mro__ if kind in TABLE)
    status, kind, title = TABLE[row]
    if isinstance(error, InvalidInput):
        loc = error.loc[1:] if where == ("query",) and error.loc[:1] == ("parameters",) else error.loc
        item = ErrorItem(loc=[*where, *loc], msg=error.message, type=error.kind.replace("-", "_"))
        return Problem(status, error.kind, title, error.message, (item,))
    if isinstance(error, ServiceError) and status != 500:
        after = {"Retry-After": str(error.retry_after)} if error.retry_after else {}
        return Problem(status, kind, title, error.message, headers=after)
    return Problem(status, kind, title, _DETAILS[MemoryError if row is MemoryError else Exception])


def _invalid_query(error: RequestValidationError) -> Problem:
    """Pass on pydantic's list without what it quotes of the input."""
    status, kind, title = TABLE[InvalidParameter]
    items = tuple(
        ErrorItem(loc=list(item["loc"]), msg=item["msg"], type=item["type"]) for item in error.errors()
    )
    name = next(part for part in reversed(items[0]["loc"]) if isinstance(part, str))
    return Problem(status, kind, title, f"{name}: {items[0]['msg']}", items)


def _of_framework(error: HTTPException) -> Problem:
    kind, title, detail = _HTTP.get(error.status_code, _OTHER_HTTP)
    return Problem(error.status_code, kind, title, detail, headers=error.headers or {})


def respond(request: Request, told: Problem) -> Response:
    """Make the response; the request's id is the ``instance``, by which the log finds it too."""
    document: dict[str, Any] = {
        "type": told.kind,
        "title": told.title,
        "status": told.status,
        "detail": told.detail,
        "instance": f"urn:uuid:{request.state.request_id}",
        "errors": list(told.errors),
    }
    return Response(orjson.dumps(document), told.status, dict(told.headers), MEDIA_TYPE)


async def _not_allowed(request: Request, error: Exception) -> Response:
    """Name all methods of the path; whoever asks with OPTIONS wanted to know just that."""
    allowed = {method for method in _METHODS if _matches(request, method)} | {"OPTIONS"}
    if "GET" in allowed:
        allowed.add("HEAD")
    headers = {"Allow": ", ".join(sorted(allowed))}
    if request.method == "OPTIONS":
        return Response(status_code=204, headers=headers)
    return respond(request, replace(problem(error), headers=headers))


def _matches(request: Request, method: str) -> bool:
    scope = {**request.scope, "method": method}
    return any(route.matches(scope)[0] is Match.FULL for route in request.app.routes)


async def _handle(request: Request, error: Exception) -> Response:
    told = problem(error)
    if told.status == 500:
        # the traceback of a worker is the message; one of ours the server logs by itself
        _log.error("request %s: %s", request.state.request_id, error)
    return respond(request, told)


async def _gone(_request: Request, _error: Exception) -> Response:
    return Response(status_code=499)  # nginx's code for the log: the client closed the request


HANDLERS: dict[Any, ExceptionHandler] = {
    Exception: _handle,
    405: _not_allowed,
    HTTPException: _handle,
    RequestValidationError: _handle,
    IntakeError: _handle,
    InvalidInput: _handle,
    ServiceError: _handle,
    ClientDisconnect: _gone,
}
"""For the application: every error goes through the table."""
