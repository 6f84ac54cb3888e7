"""What the workers do for a request: read the body, compute, and write the answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.errors import InvalidInput
from service.intake import IntakeError, Limits, Submission, Takes, decode
from service.problems import Problem, problem
from service.processes import Process
from service.render import Settled, dump_json, enclose, encode, settle
from service.work.body import Body

__all__ = ["Answer", "Execution", "execute", "source_of", "warm", "write"]

Pairs = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Execution:
    """One request for a process, as it came: nothing in it has been looked at but ``form``.

    ``decided`` says whether the client has asked for it, or whether the body still may.
    """

    process: Process
    body: Body
    content_type: str | None
    content_encoding: str | None
    query: Pairs
    form: str
    limits: Limits
    envelope: str | None = None
    decided: bool = True


@dataclass(frozen=True, slots=True)
class Answer:
    """A finished answer; ``seconds`` are those of each step by name."""

    content: bytes
    media_type: str
    seconds: Mapping[str, float] = field(default_factory=dict)


def execute(execution: Execution) -> Answer | Problem:
    """Run a process for a request.

    Returns
    -------
    Answer or Problem
        A problem for everything that the client can mend; anything else is raised.
    """
    process = execution.process
    clock = _Clock()
    try:
        submission = clock(
            "intake",
            decode,
            execution.body.read(),
            execution.content_type,
            execution.content_encoding,
            execution.query,
            process.parameters,
            process.include,
            execution.limits,
            execution.envelope,
            process.takes,
        )
        settled = settle(submission.reply, execution.form, execution.decided, process.forms)
        result = clock("compute", _compute, process, submission)
        content = clock("render", write, result, settled, submission.points)
    except InvalidInput as error:
        return problem(error, where=source_of(error, execution.query, execution.envelope))
    except (IntakeError, MemoryError) as error:
        return problem(error)
    return Answer(content, settled.media_type, clock.seconds)


def write(result: object, settled: Settled, points: NDArray[np.float64] | None) -> bytes:
    """Write a result as it has been settled."""
    content = encode(result, settled.form, points)
    return enclose(content, settled.form) if settled.document else content


def _compute(process: Process, submission: Submission) -> Any:
    flags = process.flags(submission.include)
    return process.resolve()(submission.data, submission.parameters, **flags)


def source_of(error: InvalidInput, query: Pairs, envelope: str | None = None) -> tuple[str, ...]:
    """Say whether the parameter that the core refuses came in the query or, like the points, in the body."""
    named = error.loc[:1] == ("parameters",) and error.loc[1:2] in {(name,) for name, _ in query}
    if named:
        return ("query",)
    return ("body",) if envelope is None else ("body", envelope)


def warm(processes: Iterable[Process]) -> None:
    """Import and compile all that requests will need: every process in every form, on circles.

    What they raise is passed on: a worker that cannot warm up can do no work.
    """
    limits = Limits(max_points=10_000, max_bytes=1_000_000)
    for process in processes:
        for given in _TRIALS[process.takes]():
            body = dump_json({**given, "include": sorted(process.include)})
            submission = decode(
                body,
                "application/json",
                None,
                (),
                process.parameters,
                process.include,
                limits,
                takes=process.takes,
            )
            result = _compute(process, submission)  # once for all forms: workers shall be ready soon
            for form in process.forms:
                encode(result, form, submission.points)


def _circles() -> Iterator[dict[str, Any]]:
    """Draw a noisy circle in the plane and a tilted one in space."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, 400)
    flat = np.column_stack([np.cos(angle), np.sin(angle)]) + rng.normal(0, 0.01, (400, 2))
    yield {"points": flat}
    yield {"points": np.column_stack([flat, flat.sum(axis=1) + rng.normal(0, 0.01, 400)])}


def _barrel() -> Iterator[dict[str, Any]]:
    """Scan a barrel from three sides."""
    rng = np.random.default_rng(0)
    height, angle = np.mgrid[-1.0:1.0:9j, -1.2:1.2:17j]
    images = []
    for view in (0.0, 2.1, 4.2):
        wide = 1.0 - 0.1 * height**2 + rng.normal(0, 0.005, height.shape)
        points = np.dstack([wide * np.cos(angle + view), wide * np.sin(angle + view), height])
        images.append({"points": points.tolist()})
    yield {"range_images": images, "parameters": {"levels": 3}}


_TRIALS: dict[Takes, Callable[[], Iterator[dict[str, Any]]]] = {"points": _circles, "scans": _barrel}


class _Clock:
    """Measures how long each step takes."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def __call__(self, step: str, function: Callable[..., Any], *arguments: object, **options: object) -> Any:
        start = time.perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            self.seconds[step] = time.perf_counter() - start
