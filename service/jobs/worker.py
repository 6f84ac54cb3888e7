"""``tapeline worker``: takes jobs from the queue and computes them, as many at a time as the settings say.

The engine calls the workflows here in threads of its own; each waits for the
process that does the work. What is decided here is written to the database,
and a worker that dies leaves nothing that another could not take up.
"""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import sqlalchemy as sa
from dbos import DBOS, PortableWorkflowError, WorkflowStatus
from dbos import error as engine_errors

from service.errors import DeadlineExceeded, TaskFailed, WorkerLost
from service.jobs import engine
from service.jobs.cradle import resolve
from service.jobs.expiry import Expiry
from service.jobs.nursery import Ended, Limits, Nursery
from service.jobs.roll import BEAT_SECONDS, Roll
from service.jobs.strays import Strays
from service.problems import problem
from service.settings import Settings
from service.store import Store

__all__ = ["JobWorker"]

WATCH_SECONDS = 0.2
PART_TO_JOB_POLLS = 4  # parts are long, and seldom
REPORT_SECONDS = 0.5
PATIENCE_SECONDS = 2.0
LIVES = 4
MOST_RECOVERIES = 20
"""How many workers may die under a job: many, for they die of deployments and by other jobs too.

A job that kills its own process only is given up much sooner, without any harm to its worker.
"""

_log = logging.getLogger("service.jobs")
Told = dict[str, Any]


