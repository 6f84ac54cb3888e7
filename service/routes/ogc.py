"""OGC API – Processes 1.0: what is met, which processes there are, and their execution."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.answers import Conformance, Link, ProcessDescription, ProcessList
from service.errors import NoSuchProcess
from service.ogc import CONFORMS_TO, ENVELOPE, describe, summarise
from service.operations import execution_operation, problems
from service.processes import Process, find
from service.routes.processes import perform

__all__ = ["ogc"]

_MOST = 1000


class ProcessQuery(BaseModel):
    """Which processes to list."""

    model_config = ConfigDict(extra="forbid")

    limit: int = Field(100, ge=1, le=_MOST, description="Number of processes at most.")
    offset: int = Field(0, ge=0, description="Number of processes to pass over; the link `next` has it.")


def ogc(table: Iterable[Process]) -> APIRouter:
    """Make the routes of the standard for a table of processes."""
    router = APIRouter(tags=["OGC API – Processes"])
    router.get(
        "/conformance", operation_id="getConformanceClasses", summary="Tell what of the standard is met"
    )(conformance)
    router.get(
        "/processes",
        operation_id="getProcesses",
        summary="List the processes",
        responses=problems(422),
    )(processes)
    router.get(
        "/processes/{processID}",
        operation_id="getProcessDescription",
        summary="Describe a process",
        responses=problems(404, 422),
    )(process)
    for row in table:
        _add(router, row)
    unknown = "/processes/{processID}/execution"  # those that there are have routes of their own
    router.add_api_route(unknown, process, methods=["POST"], include_in_schema=False)
    return router


def _add(router: APIRouter, row: Process) -> None:
    async def execute(request: Request) -> Response:
        return await perform(request, row, ENVELOPE)

    path = f"/processes/{row.id}/execution"
    router.add_api_route(path, execute, methods=["POST"], **execution_operation(row))


async def conformance() -> Conformance:
    """Name the conformance classes that are met."""
    return Conformance(conformsTo=CONFORMS_TO)


async def processes(request: Request, query: Annotated[ProcessQuery, Query()]) -> ProcessList:
    """List the processes, in the order of the table."""
    table: tuple[Process, ...] = request.app.state.processes
    end = query.offset + query.limit
    links = [_page("self", query.limit, query.offset, "These processes")]
    if end < len(table):
        links.append(_page("next", query.limit, end, "More processes"))
    return ProcessList(processes=[summarise(row) for row in table[query.offset : end]], links=links)


def _page(relation: str, limit: int, offset: int, title: str) -> Link:
    href = f"/processes?limit={limit}&offset={offset}"
    return Link(href=href, rel=relation, type="application/json", title=title)


async def process(request: Request, processID: str) -> ProcessDescription:  # the standard's name
    """Describe a process: its inputs, its output and where to execute it."""
    try:
        return describe(find(request.app.state.processes, processID))
    except KeyError:
        raise NoSuchProcess("there is no process of this name; /processes lists what there is") from None
