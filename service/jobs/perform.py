"""What a job's own process does: read the body, compute or divide, and leave the results in the store.

Each function runs in a process forked for it, and answers with plain JSON.
"""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from typing import Any

from core.errors import InvalidInput
from core.progress import Progress, within
from service.intake import IntakeError, Limits, Submission, decode
from service.jobs.cradle import resolve
from service.jobs.order import Order
from service.problems import problem
from service.processes import Process, find
from service.render import Settled, settle
from service.store import Store, freeze, thaw
from service.work.tasks import source_of, write

__all__ = ["answer_name", "begin", "input_folder", "job_folder", "join", "part_name", "render", "solve"]

Told = dict[str, Any]


def job_folder(job: str) -> str:
    """Name the folder of all that belongs to a job."""
    return f"jobs/{job}"


def input_folder(job: str) -> str:
    """Name the folder of what nobody needs when the job is finished."""
    return f"{job_folder(job)}/input"


def answer_name(run: str, form: str, document: bool = False) -> str:
    """Name the file of a rendered result, as it is or in a document."""
    return f"{run}/{'document' if document else 'answer'}.{form}"


def part_name(job: str, number: int, kind: str) -> str:
    """Name the file of a part: the ``question`` before it is solved, the ``solution`` after."""
    return f"{input_folder(job)}/{number}.{kind}"


def begin(table: str, store_url: str, job: str, order: Told, *, progress: Progress) -> Told:
    """Compute a job, or divide it when it is large.

    Returns
    -------
    dict
        ``run``, the folder of the results; or ``parts``, how many there are to be solved first;
        or ``problem``.
    """
    store, asked = Store(store_url), Order.model_validate(order)
    row = find(resolve(table), asked.process)

    def work() -> Told:
        progress(0.0, "reading the input")
        submission = _submission(store, row, asked)
        parts = _divided(store, row, job, submission)
        if parts:
            return {"parts": parts}
        result = row.resolve()(
            submission.data,
            submission.parameters,
            progress=within(progress, 0.02, 0.95),
            **row.flags(submission.include),
        )
        return _kept(store, row, job, asked, submission, result)

    return _told(work, asked)


def solve(table: str, store_url: str, job: str, number: int, process: str, *, progress: Progress) -> Told:
    """Solve one part."""
    store = Store(store_url)
    division = resolve(find(resolve(table), process).division or "")

    def work() -> Told:
        part = thaw(store.read(part_name(job, number, "question")))
        store.write(part_name(job, number, "solution"), freeze(division.solve(part, progress)))
        return {}

    return _told(work)


def join(table: str, store_url: str, job: str, order: Told, parts: int, *, progress: Progress) -> Told:
    """Join the solutions of all parts."""
    store, asked = Store(store_url), Order.model_validate(order)
    row = find(resolve(table), asked.process)

    def work() -> Told:
        progress(0.0, "joining the parts")
        submission = _submission(store, row, asked)
        solved = [thaw(store.read(part_name(job, k, "solution"))) for k in range(parts)]
        joined = resolve(row.division or "").join(
            submission.data,
            submission.parameters,
            solved,
            progress=within(progress, 0.1, 0.95),
            **row.flags(submission.include),
        )
        return _kept(store, row, job, asked, submission, joined)

    return _told(work, asked)


def render(table: str, store_url: str, process: str, run: str, form: str, document: bool = False) -> bool:
    """Write a result in a form that it has not been written in yet (called in a warm worker).

    Returns
    -------
    bool
        False when the result is no longer kept.
    """
    store, row = Store(store_url), find(resolve(table), process)
    assert form in row.forms  # noqa: S101 # negotiated before
    try:
        result, points = thaw(store.read(f"{run}/result"))
    except FileNotFoundError:
        return False
    store.write(answer_name(run, form, document), write(result, Settled(form, document), points))
    return True


def _submission(store: Store, row: Process, order: Order) -> Submission:
    with store.local(order.body) as body:
        content = body.read_bytes()
    limits = Limits(order.max_points, order.max_bytes)
    submission = decode(
        content,
        order.content_type,
        order.content_encoding,
        order.query,
        row.parameters,
        row.include,
        limits,
        order.envelope,
        row.takes,
    )
    settle(submission.reply, order.form, order.decided, row.forms)  # refused now rather than at the end
    return submission


def _divided(store: Store, row: Process, job: str, submission: Submission) -> int:
    """Write the parts of a job that is worth dividing, and say how many there are."""
    if row.division is None:
        return 0
    parts: Sequence[object] = resolve(row.division).split(submission.data, submission.parameters)
    for number, part in enumerate(parts):
        store.write(part_name(job, number, "question"), freeze(part))
    return len(parts)


def _kept(store: Store, row: Process, job: str, order: Order, submission: Submission, result: object) -> Told:
    """Keep a result, and already write it as the client wishes to have it.

    Each run writes to a folder of its own: should two come to an end, neither
    overwrites what the other has been named for.
    """
    run = f"{job_folder(job)}/{uuid.uuid4().hex}"
    store.write(f"{run}/result", freeze((result, submission.points)))
    settled = settle(submission.reply, order.form, order.decided, row.forms)
    name = answer_name(run, settled.form, settled.document)
    store.write(name, write(result, settled, submission.points))
    told: Told = {"run": run}
    if order.envelope is not None:  # what its body asks for counts when the results are got, too
        told |= {"form": settled.form, "document": settled.document}
    return told


def _told(work: Any, order: Order | None = None) -> Told:
    """Tell of an error of the client's as a problem; anything else is raised."""
    try:
        told: Told = work()
        return told
    except InvalidInput as error:
        where = source_of(error, order.query, order.envelope) if order else ("body",)
        return {"problem": problem(error, where=where).to_json()}
    except (IntakeError, MemoryError) as error:
        return {"problem": problem(error).to_json()}
