"""One accuracy case: a point set, its reconstruction, and how both compare."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context

from core.methods import pca
from core.truth import PointSet, Score, oracle_rms, point_set, score

__all__ = ["Case", "Row", "cases", "measure", "measure_all"]


@dataclass(frozen=True, slots=True)
class Case:
    """What determines a point set; ``sigma`` is a fraction of the diagonal."""

    family: str
    n: int
    sigma: float
    seed: int


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured on one case; lengths in units of the true noise.

    ``flags`` is the right number of curves, each open or closed as in truth; ``topology`` asks for
    cover and crossings too. ``problem`` says in words what is wrong, empty when nothing is.
    """

    case: Case
    flags: bool
    topology: bool
    rms: float
    rms_back: float
    maximum: float
    oracle: float
    sigma_error: float
    seconds: float
    problem: str

    @property
    def ratio(self) -> float:
        """RMS error as a multiple of the oracle's."""
        return self.rms / self.oracle


def cases(families: Iterable[str], sizes: Iterable[int], sigmas: Iterable[float], seeds: int) -> list[Case]:
    """Return the grid of cases, seeds running fastest."""
    return [Case(*one) for one in product(families, sizes, sigmas, range(seeds))]


def measure(case: Case) -> Row:
    """Reconstruct one case without a single parameter, and score the result."""
    sample = point_set(case.family, n=case.n, sigma=case.sigma, seed=case.seed)
    start = time.perf_counter()
    try:
        result = pca(sample.points)
    except Exception as error:  # whatever a method raises is its failure, not the benchmark's
        return _failed(case, time.perf_counter() - start, f"raised {type(error).__name__}: {error}")
    seconds = time.perf_counter() - start
    curves = [(curve.vertices, curve.closed) for curve in result.curves]
    got = score(curves, sample)
    sigma_error = result.sampling.sigma / sample.sigma - 1.0
    unit = sample.sigma
    return Row(
        case,
        got.flags_right,
        got.topology_right,
        got.rms / unit,
        got.rms_back / unit,
        got.maximum / unit,
        oracle_rms(sample) / unit,
        sigma_error,
        seconds,
        "" if got.topology_right else _problem(got, [closed for _, closed in curves], sample),
    )


def measure_all(grid: Sequence[Case], jobs: int) -> Iterator[Row]:
    """Measure cases in ``jobs`` processes, in the order of the grid."""
    if jobs == 1:
        yield from map(measure, grid)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        yield from pool.map(measure, grid, chunksize=4)


def _failed(case: Case, seconds: float, problem: str) -> Row:
    nan = float("nan")
    return Row(case, False, False, nan, nan, nan, nan, nan, seconds, problem)


def _problem(got: Score, flags: list[bool], sample: PointSet) -> str:
    """Say what differs from the truth."""
    words = []
    if got.curves != got.true_curves:
        words.append(f"{got.curves} curves instead of {got.true_curves}")
    elif not got.flags_right:
        words.append(f"closed {flags} instead of {[c.closed for c in sample.curves]}")
    if not got.covered:
        words.append(f"completeness {got.completeness:.3f}, excess {got.excess:.3f}")
    if got.crossings != got.true_crossings:
        words.append(f"{got.crossings} crossings instead of {got.true_crossings}")
    words.append(f"max {got.maximum / sample.sigma:.1f} / {got.maximum_back / sample.sigma:.1f} sigma")
    return "; ".join(words)
