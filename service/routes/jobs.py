"""Jobs: where they stand, what came of them, and their end."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, Depends, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import JSONResponse, Response, StreamingResponse

from service.answers import JobList, JobStatus, Link, StatusInfo
from service.errors import ExecutionNotReady, JobDismissed, NotFound, ResultNotReady
from service.intake import refuse
from service.jobs import Job, Jobs, Sieve, Watch, sifted
from service.jobs.perform import answer_name
from service.operations import problems
from service.problems import Problem, respond
from service.processes import Process, find
from service.render import FORMS, Settled, decided, negotiate
from service.routes.running import run

__all__ = ["accepted", "info", "results", "router"]

router = APIRouter(tags=["jobs"])

_MOST = 1000


def info(request: Request, job: Job) -> StatusInfo:
    """Describe a job for clients."""
    path = f"/jobs/{job.id}"
    links = [
        Link(href=path, rel="self", type="application/json"),
        Link(
            href=f"{path}/events", rel="monitor", type="text/event-stream", title="Its progress as it comes"
        ),
    ]
    if job.state == "successful":
        forms = find(request.app.state.processes, job.process).forms
        kind = "http://www.opengis.net/def/rel/ogc/1.0/results"
        links += [Link(href=f"{path}/results?format={form}", rel=kind, type=FORMS[form]) for form in forms]
    elif job.state == "failed":
        kind = "http://www.opengis.net/def/rel/ogc/1.0/exceptions"
        links.append(Link(href=f"{path}/results", rel=kind, type="application/problem+json"))
    return StatusInfo(
        jobID=job.id,
        processID=job.process,
        status=job.state,
        message=job.message,
        progress=job.progress,
        created=job.created,
        started=job.started,
        finished=job.finished,
        updated=job.updated,
        links=links,
    )


def accepted(request: Request, job: Job, applied: str | None) -> Response:
    """Tell a client where its job is."""
    headers = {"Location": f"/jobs/{job.id}", "Vary": "Prefer"}
    if applied:
        headers["Preference-Applied"] = applied
    return JSONResponse(info(request, job).model_dump(mode="json", exclude_none=True), 201, headers)


class JobQuery(BaseModel):
    """Which jobs to list."""

    model_config = ConfigDict(extra="forbid")

    status: list[JobStatus] = Field([], description="Only jobs in these states; may be repeated.")
    process: list[str] = Field([], description="Only jobs of these processes; may be repeated.")
    processID: list[str] = Field([], description="The same.")  # noqa: N815 # the standard's name
    type: list[str] = Field([], description="Only jobs of these types; all are of the type `process`.")
    datetime: str | None = Field(
        None, description="Only jobs created then: a time, or two with a slash between; `..` leaves it open."
    )
    minDuration: float | None = Field(None, ge=0, description="Only jobs that took as many seconds.")  # noqa: N815
    maxDuration: float | None = Field(None, ge=0, description="Only jobs that took no more seconds.")  # noqa: N815
    limit: int = Field(100, ge=1, le=_MOST, description="Number of jobs at most.")
    cursor: str | None = Field(None, description="Where to go on; the link `next` has it.")


@router.get(
    "/jobs",
    operation_id="jobs",
    summary="List the jobs",
    response_model_exclude_none=True,
    responses=problems(422, 503),
)
async def jobs(request: Request, response: Response, query: Annotated[JobQuery, Query()]) -> JobList:
    """List jobs, the latest first; `Link: rel=next` leads on when there are more."""
    kept: Jobs = request.app.state.jobs
    try:
        sieve = Sieve.read(query.datetime, query.minDuration, query.maxDuration)
    except ValueError as error:
        raise refuse("invalid-parameter", str(error), ("query", "datetime")) from None
    processes = [*query.process, *query.processID]
    if query.type and "process" not in query.type:
        processes = [""]  # there are no others
    try:
        page = await sifted(kept, list(query.status), processes, query.limit, query.cursor, sieve)
    except ValueError as error:
        raise refuse("invalid-parameter", str(error), ("query", "cursor")) from None
    links = [Link(href=str(request.url.include_query_params()), rel="self", type="application/json")]
    if page.cursor:
        following = request.url.include_query_params(cursor=page.cursor)
        address = f"{following.path}?{following.query}"
        response.headers["Link"] = f'<{address}>; rel="next"'
        links.append(Link(href=address, rel="next", type="application/json"))
    return JobList(jobs=[info(request, job) for job in page.jobs], links=links)


@router.get(
    "/jobs/{jobID}",
    operation_id="job",
    summary="Tell where a job stands",
    response_model_exclude_none=True,
    responses=problems(404, 422, 503),
)
async def job(request: Request, jobID: str) -> StatusInfo:  # the contract's name
    """Answer with its state, its progress and what is being done."""
    kept: Jobs = request.app.state.jobs
    return info(request, await kept.find(jobID))


@router.delete(
    "/jobs/{jobID}",
    operation_id="dismiss",
    summary="Dismiss a job",
    response_model_exclude_none=True,
    responses=problems(404, 422, 503),
)
async def dismiss(request: Request, jobID: str) -> StatusInfo:
    """End the computation, if it runs; of a finished job, remove the results."""
    kept: Jobs = request.app.state.jobs
    return info(request, await kept.dismiss(jobID))


@router.get(
    "/jobs/{jobID}/results",
    operation_id="results",
    summary="Get what came of a job",
    response_class=Response,
    responses={
        200: {"description": "The answer of its process, in any form that the process offers."},
        **problems(404, 406, 422, 429, 503),
    },
)
async def job_results(request: Request, jobID: str) -> Response:
    """Answer what the process itself would have; of a failed job, its problem."""
    kept: Jobs = request.app.state.jobs
    return await results(request, await kept.find(jobID))


async def results(request: Request, job: Job) -> Response:
    """Answer with the results of a job, in the form that this request asks for.

    Raises
    ------
    ResultNotReady
        Before the end.
    JobDismissed
        When there will be none.
    """
    if job.state == "dismissed":
        raise JobDismissed("the job was dismissed: it has no result")
    if not job.final:
        early = ExecutionNotReady if job.enveloped else ResultNotReady
        raise early(f"the job is {job.state}; ask again later", retry_after=1)
    if job.state == "failed":
        return respond(request, Problem.of_json(job.outcome["problem"]))
    process: Process = find(request.app.state.processes, job.process)
    accept, named = request.headers.get("accept"), request.query_params.get("format")
    form = negotiate(accept, named, process.forms)
    document = bool(job.outcome.get("document")) and FORMS[form] == "application/json"
    if document or not decided(accept, named):
        form = job.outcome.get("form", form)  # what the body of an execute request has asked for
    return await _stored(request, job, Settled(form, document))


async def _stored(request: Request, job: Job, settled: Settled) -> Response:
    """Send a result from the store, piece by piece; one that is not there in this form is first written."""
    kept: Jobs = request.app.state.jobs
    store, run_folder = kept.store, job.outcome["run"]
    form, document = settled.form, settled.document
    name = answer_name(run_folder, form, document)
    if not await to_thread.run_sync(store.has, name):
        table = request.app.state.table
        if not await run(
            request,
            "service.jobs.perform:render",
            table,
            kept.store_url,
            job.process,
            run_folder,
            form,
            document,
        ):
            raise NotFound("the results of this job are no longer kept")
    try:
        size, pieces = await to_thread.run_sync(store.chunks, name)
    except FileNotFoundError:
        raise NotFound("the results of this job are no longer kept") from None
    headers = {"Vary": "Accept", "Content-Length": str(size)}
    return StreamingResponse(pieces, media_type=settled.media_type, headers=headers)


async def _found(request: Request, jobID: str) -> Job:
    """Look before the answer begins, for later it is too late to say that there is nothing."""
    kept: Jobs = request.app.state.jobs
    return await kept.find(jobID)


@router.get(
    "/jobs/{jobID}/events",
    operation_id="events",
    summary="Follow a job",
    response_class=EventSourceResponse,
    responses=problems(404, 422, 503),
)
async def events(request: Request, found: Annotated[Job, Depends(_found)]) -> AsyncIterator[ServerSentEvent]:
    """Send where the job stands, now and whenever that changes, until its end (server-sent events)."""
    watch: Watch = request.app.state.watch
    number = 0
    async for latest in watch.changes(found):
        number += 1
        document: dict[str, Any] = info(request, latest).model_dump(mode="json", exclude_none=True)
        yield ServerSentEvent(event=latest.state, id=str(number), data=document)
