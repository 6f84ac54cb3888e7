"""From a request to a worker and back: what all routes that compute have in common."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import anyio
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import Receive

from service.problems import Problem, respond
from service.work import Pool
from service.work.tasks import Answer

__all__ = ["answer", "run"]

ABANDONED_SECONDS = 3.0
"""How long a computation may go on when its client has left: about what a new warm worker costs."""


async def run(request: Request, function: str, *arguments: object, seconds: float | None = None) -> Any:
    """Call ``module:name`` in a worker, unless the client leaves before.

    Raises
    ------
    ServiceError
        What :meth:`service.work.Pool.run` raises.
    ClientDisconnect
        When the client has left.
    """
    pool: Pool = request.app.state.pool
    started = anyio.Event()
    with anyio.CancelScope() as scope:
        watcher = asyncio.create_task(_watch(request.receive, started, scope))
        try:
            return await pool.run(function, *arguments, started=started, seconds=seconds)
        finally:
            watcher.cancel()
    raise ClientDisconnect


async def _watch(receive: Receive, started: anyio.Event, scope: anyio.CancelScope) -> None:
    """Cancel when the client has left: at once what still waits, a little later what is being computed."""
    while (await receive())["type"] != "http.disconnect":
        pass
    if started.is_set():
        await anyio.sleep(ABANDONED_SECONDS)
    scope.cancel()


def answer(request: Request, outcome: Answer | Problem, headers: Mapping[str, str] | None = None) -> Response:
    """Make the response of what a worker returned."""
    if isinstance(outcome, Problem):
        return respond(request, outcome)
    told = {"Vary": "Accept", **(headers or {})}
    if outcome.seconds:
        told["Server-Timing"] = ", ".join(
            f"{step};dur={1000 * seconds:.2f}" for step, seconds in outcome.seconds.items()
        )
    return Response(outcome.content, media_type=outcome.media_type, headers=told)
