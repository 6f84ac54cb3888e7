"""What is kept of jobs, and for how long: by age, and by the room that there is."""

from __future__ import annotations

import logging
from datetime import UTC, datetime, timedelta

from dbos import DBOSClient, WorkflowStatus

from service.jobs.order import FINAL, engine_states
from service.jobs.perform import input_folder, job_folder
from service.store import Store

__all__ = ["Expiry"]

_BATCH = 500
_ROUNDS = 3  # a round that was missed is made up for
_ORPHANED_SECONDS = 3600.0  # far longer than from an upload's end to its order
_log = logging.getLogger("service.jobs")
_FINAL = [name for state in sorted(FINAL) for name in engine_states(state)]


class Expiry:
    """Removes jobs that are too old, or for which there is no more room.

    Parameters
    ----------
    client : DBOSClient
    store : Store
    keep_seconds : float
        Since a job was finished.
    keep_bytes : int
        Of all files together.
    """

    SECONDS = 60.0
    """Between two rounds."""

    def __init__(self, client: DBOSClient, store: Store, keep_seconds: float, keep_bytes: int) -> None:
        self._client = client
        self._store = store
        self._keep_seconds = keep_seconds
        self._keep_bytes = keep_bytes

    def sweep(self) -> None:
        """Make one round."""
        before = datetime.now(UTC) - timedelta(seconds=self._keep_seconds)
        while rows := self._finished(completed_before=before.isoformat(), limit=_BATCH):
            self.remove([row.workflow_id for row in rows])
        self._shed_inputs()
        self._make_room()
        self._store.tidy(_ORPHANED_SECONDS)

    def remove(self, jobs: list[str]) -> None:
        """Remove jobs with their files; the files first, for without a job nobody would find them."""
        for job in jobs:
            self._store.remove(job_folder(job))
        self._client.delete_workflows(jobs, delete_children=True)

    def _finished(
        self,
        *,
        completed_before: str | None = None,
        completed_after: str | None = None,
        limit: int | None = None,
    ) -> list[WorkflowStatus]:
        """List finished jobs, those that were ordered first in front."""
        rows = self._client.list_workflows(
            status=_FINAL,
            has_parent=False,
            completed_before=completed_before,
            completed_after=completed_after,
            limit=limit,
            load_input=False,
            load_output=False,
        )
        return sorted(rows, key=lambda row: (row.attributes or {}).get("created", 0))

    def _shed_inputs(self) -> None:
        """Remove what only the computation needed, of jobs that were finished since the last rounds."""
        since = datetime.now(UTC) - timedelta(seconds=_ROUNDS * self.SECONDS)
        for row in self._finished(completed_after=since.isoformat()):
            self._store.remove(input_folder(row.workflow_id))

    def _make_room(self) -> None:
        """Remove what belongs to no job, and the oldest jobs while all take more room than they may."""
        entries = {entry.folder: entry for entry in self._store.folders("jobs")}
        rows = self._finished() if sum(one.size for one in entries.values()) > self._keep_bytes else []
        room = self._keep_bytes - sum(one.size for one in entries.values())
        for row in rows:
            if room >= 0:
                break
            entry = entries.get(job_folder(row.workflow_id))
            room += entry.size if entry else 0
            self.remove([row.workflow_id])
        self._remove_orphans([one.folder for one in entries.values() if _is_old(one.modified)])

    def _remove_orphans(self, folders: list[str]) -> None:
        for start in range(0, len(folders), _BATCH):
            names = [folder.rpartition("/")[2] for folder in folders[start : start + _BATCH]]
            rows = self._client.list_workflows(workflow_ids=names, load_input=False, load_output=False)
            for name in set(names) - {row.workflow_id for row in rows}:
                self._store.remove(job_folder(name))


def _is_old(modified: float) -> bool:
    return datetime.now(UTC).timestamp() - modified > _ORPHANED_SECONDS
