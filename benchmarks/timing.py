"""Time over the number of points, against a ``cKDTree`` build in the same run (the paper's Fig. 12)."""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from core.methods import partition, pca
from core.parameters import PartitionParameters
from core.truth import point_set

__all__ = [
    "Import",
    "Timing",
    "exponent",
    "import_times",
    "main",
    "partition_memory",
    "peak",
    "tables",
    "timings",
]

SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
NEIGHBOURS = 50
FAMILY = "s_shape"
LARGE = 100_000  # from here on the fixed costs are small
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Timing:
    """Best times in seconds of one core for one number of points.

    ``partition`` is with epsilon given so that a point has about 50 neighbours; ``estimated`` with
    epsilon left to the data; ``march`` is what the whole reconstruction takes beyond that.
    """

    n: int
    tree: float
    partition: float
    estimated: float
    pca: float

    @property
    def march(self) -> float:
        """March and refinement: the reconstruction without the partition that it begins with."""
        return self.pca - self.estimated


@dataclass(frozen=True, slots=True)
class Import:
    """Time to import a module in a fresh interpreter, beyond the start of the interpreter."""

    module: str
    seconds: float


def timings(sizes: Sequence[int] = SIZES, repeats: int = 3, family: str = FAMILY) -> list[Timing]:
    """Time every size, the contestants taking turns; the best of ``repeats`` counts."""
    pca(point_set(family, n=2000).points)  # compile, or load what was compiled
    partition(point_set(family, n=2000).points)
    return [_timing(family, n, repeats) for n in sizes]


def _timing(family: str, n: int, repeats: int) -> Timing:
    points = point_set(family, n=n).points
    given = PartitionParameters(epsilon=_epsilon(points))
    contestants: list[Callable[[], object]] = [
        lambda: cKDTree(points),
        lambda: partition(points, given),
        lambda: partition(points),
        lambda: pca(points),
    ]
    best = np.full(len(contestants), np.inf)
    for _ in range(repeats):
        for k, contestant in enumerate(contestants):
            best[k] = min(best[k], _seconds(contestant))
    return Timing(n, *(float(one) for one in best))


def _seconds(work: Callable[[], object]) -> float:
    start = time.process_time()  # of one core: nothing here uses more, and other programs may run
    work()
    return time.process_time() - start


def _epsilon(points: Floats) -> float:
    """Return the median distance to the fiftieth neighbour."""
    some = points[:: max(1, len(points) // 500)]
    return float(np.median(np.asarray(cKDTree(points).query(some, k=NEIGHBOURS + 1)[0])[:, -1]))


def exponent(sizes: Sequence[int], seconds: Sequence[float]) -> float:
    """Return b of the fit seconds = a N^b, by least squares of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def partition_memory(n: int = 1_000_000) -> float:
    """Return the MB that a partition adds to the peak memory of a fresh process, points not counted."""
    command = [sys.executable, "-m", "benchmarks.timing", "--memory", str(n)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)  # noqa: S603 - ourselves


def _measure_memory(n: int) -> float:
    partition(point_set(FAMILY, n=2000).points)
    points = np.random.default_rng(0).permutation(point_set(FAMILY, n=n).points)
    given = PartitionParameters(epsilon=_epsilon(points))
    ballast = np.ones(peak() // 8)  # raises the present to the peak so far: what follows shows at once
    before = peak()
    partition(points, given)
    after = peak()
    del ballast
    return (after - before) / 1e6


def peak() -> int:
    """Return the largest memory that this process has held so far, in bytes."""
    kilobytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return kilobytes if sys.platform == "darwin" else kilobytes * 1024


def import_times(modules: Sequence[str] = ("core.methods", "service.app"), repeats: int = 3) -> list[Import]:
    """Time the imports that a worker and the request process make when they start."""
    bare = min(_start("pass") for _ in range(repeats))
    return [Import(one, min(_start(f"import {one}") for _ in range(repeats)) - bare) for one in modules]


def _start(code: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)  # noqa: S603 - our own interpreter
    return time.perf_counter() - start


def tables(rows: Sequence[Timing]) -> list[str]:
    """Return a markdown table of the times, their ratios to the tree, and their exponents."""
    lines = [
        "| N | cKDTree build | partition, ε given | / tree | ε estimated | march, refine | / tree | all |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.n:,} | {_ms(row.tree)} | {_ms(row.partition)} | {row.partition / row.tree:.2f} "
        f"| {_ms(row.estimated)} | {_ms(row.march)} | {row.march / row.tree:.2f} | {_ms(row.pca)} |"
        for row in rows
    ]
    large = [row for row in rows if row.n >= LARGE]
    return lines + _exponents(rows, "exponent") + _exponents(large, f"exponent, N ≥ {LARGE:,}")


def _exponents(rows: Sequence[Timing], title: str) -> list[str]:
    """Return a line of exponents, none for a single size."""
    if len(rows) < 2:
        return []
    sizes = [row.n for row in rows]
    fields = ("tree", "partition", "estimated", "march", "pca")
    columns = [[getattr(row, name) for row in rows] for name in fields]
    tree, given, estimated, march, whole = (f"{exponent(sizes, column):.2f}" for column in columns)
    return [f"| {title} | {tree} | {given} | | {estimated} | {march} | | {whole} |"]


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms" if seconds < 0.1 else f"{1e3 * seconds:.0f} ms"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--n", type=lambda text: [int(float(part)) for part in text.split(",")], default=SIZES
    )
    parser.add_argument("--family", default=FAMILY)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--memory", type=int, help="print the MB that a partition of so many points takes")
    options = parser.parse_args(arguments)
    if options.memory:
        print(_measure_memory(options.memory))
        return
    print("\n".join(tables(timings(options.n, options.repeats, options.family))))


if __name__ == "__main__":
    main()
