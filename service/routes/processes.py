"""One route for each row of the table of processes: computed at once, or as a job."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import orjson
from fastapi import APIRouter, Request
from starlette.responses import Response

from service.errors import DeadlineExceeded, JobsUnavailable
from service.intake import Limits, enveloped, refuse
from service.jobs import Jobs, Order, Watch
from service.operations import process_operation
from service.processes import Process
from service.render import decided, negotiate
from service.routes.jobs import accepted, results
from service.routes.preferences import Preferences
from service.routes.running import answer, run
from service.settings import Settings
from service.work import Body, receive
from service.work.tasks import Execution

__all__ = ["perform", "processes"]

_LONGEST_KEY = 255


def processes(table: Iterable[Process]) -> APIRouter:
    """Make the routes of a table of processes."""
    router = APIRouter(tags=["processes"])
    for row in table:
        _add(router, row)
    return router


def _add(router: APIRouter, process: Process) -> None:
    async def endpoint(request: Request) -> Response:
        return await perform(request, process)

    router.add_api_route(process.path, endpoint, methods=["POST"], **process_operation(process))


async def perform(request: Request, process: Process, envelope: str | None = None) -> Response:
    """Compute what a request asks for: at once when that is quick, else as a job.

    Parameters
    ----------
    request : Request
    process : Process
    envelope : str, optional
        Member of a JSON body that holds points and parameters.
    """
    settings: Settings = request.app.state.settings
    jobs: Jobs = request.app.state.jobs
    asked = _Asked.of(request, process, envelope)
    length = request.headers.get("content-length")
    async with receive(
        request.stream(),
        int(length) if length else None,
        settings.max_bytes,
        jobs.store.staging,
        asked.identity if asked.key is not None else None,
    ) as body:
        seconds = asked.preferences.seconds(settings.wait_seconds, settings.deadline_seconds)
        long = asked.preferences.asynchronous or asked.key is not None or body.size > settings.job_bytes
        if not long and seconds > 0:
            try:
                return await _at_once(request, asked, body, seconds)
            except DeadlineExceeded as late:
                try:
                    return await _as_job(request, asked, body, 0.0)
                except JobsUnavailable:
                    raise late from None
        return await _as_job(request, asked, body, seconds)


@dataclass(frozen=True, slots=True)
class _Asked:
    """What the head of a request says."""

    process: Process
    envelope: str | None
    form: str
    decided: bool
    content_type: str | None
    content_encoding: str | None
    query: tuple[tuple[str, str], ...]
    preferences: Preferences
    key: str | None
    limits: Limits

    @classmethod
    def of(cls, request: Request, process: Process, envelope: str | None) -> _Asked:
        settings: Settings = request.app.state.settings
        headers = request.headers
        key = headers.get("idempotency-key")
        if key is not None and not 0 < len(key) <= _LONGEST_KEY:
            detail = f"an Idempotency-Key has between 1 and {_LONGEST_KEY} characters"
            raise refuse("invalid-parameter", detail, ("header", "idempotency-key"))
        accept, named = headers.get("accept"), request.query_params.get("format")
        return cls(
            process=process,
            envelope=envelope if enveloped(headers.get("content-type")) else None,
            form=negotiate(accept, named, process.forms),
            decided=decided(accept, named),
            content_type=headers.get("content-type"),
            content_encoding=headers.get("content-encoding"),
            query=tuple(request.query_params.multi_items()),
            preferences=Preferences.read(headers.getlist("prefer")),
            key=key,
            limits=Limits(settings.max_points, settings.max_bytes),
        )

    @property
    def identity(self) -> bytes:
        """What besides the body makes two requests the same; the form of the answer does not."""
        query = sorted(pair for pair in self.query if pair[0] != "format")
        told = [self.process.id, self.envelope, self.content_type, self.content_encoding, query]
        return orjson.dumps(told)


async def _at_once(request: Request, asked: _Asked, body: Body, seconds: float) -> Response:
    execution = Execution(
        process=asked.process,
        body=body,
        content_type=asked.content_type,
        content_encoding=asked.content_encoding,
        query=asked.query,
        form=asked.form,
        limits=asked.limits,
        envelope=asked.envelope,
        decided=asked.decided,
    )
    return answer(request, await run(request, "service.work.tasks:execute", execution, seconds=seconds))


async def _as_job(request: Request, asked: _Asked, body: Body, seconds: float) -> Response:
    """Order a job, and wait for its end as long as the client wishes."""
    jobs: Jobs = request.app.state.jobs
    watch: Watch = request.app.state.watch
    order = Order(
        process=asked.process.id,
        body="",
        content_type=asked.content_type,
        content_encoding=asked.content_encoding,
        query=asked.query,
        form=asked.form,
        envelope=asked.envelope,
        decided=asked.decided,
        max_points=asked.limits.max_points,
        max_bytes=asked.limits.max_bytes,
    )
    job = await jobs.order(order, body, asked.key)
    if seconds > 0 and not job.final:
        job = await watch.finished(job, seconds)
    if job.final and job.state != "dismissed" and seconds > 0:
        return await results(request, job)
    return accepted(request, job, asked.preferences.applied)
