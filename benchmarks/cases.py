"""One accuracy case: a point set, its reconstruction, and how both compare."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context

from core.methods import pca, reconstruct, skeleton
from core.parameters import SkeletonParameters
from core.results import Reconstruction
from core.truth import PLAIN, Conditions, PointSet, Reading, Score, oracle_rms, point_set, score

__all__ = ["METHODS", "Case", "Row", "cases", "measure", "measure_all"]

METHODS = ("pca", "skeleton", "auto")


@dataclass(frozen=True, slots=True)
class Case:
    """What determines a point set, and how it is reconstructed.

    ``sigma`` is a fraction of the diagonal; ``method`` is ``pca``, ``skeleton`` or ``auto`` (the service
    chooses), and ``crossings`` the reading that the skeleton is asked for.
    """

    family: str
    n: int
    sigma: float
    seed: int
    method: str = "pca"
    crossings: Reading = "through"
    outliers: float = 0.0
    conditions: Conditions = PLAIN

    def point_set(self) -> PointSet:
        """Draw the point set."""
        return point_set(self.family, self.n, self.sigma, self.outliers, self.seed, self.conditions)

    def __str__(self) -> str:
        """Family, size, noise and seed, with colons between."""
        return f"{self.family}:{self.n}:{self.sigma:g}:{self.seed}"


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured on one case; lengths in units of the true noise.

    ``flags`` is the right number of curves, each open or closed as in truth; ``crossings`` the right
    number of crossings; ``topology`` asks for both and for cover. ``problem`` says in words what
    is wrong, empty when nothing is.
    """

    case: Case
    flags: bool
    crossings: bool
    topology: bool
    rms: float
    rms_back: float
    maximum: float
    oracle: float
    sigma_error: float
    seconds: float
    problem: str

    @property
    def right(self) -> bool:
        """Whether curves, flags and crossings are right."""
        return self.flags and self.crossings

    @property
    def ratio(self) -> float:
        """RMS error as a multiple of the oracle's."""
        return self.rms / self.oracle


def cases(
    families: Iterable[str],
    sizes: Iterable[int],
    sigmas: Iterable[float],
    seeds: int,
    method: str = "pca",
    crossings: Reading = "through",
) -> list[Case]:
    """Return the grid of cases, seeds running fastest."""
    return [Case(*one, method, crossings) for one in product(families, sizes, sigmas, range(seeds))]


def measure(case: Case) -> Row:
    """Reconstruct one case without a single parameter, and score the result."""
    sample = case.point_set()
    start = time.perf_counter()
    try:
        result = _reconstruct(case, sample)
    except Exception as error:  # whatever a method raises is its failure, not the benchmark's
        return _failed(case, time.perf_counter() - start, f"raised {type(error).__name__}: {error}")
    seconds = time.perf_counter() - start
    curves = [(curve.vertices, curve.closed) for curve in result.curves]
    got = score(curves, sample, case.crossings)
    sigma_error = result.sampling.sigma / sample.sigma - 1.0
    unit = sample.sigma
    return Row(
        case,
        got.flags_right,
        got.crossings == got.true_crossings,
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


def _reconstruct(case: Case, sample: PointSet) -> Reconstruction:
    if case.method == "pca":
        return pca(sample.points)
    if case.method == "auto":
        return reconstruct(sample.points)
    return skeleton(sample.points, SkeletonParameters(crossings=case.crossings))


def _failed(case: Case, seconds: float, problem: str) -> Row:
    nan = float("nan")
    return Row(case, False, False, False, nan, nan, nan, nan, nan, seconds, problem)


def _problem(got: Score, flags: list[bool], sample: PointSet) -> str:
    """Say what differs from the truth."""
    words = []
    if got.curves != got.true_curves:
        words.append(f"{got.curves} curves instead of {got.true_curves}")
    elif not got.flags_right:
        words.append(f"closed {flags}, wrong for {[c.closed for c in sample.curves]}")
    if not got.covered:
        words.append(f"completeness {got.completeness:.3f}, excess {got.excess:.3f}")
    if got.crossings != got.true_crossings:
        words.append(f"{got.crossings} crossings instead of {got.true_crossings}")
    words.append(f"max {got.maximum / sample.sigma:.1f} / {got.maximum_back / sample.sigma:.1f} sigma")
    return "; ".join(words)
