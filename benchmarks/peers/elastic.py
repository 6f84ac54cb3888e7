"""The peer elpigraph-python: elastic principal curves and circles, told where each curve's samples are."""

from __future__ import annotations

from collections.abc import Iterator

import elpigraph
import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.told import Answer, Told, subset

__all__ = ["run", "settings"]

Floats = NDArray[np.float64]
Setting = tuple[int, float]


def settings(told: Told, n: int) -> Iterator[tuple[str, Setting]]:
    """Yield numbers of nodes of each curve, and shares of the default stiffness."""
    del told, n
    for nodes, share in ((30, 0.1), (50, 1.0), (50, 0.1), (50, 0.01)):
        yield f"{nodes} nodes, λ = {0.01 * share:g}, μ = {0.1 * share:g}", (nodes, share)


def run(parts: list[Floats], told: Told, setting: Setting) -> Answer:
    """Fit each curve's own samples by a principal curve or circle."""
    curves = []
    for part, closed in zip(parts, told.closed, strict=True):
        some = subset(part, told)
        if len(some) < 4:
            continue
        nodes, share = min(setting[0], len(some) // 2), setting[1]
        fit = elpigraph.computeElasticPrincipalCircle if closed else elpigraph.computeElasticPrincipalCurve
        (graph,) = fit(some, nodes, Lambda=0.01 * share, Mu=0.1 * share, verbose=False, ComputeMSEP=False)
        order = _walk(np.asarray(graph["Edges"][0]))
        curves.append((np.asarray(graph["NodePositions"])[order], closed))
    return Answer(curves=curves)


def _walk(edges: NDArray[np.int64]) -> list[int]:
    """Return the nodes of a chain or a ring in order."""
    near: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        near.setdefault(a, []).append(b)
        near.setdefault(b, []).append(a)
    first = min(near, key=lambda node: (len(near[node]), node))
    order, last = [first], -1
    while True:
        ahead = [node for node in near[order[-1]] if node != last]
        if not ahead or ahead[0] == first:
            return order
        last = order[-1]
        order.append(ahead[0])
