"""The worker beside the web process: started with it, started again when it dies, ended with it."""

from __future__ import annotations

import fcntl
import logging
import os
import socket
import subprocess
import sys
import threading
import uuid
from typing import NoReturn

import anyio

from service.jobs.worker import JobWorker
from service.logs import configure
from service.places import caches, home
from service.settings import Settings

__all__ = ["TABLE", "compute", "compute_beside", "keep"]

TABLE = "service.processes:PROCESSES"

LONGEST_PAUSE_SECONDS = 30.0
STOP_SECONDS = 3.0
_log = logging.getLogger("service.jobs")


async def keep(settings: Settings, table: str, environment: dict[str, str]) -> None:
    """Keep a worker running in a process beside ours, for ever.

    Parameters
    ----------
    settings : Settings
        With addresses of database and store.
    table : str
        Import path of the table of processes.
    environment : dict
        Variables to add to ours.
    """
    failures = 0
    while True:
        began = anyio.current_time()
        await _once(table, {**os.environ, **environment, **settings.environment()})
        failures = 0 if anyio.current_time() - began > LONGEST_PAUSE_SECONDS else failures + 1
        await anyio.sleep(min(2.0**failures / 20, LONGEST_PAUSE_SECONDS))


async def _once(table: str, environment: dict[str, str]) -> None:
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)  # noqa: PTH109 # sys.path has text
    with anyio.CancelScope(shield=True):
        process = await anyio.open_process(
            [sys.executable, "-P", "-m", "service.jobs", table],
            stdin=subprocess.PIPE,  # its end tells the worker that we are no more
            stdout=None,
            stderr=None,
            env={**environment, "PYTHONPATH": path},
        )
    try:
        await process.wait()
        _log.warning("the worker for jobs ended (%s); starting another", process.returncode)
    finally:
        with anyio.CancelScope(shield=True):
            if process.returncode is None:
                process.terminate()
                with anyio.move_on_after(STOP_SECONDS):
                    await process.wait()
            if process.returncode is None:
                process.kill()
            await process.aclose()


def compute_beside(table: str) -> None:
    """Be the worker beside a web process: end with its pipe, and keep one name from start to start."""
    settings = Settings()
    configure(settings.log_level)
    directory = settings.data_dir
    directory.mkdir(parents=True, exist_ok=True)
    threading.Thread(target=_follow, daemon=True, name="follow-parent").start()
    with (directory / "worker.lock").open("a+") as name:
        fcntl.flock(name, fcntl.LOCK_EX)  # another server in this directory: ours waits until that one ends
        name.seek(0)
        known = name.read().strip()
        if not known:
            known = str(uuid.uuid4())
            name.write(known)
            name.flush()
        leave(_code(JobWorker(settings, table, known)))


def compute(settings: Settings) -> None:
    """Be a worker on its own, as ``tapeline worker`` is."""
    configure(settings.log_level)
    name = f"{socket.gethostname()}-{uuid.uuid4()}"
    with home(settings.data_dir) as place:
        os.environ.update(caches(place))
        code = _code(JobWorker(settings.placed(place), TABLE, name))
    leave(code)


def _code(worker: JobWorker) -> int:
    """Let a worker work; an error that it cannot help must end the process, or nobody starts another."""
    try:
        worker.run()
    except Exception:
        _log.exception("the worker for jobs failed")
        return 1
    return 0


def leave(code: int = 0) -> NoReturn:
    """End this process: threads of jobs may still wait for processes that end with us."""
    logging.shutdown()
    os._exit(code)


def _follow() -> None:
    while sys.stdin.buffer.read(1):
        pass
    os._exit(1)
