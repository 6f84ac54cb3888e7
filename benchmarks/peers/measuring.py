"""Every contestant on every point set."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing import get_context

import numpy as np

from benchmarks.peers.choice import best_score, readings_of
from benchmarks.peers.contestants import named
from benchmarks.peers.environment import FOLDER, ROOT
from benchmarks.peers.process import ENDED, LATE, Attempt, Process
from benchmarks.peers.rows import Row
from benchmarks.peers.sets import Set
from benchmarks.peers.told import Answer, Told
from core.truth import PointSet, oracle_rms, point_set

__all__ = ["LIMIT", "Job", "measure", "measure_all", "measure_times", "row_of", "told_of"]

LIMIT = 60.0  # seconds for one setting on one point set


@dataclass(frozen=True, slots=True)
class Job:
    """A point set and who is measured on it."""

    one: Set
    contestants: tuple[str, ...]


def measure_all(jobs: Sequence[Job], processes: int) -> Iterator[list[Row]]:
    """Measure, in so many processes; the rows of one set at a time."""
    if processes == 1:
        yield from map(measure, jobs)
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from pool.map(measure, jobs)


def measure(job: Job) -> list[Row]:
    """Let the contestants reconstruct one set."""
    sample = _sample(job.one)
    oracle = oracle_rms(sample)
    rows = []
    for name in job.contestants:
        attempts = _process(name).ask(sample.points, sample.curve_of, told_of(sample))
        rows.append(row_of(name, job.one, sample, oracle, attempts))
    return rows


def measure_times(sets: Sequence[Set], contestants: Sequence[str]) -> Iterator[Row]:
    """Time the setting that is best at the first size over all sizes, until one is not answered."""
    for name in contestants:
        only: list[int] | None = None
        for one in sets:
            sample = _sample(one)
            attempts = _process(name).ask(sample.points, sample.curve_of, told_of(sample, every=True), only)
            row = row_of(name, one, sample, oracle_rms(sample), attempts, timed=True)
            yield row
            if row.problem:
                break
            only = [row.number]


def told_of(sample: PointSet, every: bool = False) -> Told:
    """Return what the peers may know of a set."""
    starts = tuple(curve.exact.polyline(24).tolist() for curve in sample.curves)
    starts = tuple(
        [*start, start[0]] if curve.closed else start
        for start, curve in zip(starts, sample.curves, strict=True)
    )
    return Told(
        sample.sigma,
        sum(curve.length for curve in sample.curves),
        tuple(curve.closed for curve in sample.curves),
        starts,
        every,
    )


def row_of(
    name: str, one: Set, sample: PointSet, oracle: float, attempts: Sequence[Attempt], *, timed: bool = False
) -> Row:
    """Choose the best of the attempts and score it."""
    own = named(name).own
    candidates = [
        (attempt, curves)
        for attempt in attempts
        if attempt.answer is not None
        for curves in (_as_it_is(attempt.answer) if own else readings_of(attempt.answer, sample.sigma))
    ]
    best = best_score([curves for _, curves in candidates], sample)
    where = (name, one.family, one.n, one.sigma, one.seed, timed)
    if best is None:
        last = next((one for one in attempts if one.problem in (LATE, ENDED)), attempts[-1])
        return Row(*where, last.problem or "no curve", last.setting, last.number, last.seconds)
    number, got = best
    attempt, unit = candidates[number][0], sample.sigma
    return Row(
        *where,
        "",
        attempt.setting,
        attempt.number,
        attempt.seconds,
        got.flags_right,
        got.crossings == got.true_crossings,
        got.topology_right,
        got.rms / unit,
        got.rms_back / unit,
        max(got.maximum, got.maximum_back) / unit,
        oracle / unit,
        *_by_rule(name, attempts, sample),
    )


def _by_rule(name: str, attempts: Sequence[Attempt], sample: PointSet) -> tuple[bool, float]:
    """Score the setting and reading that a rule chooses: topology, and RMS error in units of the noise."""
    setting, reading = named(name).rule
    answer = next((one.answer for one in attempts if one.number == setting), None)
    if answer is None:
        return False, float("inf")
    readings = _as_it_is(answer) if named(name).own else list(readings_of(answer, sample.sigma))
    best = best_score(readings[reading : reading + 1], sample)
    return (False, float("inf")) if best is None else (best[1].topology_right, best[1].rms / sample.sigma)


def _as_it_is(answer: Answer) -> list[list[tuple[np.ndarray, bool]]]:
    return [answer.curves or []]


def _sample(one: Set) -> PointSet:
    return point_set(one.family, n=one.n, sigma=one.sigma, seed=one.seed)


@lru_cache(maxsize=16)
def _process(name: str) -> Process:
    """Return this process's worker for a contestant."""
    python = sys.executable if named(name).own else str(FOLDER / "venv" / "bin" / "python")
    sample = point_set("s_shape", n=300, seed=1)
    command = [python, "-m", "benchmarks.peers.worker", name, str(FOLDER / "transport")]
    return Process(command, LIMIT, ROOT, (sample.points, sample.curve_of, told_of(sample)))
