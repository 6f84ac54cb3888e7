"""What the workers do for a request: read the body, compute, and write the answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import orjson

from core.errors import InvalidInput
from service.intake import IntakeError, Limits, Submission, decode
from service.problems import Problem, problem
from service.processes import Process
from service.render import FORMS, encode
from service.work.body import Body

__all__ = ["Answer", "Execution", "execute", "warm"]

Pairs = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Execution:
    """One request for a process, as it came: nothing in it has been looked at but ``form``."""

    process: Process
    body: Body
    content_type: str | None
    content_encoding: str | None
    query: Pairs
    form: str
    limits: Limits


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
        )
        result = clock("compute", _compute, process, submission)
        content = clock("render", encode, result, execution.form, submission.points)
    except InvalidInput as error:
        return problem(error, where=_source(error, execution.query))
    except (IntakeError, MemoryError) as error:
        return problem(error)
    return Answer(content, FORMS[execution.form], clock.seconds)


def _compute(process: Process, submission: Submission) -> Any:
    flags = {name: name in submission.include for name in process.include}
    return process.resolve()(submission.points, submission.parameters, **flags)


def _source(error: InvalidInput, query: Pairs) -> tuple[str, ...]:
    """Say whether the parameter that the core refuses came in the query or, like the points, in the body."""
    named = error.loc[:1] == ("parameters",) and error.loc[1:2] in {(name,) for name, _ in query}
    return ("query",) if named else ("body",)


def warm(processes: Iterable[Process]) -> None:
    """Import and compile all that requests will need: every process in every form, on noisy circles.

    What they raise is passed on: a worker that cannot warm up can do no work.
    """
    limits = Limits(max_points=10_000, max_bytes=1_000_000)
    for process in processes:
        for points in _circles():
            body = orjson.dumps({"points": points.tolist(), "include": sorted(process.include)})
            submission = decode(
                body, "application/json", None, (), process.parameters, process.include, limits
            )
            result = _compute(process, submission)  # once for all forms: workers shall be ready soon
            for form in process.forms:
                encode(result, form, submission.points)


def _circles() -> tuple[Any, Any]:
    """Draw a noisy circle in the plane and a tilted one in space."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, 400)
    flat = np.column_stack([np.cos(angle), np.sin(angle)]) + rng.normal(0, 0.01, (400, 2))
    return flat, np.column_stack([flat, flat.sum(axis=1) + rng.normal(0, 0.01, 400)])


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