class JobWorker:
    """One process that computes jobs.

    Parameters
    ----------
    settings : Settings
        With addresses of database and store.
    table : str
        Import path of the table of processes.
    name : str
        Told apart from all other workers that live; the same again when it starts again, if possible.
    """

    def __init__(self, settings: Settings, table: str, name: str) -> None:
        assert settings.database_url is not None  # noqa: S101 # the caller has placed them
        assert settings.store_url is not None  # noqa: S101
        self._settings = settings
        self._database, self._store = settings.database_url, settings.store_url
        self._table = table
        self._name = name
        self._client = engine.connect(self._database)
        self._nursery = Nursery(table, Limits(settings.job_seconds, settings.job_memory))
        self._over = threading.Event()
        self._at_work: list[str] = []

    def run(self) -> None:
        """Compute jobs until a signal says to stop; to be called in the main thread."""
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.stop())
        self._nursery.warm()  # here, for the fork server ends with the thread that began it
        launched = self._launched()
        if launched is None:
            return
        roll, dbos = launched
        strays = Strays(self._client, dbos, roll, self._name)
        expiry = self._expiry()

        def sweep() -> None:
            if roll.takes_duty("expiry", Expiry.SECONDS):
                expiry.sweep()

        rounds: list[tuple[Callable[[], None], float]] = [
            (self._watch, WATCH_SECONDS),
            (lambda: strays.look(list(self._at_work)), Strays.SECONDS),
            (sweep, Expiry.SECONDS / 4),
        ]
        for each, seconds in rounds:
            threading.Thread(target=self._repeat, args=(each, seconds), daemon=True).start()
        _log.info("worker %s takes up to %d jobs at a time", self._name, self._settings.job_workers)
        self._repeat(lambda: self._beat(roll), BEAT_SECONDS)
        roll.leave()

    def stop(self) -> None:
        """Let `run` return soon (from a thread: a signal may come while the event's own lock is held)."""
        threading.Thread(target=self._over.set, daemon=True).start()

    def _launched(self) -> tuple[Roll, DBOS] | None:
        """Wait for the database and launch the engine; None when we are to stop before."""
        while not self._over.is_set():
            try:
                engine.prepare(self._database)
                roll = Roll(self._database, self._name)
                roll.answer()
                break
            except sa.exc.SQLAlchemyError as error:
                _log.error("the database cannot be reached: %s", str(error).splitlines()[0])
                self._over.wait(PATIENCE_SECONDS)
        else:
            return None
        logging.getLogger("dbos").addFilter(_expected)
        dbos = DBOS(config=engine.config(self._database, self._name, self._settings.job_workers))
        for row in resolve(self._table):
            self._register(engine.workflow(row.id), self._job)
        self._register(engine.PART, self._part)
        DBOS.launch()
        often = self._settings.job_poll_seconds
        for queue, seconds in ((engine.JOBS, often), (engine.PARTS, PART_TO_JOB_POLLS * often)):
            DBOS.register_queue(
                queue, worker_concurrency=self._settings.job_workers, polling_interval_sec=seconds
            )
        return roll, dbos

    def _register(self, name: str, function: Callable[..., Told]) -> None:
        def workflow(*arguments: Any) -> Told:
            job = DBOS.workflow_id or ""
            self._at_work.append(job)
            try:
                return function(*arguments)
            finally:
                self._at_work.remove(job)

        DBOS.workflow(name=name, max_recovery_attempts=MOST_RECOVERIES)(workflow)

    def _expiry(self) -> Expiry:
        return Expiry(
            self._client, Store(self._store), self._settings.keep_seconds, self._settings.keep_bytes
        )

    # --- the workflows ----------------------------------------------------------------------------

    def _job(self, order: Told) -> Told:
        """Compute a job, whole or in parts."""
        job = DBOS.workflow_id or ""
        self._note(job, {"started": engine.now(), "message": "begins"})
        told = self._call(job, "begin", (job, order))
        if "parts" in told:
            told = self._in_parts(job, order, told["parts"])
        return _settled(told)

    def _in_parts(self, job: str, order: Told, count: int) -> Told:
        """Let all workers solve the parts of a job, and join them."""
        names = [
            DBOS.enqueue_workflow_with_options(
                {"workflow_name": engine.PART, "queue_name": engine.PARTS, "workflow_id": f"{job}-{number}"},
                job,
                number,
                order["process"],
            ).get_workflow_id()
            for number in range(count)
        ]
        told = self._await(job, names)
        return told or self._call(job, "join", (job, order, count), PARTS_SHARE)

    def _await(self, job: str, parts: list[str]) -> Told:
        """Wait for the parts of a job; return the problem of one that failed, or nothing."""
        report = self._reporter(job)
        while True:
            rows = {row.workflow_id: row for row in self._rows([job, *parts])}
            if not self._is_ours(rows.get(job)):
                raise Ended("the job is no longer ours", killed=True)
            of_parts = [rows[name] for name in parts if name in rows]
            for row in of_parts:
                if row.status in {"ERROR", "CANCELLED", "MAX_RECOVERY_ATTEMPTS_EXCEEDED"}:
                    return self._problem_of(row.workflow_id)
            done = sum(row.status == "SUCCESS" for row in of_parts)
            if done == len(parts):
                return {}
            part = [1.0 if row.status == "SUCCESS" else _percent(row) / 100 for row in of_parts]
            message = f"part {done + 1} of {len(parts)}{_doing(of_parts)}"
            report(PARTS_SHARE * sum(part) / len(parts), message)
            time.sleep(WATCH_SECONDS)

    def _part(self, job: str, number: int, process: str) -> Told:
        """Solve one part of a job."""
        name = DBOS.workflow_id or ""
        return _settled(self._call(name, "solve", (job, number, process)))

    def _call(self, name: str, function: str, arguments: tuple[object, ...], start: float = 0.0) -> Told:
        """Call a function of `service.jobs.perform` in a process of its own; anew if that ends too soon.

        A process that was ended by force may have been an innocent one: the system ends some when
        memory is short. One that crashed will hardly do better the next time.
        """
        path = f"service.jobs.perform:{function}"
        report = self._reporter(name, start)
        lives = LIVES
        while lives > 0:
            try:
                told: Told = self._nursery.run(name, path, (self._table, self._store, *arguments), report)
                return told
            except Ended as ended:
                if ended.killed:
                    raise
                if ended.late:
                    return _told(DeadlineExceeded(_LATE.format(self._settings.job_seconds)))
                _log.warning("job %s: its process ended: %s", name, ended)
                lives -= 1 if ended.by_force else LIVES // 2
            except RuntimeError as error:
                _log.error("job %s: %s", name, error)
                return _told(TaskFailed(str(error)))
        return _told(
            WorkerLost("the process that computed this job ended again and again; send fewer points")
        )

    # --- the database -----------------------------------------------------------------------------

    def _reporter(self, name: str, start: float = 0.0) -> Callable[[float, str], None]:
        """Make what writes progress to the database, now and then."""
        last = 0.0

        def report(fraction: float, message: str) -> None:
            nonlocal last
            if time.monotonic() - last >= REPORT_SECONDS:
                last = time.monotonic()
                percent = int(100 * (start + (1.0 - start) * min(max(fraction, 0.0), 1.0)))
                self._note(name, {"progress": min(percent, 99), "message": message})

        return report

    def _note(self, name: str, told: Mapping[str, object]) -> None:
        """Write what clients may see; that it cannot be written is no reason to stop computing."""
        try:
            self._client.update_workflow_attributes(name, dict(told), merge=True)
        except sa.exc.SQLAlchemyError as error:
            _log.warning("job %s: progress is not written: %s", name, error)

    def _rows(self, names: list[str]) -> list[WorkflowStatus]:
        return self._client.list_workflows(workflow_ids=names, load_input=False, load_output=False)

    def _is_ours(self, row: WorkflowStatus | None) -> bool:
        return row is not None and row.status == "PENDING" and row.executor_id == self._name

    def _problem_of(self, name: str) -> Told:
        (row,) = self._client.list_workflows(workflow_ids=[name], load_input=False)
        told = getattr(row.error, "data", None)
        return told if isinstance(told, dict) else _told(WorkerLost("a part of this job was lost"))

    def _watch(self) -> None:
        """End what nobody wants any more: dismissed, or taken up by another worker."""
        names = self._nursery.names
        if names:
            rows = {row.workflow_id: row for row in self._rows(names)}
            for name in names:
                if not self._is_ours(rows.get(name)):
                    self._nursery.kill(name)

    def _beat(self, roll: Roll) -> None:
        roll.answer()
        (self._settings.data_dir / "beat").touch()  # for whoever looks after processes
        for dead in roll.take_up():
            _log.warning("worker %s is dead; its jobs go back to the queue", dead)

    def _repeat(self, each: Callable[[], object], seconds: float) -> None:
        """Do something again and again until we are to stop, whatever the database does."""
        while not self._over.wait(seconds):
            try:
                each()
            except sa.exc.SQLAlchemyError as error:
                _log.error("the database cannot be reached: %s", str(error).splitlines()[0])
            except Exception:  # the store's, say: what is done here is done for all jobs
                _log.exception("this failed, and is tried again")


