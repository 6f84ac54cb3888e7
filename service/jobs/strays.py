"""Jobs that are marked as running where nobody runs them.

The engine takes a job from the queue, runs it, and writes what came of it; when
the database goes away in between, the mark may stay although the work is over.
A worker that lives would hold such a job for ever, and so would one that died
before it answered the roll again.
"""

from __future__ import annotations

import logging
from collections.abc import Collection

from dbos import DBOS, DBOSClient

from service.jobs import engine
from service.jobs.roll import Roll

__all__ = ["Strays"]

_log = logging.getLogger("service.jobs")


class Strays:
    """Finds such jobs and gives them back to the queue.

    Parameters
    ----------
    client : DBOSClient
    dbos : DBOS
        The engine of this worker.
    roll : Roll
    worker : str
        Our own name.
    """

    SECONDS = 5.0
    """Between two looks; only what both find is a stray, for a job may just be on its way."""

    def __init__(self, client: DBOSClient, dbos: DBOS, roll: Roll, worker: str) -> None:
        self._client = client
        self._dbos = dbos
        self._roll = roll
        self._worker = worker
        self._seen: set[tuple[str, str]] = set()

    def look(self, at_work: Collection[str]) -> None:
        """Look once, and give back what was found the last time already.

        Parameters
        ----------
        at_work : collection of str
            The jobs and parts that this worker is at.
        """
        rows = self._client.list_workflows(status="PENDING", load_input=False, load_output=False)
        workers = self._roll.names()
        strays = {
            (row.workflow_id, row.executor_id or "")
            for row in rows
            if (
                row.workflow_id not in at_work
                if row.executor_id == self._worker
                else row.executor_id not in workers
            )
        }
        for job, worker in strays & self._seen:
            # Moves only what is still marked so: it may have been finished, dismissed or taken up.
            if self._dbos._sys_db.reenqueue_for_recovery(job, [worker], engine.JOBS):
                _log.warning("job %s: nobody ran it any more; it goes back to the queue", job)
        self._seen = strays
