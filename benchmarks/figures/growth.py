"""Figure 12: time over the number of points for both methods, with fitted exponents.

Both methods march, or triangulate, at most 100 000 spread samples of a component; beyond, what grows is
the partition and the final regression of all samples.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.plots import RESULT, TRUTH, new, save
from benchmarks.timing import FAMILY, LARGE, exponent
from core.methods import pca, skeleton
from core.results import Reconstruction
from core.truth import point_set

__all__ = ["figure_12"]

SIZES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
REPEATS = 3
PAPER = 1.55  # what the paper measured of its PCA method (§6)
METHODS: dict[str, tuple[Callable[..., Reconstruction], str]] = {
    "PCA march": (pca, TRUTH),
    "skeleton": (skeleton, RESULT),
}


def figure_12(sizes: Sequence[int] = SIZES, repeats: int = REPEATS) -> None:
    """Time both methods, taking turns, and draw the best times with the slopes that fit the large sets."""
    best = np.full((len(METHODS), len(sizes)), np.inf)
    for method, _ in METHODS.values():
        method(point_set(FAMILY, n=2000).points)  # compile, or load what was compiled
    for k, n in enumerate(sizes):
        points = point_set(FAMILY, n=n).points
        for _ in range(repeats):
            for row, (method, _) in enumerate(METHODS.values()):
                best[row, k] = min(best[row, k], _seconds(method, points))
    _draw(np.array(sizes, dtype=float), best)


def _seconds(method: Callable[..., Reconstruction], points: NDArray[np.float64]) -> float:
    start = time.process_time()  # of one core: neither method uses more, and other programs may run
    method(points)
    return time.process_time() - start


def _draw(sizes: NDArray[np.float64], best: NDArray[np.float64]) -> None:
    figure, axes = new(1, 1, (5.5, 3.8))
    axis = axes[0, 0]
    large = sizes >= LARGE
    for row, (name, (_, colour)) in zip(best, METHODS.items(), strict=True):
        power = exponent(list(sizes[large]), list(row[large]))
        height = np.exp(np.mean(np.log(row[large]) - power * np.log(sizes[large])))
        axis.loglog(sizes, row, "o", color=colour, markersize=4.5, label=f"{name}, fit $N^{{{power:.2f}}}$")
        axis.loglog(sizes[large], height * sizes[large] ** power, color=colour, linewidth=1.2)
    steep = best[0, large][0] * (sizes[large] / sizes[large][0]) ** PAPER
    axis.loglog(sizes[large], steep, ":", color="0.4", label=f"slope $N^{{{PAPER}}}$, the paper's PCA method")
    axis.set(xlabel="number of points N", ylabel="seconds of one core")
    axis.grid(which="major", color="0.92", linewidth=0.6)
    axis.legend(frameon=False, title=f"fits from N = {LARGE:,} on", alignment="left")
    save(figure, "fig_12_time.svg")
