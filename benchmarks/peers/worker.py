"""One contestant in a process of its own; requests and answers are lines of JSON.

Runs in the peers' environment, so nothing here may import the core, but for Tapeline's own side, which
runs in the project's. ``python -m benchmarks.peers.worker NAME [PROGRAM]``
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.told import Answer, Told

__all__ = ["LOADERS", "main"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Settings = Callable[[Told, int], Iterator[tuple[str, Any]]]
Run = Callable[[Floats, Ints, Told, Any], Answer]

MEMORY = 12 * 2**30  # bytes of address space: beyond that a contestant fails, not the machine


def _skeletonize(_program: str) -> tuple[Settings, Run]:
    from benchmarks.peers import image  # noqa: PLC0415 - only in the environment that has it

    return image.settings, lambda points, _curve_of, told, setting: image.run(points, told, setting)


def _elpigraph(_program: str) -> tuple[Settings, Run]:
    from benchmarks.peers import elastic  # noqa: PLC0415

    return elastic.settings, lambda points, curve_of, told, setting: elastic.run(
        _parts(points, curve_of, told), told, setting
    )


def _pcurvepy(_program: str) -> tuple[Settings, Run]:
    from benchmarks.peers import principal  # noqa: PLC0415

    return principal.settings_hastie, lambda points, curve_of, told, setting: principal.run_hastie(
        _parts(points, curve_of, told), told, setting
    )


def _prinpy(_program: str) -> tuple[Settings, Run]:
    from benchmarks.peers import principal  # noqa: PLC0415

    return principal.settings_local, lambda points, curve_of, told, setting: principal.run_local(
        _parts(points, curve_of, told), told, setting
    )


def _cgal(program: str) -> tuple[Settings, Run]:
    from benchmarks.peers import transport  # noqa: PLC0415

    return transport.settings, lambda points, _curve_of, told, setting: transport.run(
        points, told, setting, Path(program)
    )


def _own(name: str) -> tuple[Settings, Run]:
    from core import methods  # noqa: PLC0415 - only in the project's environment

    method = getattr(methods, name)

    def settings(_told: Told, _n: int) -> Iterator[tuple[str, Any]]:
        yield "no parameters", None

    def run(points: Floats, _curve_of: Ints, _told: Told, _setting: Any) -> Answer:
        return Answer(curves=[(curve.vertices, curve.closed) for curve in method(points).curves])

    return settings, run


LOADERS: dict[str, Callable[[str], tuple[Settings, Run]]] = {
    "auto": lambda _: _own("reconstruct"),
    "pca": lambda _: _own("pca"),
    "skeleton": lambda _: _own("skeleton"),
    "skeletonize": _skeletonize,
    "cgal": _cgal,
    "elpigraph": _elpigraph,
    "pcurvepy2": _pcurvepy,
    "prinpy": _prinpy,
}


def _parts(points: Floats, curve_of: Ints, told: Told) -> list[Floats]:
    """Return the samples of each true curve."""
    return [points[curve_of == k] for k in range(len(told.closed))]


def main(arguments: list[str]) -> None:
    """Answer requests until there are no more."""
    out = os.fdopen(os.dup(1), "w", buffering=1)
    sys.stdout = sys.stderr  # some peers print
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    warnings.simplefilter("ignore")
    settings, run = LOADERS[arguments[0]](arguments[1] if len(arguments) > 1 else "")
    for line in sys.stdin:
        _answer(json.loads(line), settings, run, out)


def _answer(request: dict[str, Any], settings: Settings, run: Run, out: TextIO) -> None:
    """Run the settings that are asked for, or all; report each as soon as it is done."""
    with np.load(request["file"]) as known:
        points, curve_of = known["points"], known["curve_of"]
    told = Told.of_json(request["told"])
    for k, (words, setting) in enumerate(settings(told, len(points))):
        if request["only"] is not None and k not in request["only"]:
            continue
        out.write(json.dumps({"started": k, "setting": words}) + "\n")
        start = _cpu()
        try:
            answer = run(points, curve_of, told, setting)
            problem = ""
        except Exception as error:  # whatever a contestant raises is its failure
            answer, problem = Answer(), f"{type(error).__name__}: {error}"[:200]
        seconds = _cpu() - start
        file = Path(request["file"]).with_name(f"answer-{k}.npz")
        if not problem:
            _save(file, answer)
        out.write(json.dumps({"done": k, "seconds": seconds, "file": str(file), "problem": problem}) + "\n")
    out.write(json.dumps({"finished": True}) + "\n")


def _cpu() -> float:
    """CPU seconds of this process and of those that it ran."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + used.ru_utime + used.ru_stime


def _save(file: Path, answer: Answer) -> None:
    if answer.curves is None:
        assert answer.vertices is not None  # noqa: S101 - a graph then
        assert answer.edges is not None  # noqa: S101
        np.savez(file, vertices=answer.vertices, edges=answer.edges)
        return
    lines = {f"line_{k}": vertices for k, (vertices, _) in enumerate(answer.curves)}
    np.savez(file, closed=np.array([closed for _, closed in answer.curves], bool), **lines)


if __name__ == "__main__":
    main(sys.argv[1:])
