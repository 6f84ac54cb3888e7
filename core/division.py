"""How a long computation falls into parts that can be computed anywhere, in any order."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from core.progress import Progress

__all__ = ["Division", "Part", "balanced"]

MOST_PARTS = 16
LEAST_PART = 10_000.0  # in samples: less is sooner done than sent
WORTH = 50_000.0  # in samples: a second or two of work
LARGEST_SHARE = 0.8  # of the work: whoever waits for that hardly waits for the rest


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a computation: plain data, all that solving it needs; each division has its own kind.

    Attributes
    ----------
    name : str
        What it is, for people.
    work : float
        What it costs, in samples; shares of progress follow from it.
    """

    name: str
    work: float


@dataclass(frozen=True, slots=True)
class Division:
    """How a computation is divided.

    Attributes
    ----------
    split : callable
        ``split(data, parameters)``: the parts, those that take longest first; none where dividing is not
        worth it.
    solve : callable
        ``solve(part, progress)``: solves one part, in whatever process.
    join : callable
        ``join(data, parameters, solved, *, progress=None, **flags)``: what the undivided computation
        gives, to the last bit, from what solving the parts gave, in any order. ``flags`` are those of the
        undivided computation.
    """

    split: Callable[[Any, Any], tuple[Part, ...]]
    solve: Callable[[Any, Progress | None], object]
    join: Callable[..., Any]


def balanced(work: Sequence[float]) -> list[list[int]]:
    """Gather pieces of work into parts that take about as long as one another.

    Parameters
    ----------
    work : sequence of float
        What each piece costs, in samples.

    Returns
    -------
    list of lists of int
        The pieces of each of at most 16 parts, in their order; the largest part first. Empty where dividing
        is not worth it: where there is little work in all, or one piece has most of it.

    Examples
    --------
    >>> balanced([30_000, 20_000, 20_000, 10_000])
    [[0], [1, 3], [2]]
    >>> balanced([100, 100])
    []
    """
    total = float(sum(work))
    if total < WORTH or max(work) > LARGEST_SHARE * total:
        return []
    count = min(ceil(total / max(*work, LEAST_PART)), MOST_PARTS)
    loads = [(0.0, k) for k in range(count)]
    parts: list[list[int]] = [[] for _ in range(count)]
    for piece in sorted(range(len(work)), key=lambda k: -work[k]):  # the largest first: the rest fills up
        load, k = loads[0]
        parts[k].append(piece)
        heapq.heapreplace(loads, (load + work[piece], k))
    order = sorted(loads, key=lambda each: (-each[0], each[1]))
    return [sorted(parts[k]) for _, k in order]