PARTS_SHARE = 0.9
"""How much of a divided job is done when all of its parts are."""

_LATE = "the job computed longer than the {:g} s that are allowed; send fewer points"


def _settled(told: Told) -> Told:
    """Return what a job has come to, or raise its problem, which the engine then keeps."""
    told["finished"] = engine.now()  # the database's own clock may count in seconds
    if "problem" in told:
        raise PortableWorkflowError(told["problem"]["detail"], "problem", data=told)
    return told


def _told(error: Exception) -> Told:
    return {"problem": problem(error).to_json()}


def _doing(parts: list[WorkflowStatus]) -> str:
    """Say what one of the parts that are computed now is at."""
    told = (row.attributes or {} for row in parts if row.status == "PENDING")
    return next((f": {one['message']}" for one in told if "message" in one), "")


def _percent(row: WorkflowStatus) -> float:
    return float((row.attributes or {}).get("progress", 0))


def _expected(record: logging.LogRecord) -> bool:
    """Keep from the log what is not the engine's trouble: jobs that fail, or are dismissed."""
    if "outcome was not recorded" in record.getMessage():  # that of a job which was dismissed meanwhile
        return False
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(
        error, PortableWorkflowError | Ended | engine_errors.DBOSAwaitedWorkflowCancelledError
    )
