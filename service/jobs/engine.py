"""The durable engine under the jobs: DBOS Transact on SQLite or Postgres, and what all of us call things.

The database holds orders and states; what is large lies in the store. See
docs/decisions/durable-jobs.md.
"""

from __future__ import annotations

import sqlite3
import time
from pathlib import Path

import sqlalchemy as sa
from dbos import DBOS, DBOSClient, DBOSConfig, DBOSPortableJSONSerializer

__all__ = [
    "APPLICATION",
    "JOBS",
    "PART",
    "PARTS",
    "SERIALIZER",
    "VERSION",
    "config",
    "connect",
    "now",
    "prepare",
    "workflow",
]

APPLICATION = "tapeline"
VERSION = "1"
"""Of the orders: raised when workers can no longer do what older servers ordered."""
JOBS, PARTS = "jobs", "parts"
"""The queues: of whole jobs, and of the parts that a large one falls into."""
PART = "part"
"""The workflow of a part; that of a job is named by its process."""
SERIALIZER = DBOSPortableJSONSerializer()
"""JSON, which any version of anything can read; never pickles."""

_CONNECTIONS = 5


def workflow(process: str) -> str:
    """Name the workflow that computes a process; the listing of jobs filters by it."""
    return f"job:{process}"


def prepare(url: str) -> None:
    """Create or migrate the database; several processes may do so at once.

    Raises
    ------
    sqlalchemy.exc.SQLAlchemyError
        When it cannot be reached.
    """
    file = sa.make_url(url).database
    if url.startswith("sqlite") and file:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        with sqlite3.connect(
            file, timeout=30
        ) as connection:  # kept in the file: readers and a writer at once
            connection.execute("PRAGMA journal_mode=WAL")
        connection.close()
    DBOS.migrate(url)


def connect(url: str) -> DBOSClient:
    """Open a connection from which jobs can be ordered and followed."""
    return DBOSClient(
        system_database_url=url,
        serializer=SERIALIZER,
        application_name=APPLICATION,
        system_database_pool_size=_CONNECTIONS,
        retry_connection_errors=False,  # a client is told at once rather than kept waiting
        lazy=True,
    )


def config(url: str, executor: str, job_workers: int) -> DBOSConfig:
    """Configure the engine in a process that computes jobs."""
    return {
        "name": APPLICATION,
        "system_database_url": url,
        "application_version": VERSION,
        "executor_id": executor,
        "serializer": SERIALIZER,
        "use_listen_notify": False,
        "run_migrations": False,  # done by `prepare`
        "sys_db_pool_size": _CONNECTIONS + 2 * job_workers,
        "log_level": "WARNING",
        "console_log_level": "WARNING",
    }


def now() -> int:
    """Milliseconds since 1970."""
    return int(time.time() * 1000)
