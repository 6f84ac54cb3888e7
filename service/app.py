"""The application: settings and a table of processes in, an ASGI application out."""

from __future__ import annotations

import copy
import os
import tempfile
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI
from fastapi_offline import FastAPIOffline
from starlette.middleware.cors import CORSMiddleware
from uvicorn.config import LOGGING_CONFIG

import core
from service import __version__, routes
from service.middleware import RequestId
from service.operations import document
from service.problems import HANDLERS
from service.processes import PROCESSES, Process
from service.settings import Settings
from service.work import PoolOptions, open_pool

__all__ = ["create_app", "run"]

Lifespan = Callable[[FastAPI], AbstractAsyncContextManager[None]]

_SUMMARY = "Clean curves from noisy, unorganised point clouds."
_DESCRIPTION = """Post a point cloud, get its curves back, without a single parameter.

Every error is a problem document (RFC 9457) that says where the fault is and what to do about it."""


def create_app(settings: Settings | None = None, processes: Iterable[Process] = PROCESSES) -> FastAPI:
    """Make the application.

    Parameters
    ----------
    settings : Settings, optional
        Those of the environment by default.
    processes : iterable of Process, optional
        The table that the routes are made of.
    """
    settings = settings or Settings()
    table = tuple(processes)
    app = FastAPIOffline(  # /docs with its scripts from this server, not from a content network
        redoc_url=None,
        title="Tapeline",
        version=__version__,
        summary=_SUMMARY,
        description=_DESCRIPTION,
        license_info={"name": "Apache-2.0", "identifier": "Apache-2.0"},
        lifespan=_lifespan(settings, table),
        exception_handlers=HANDLERS,
        redirect_slashes=False,
    )
    app.state.settings = settings
    app.state.processes = table
    for router in (routes.processes(table), routes.examples, routes.landing, routes.health):
        app.include_router(router)
    app.add_middleware(RequestId)
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=["GET", "POST"],
            allow_headers=["*"],
            expose_headers=["Retry-After", "Server-Timing", "X-Request-ID"],
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
        log_config=_logging(settings.log_level),
        server_header=False,
        timeout_graceful_shutdown=10,  # what container runtimes allow before they kill
        ws="none",
    )


def _lifespan(settings: Settings, processes: tuple[Process, ...]) -> Lifespan:
    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with tempfile.TemporaryDirectory(prefix="tapeline-") as spare:
            options = PoolOptions(
                workers=settings.workers,
                queue_length=settings.queue_length,
                deadline_seconds=settings.deadline_seconds,
                warm_up=("service.work.tasks:warm", (processes,)),
                environment=_caches(settings.data_dir, Path(spare)),
            )
            async with open_pool(options) as app.state.pool:
                yield

    return lifespan


def _caches(data_dir: Path, spare: Path) -> dict[str, str]:
    """Say where the workers keep compiled kernels and font lists.

    Kernels stay beside their source, where tests and the command line find
    them too, unless the installation is read-only.
    """
    home = data_dir.absolute() if _writable(data_dir) else spare
    places = {"MPLCONFIGDIR": home / "matplotlib"}
    if not os.access(Path(core.__file__).parent, os.W_OK):
        places["NUMBA_CACHE_DIR"] = home / "numba"
    return {name: os.environ.get(name, str(place)) for name, place in places.items()}


def _writable(directory: Path) -> bool:
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            return True
    except OSError:
        return False


def _logging(level: str) -> dict[str, Any]:
    """Let our own messages go where the server's go."""
    config = copy.deepcopy(LOGGING_CONFIG)
    config["loggers"]["service"] = {"handlers": ["default"], "level": level.upper(), "propagate": False}
    return config
