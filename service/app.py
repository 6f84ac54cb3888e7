"""The application: settings and a table of processes in, an ASGI application out."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from importlib import import_module

import anyio
import uvicorn
from fastapi import FastAPI
from fastapi_offline import FastAPIOffline
from starlette.middleware.cors import CORSMiddleware

from service import __version__, routes
from service.jobs import TABLE, Jobs, Watch, keep
from service.logs import configuration
from service.middleware import RequestId
from service.operations import document
from service.places import caches, home
from service.problems import HANDLERS
from service.processes import Process
from service.settings import Settings
from service.work import Pool, PoolOptions, open_pool

__all__ = ["create_app", "run"]

Lifespan = Callable[[FastAPI], AbstractAsyncContextManager[None]]

_SUMMARY = "Clean curves from noisy, unorganised point clouds."
_DESCRIPTION = """Post a point cloud, get its curves back, without a single parameter.

Every error is a problem document (RFC 9457) that says where the fault is and what to do about it."""


def create_app(settings: Settings | None = None, processes: str = TABLE) -> FastAPI:
    """Make the application.

    Parameters
    ----------
    settings : Settings, optional
        Those of the environment by default.
    processes : str, optional
        Import path of the table that the routes are made of: other processes of ours need it too.
    """
    settings = settings or Settings()
    module, _, name = processes.partition(":")
    table: tuple[Process, ...] = getattr(import_module(module), name)
    app = FastAPIOffline(  # /docs with its scripts from this server, not from a content network
        redoc_url=None,
        title="Tapeline",
        version=__version__,
        summary=_SUMMARY,
        description=_DESCRIPTION,
        license_info={"name": "Apache-2.0", "identifier": "Apache-2.0"},
        lifespan=_lifespan(settings, table, processes),
        exception_handlers=HANDLERS,
        redirect_slashes=False,
    )
    app.state.settings = settings
    app.state.processes, app.state.table = table, processes
    for router in (
        routes.processes(table),
        routes.ogc(table),
        routes.jobs,
        routes.examples,
        routes.landing,
        routes.health,
    ):
        app.include_router(router)
    app.add_middleware(RequestId)
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=["DELETE", "GET", "POST"],
            allow_headers=["*"],
            expose_headers=[
                "Link",
                "Location",
                "Preference-Applied",
                "Retry-After",
                "Server-Timing",
                "X-Request-ID",
            ],
        )
    app.openapi = partial(document, app, table)  # type: ignore[method-assign] # the framework's own way
    return app


def run(settings: Settings | None = None) -> None:
    """Serve until a signal says to stop."""
    settings = settings or Settings()
    uvicorn.run(
        create_app(settings),
        host=settings.host,
        port=settings.port,
        log_level=settings.log_level,
        log_config=configuration(settings.log_level),
        server_header=False,
        timeout_graceful_shutdown=10,  # what container runtimes allow before they kill
        ws="none",
    )


def _lifespan(settings: Settings, processes: tuple[Process, ...], table: str) -> Lifespan:
    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with home(settings.data_dir) as place:
            environment = caches(place)
            placed = settings.placed(place)
            options = PoolOptions(
                workers=settings.workers,
                queue_length=settings.queue_length,
                deadline_seconds=settings.deadline_seconds,
                warm_up=("service.work.tasks:warm", (processes,)),
                environment=environment,
            )
            app.state.jobs = jobs = Jobs(placed, [row.id for row in processes])
            app.state.watch = Watch(jobs)
            async with open_pool(options) as app.state.pool, anyio.create_task_group() as group:
                group.start_soon(app.state.watch.run)
                if settings.job_workers:
                    group.start_soon(_keep_worker, app.state.pool, placed, table, environment)
                yield
                group.cancel_scope.cancel()
            jobs.close()

    return lifespan


async def _keep_worker(pool: Pool, settings: Settings, table: str, environment: dict[str, str]) -> None:
    """Keep a worker for jobs, from when the pool is warm: what it compiled need not be compiled twice."""
    await pool.first_warm.wait()
    await keep(settings, table, environment)
