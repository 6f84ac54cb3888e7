"""One route for each row of the table of processes."""

from __future__ import annotations

from collections.abc import Iterable

from fastapi import APIRouter, Request
from starlette.responses import Response

from service.intake import Limits
from service.operations import process_operation
from service.processes import Process
from service.render import negotiate
from service.routes.running import answer, run
from service.settings import Settings
from service.work import receive
from service.work.tasks import Execution

__all__ = ["processes"]


def processes(table: Iterable[Process]) -> APIRouter:
    """Make the routes of a table of processes."""
    router = APIRouter(tags=["processes"])
    for row in table:
        _add(router, row)
    return router


def _add(router: APIRouter, process: Process) -> None:
    async def endpoint(request: Request) -> Response:
        return await _perform(request, process)

    router.add_api_route(process.path, endpoint, methods=["POST"], **process_operation(process))


async def _perform(request: Request, process: Process) -> Response:
    settings: Settings = request.app.state.settings
    headers = request.headers
    form = negotiate(headers.get("accept"), request.query_params.get("format"), process.forms)
    length = headers.get("content-length")
    async with receive(request.stream(), int(length) if length else None, settings.max_bytes) as body:
        execution = Execution(
            process=process,
            body=body,
            content_type=headers.get("content-type"),
            content_encoding=headers.get("content-encoding"),
            query=tuple(request.query_params.multi_items()),
            form=form,
            limits=Limits(settings.max_points, settings.max_bytes),
        )
        outcome = await run(request, "service.work.tasks:execute", execution)
    return answer(request, outcome)
