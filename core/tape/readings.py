"""Legal readings of curves that cross (§5.2, Fig. 11): straight on, tangent, with wasp waists, as a graph."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from core.refine.polyline import Polyline
from core.tape.arrangement import Arrangement, arrange
from core.tape.bends import Drawn, draw
from core.tape.smoothing import graph_smoothing, split_smoothing, waist_smoothing

__all__ = ["Reading", "read_crossings"]

Reading = Literal["through", "graph", "split", "waist"]

SMOOTHINGS = {"graph": graph_smoothing, "split": split_smoothing, "waist": waist_smoothing}
SPECK = 6.0  # in sigma: a shorter closed curve that crossings cut off is noise


def read_crossings(
    curves: Sequence[Polyline], mode: Reading, sigma: float, touching: float = 0.0
) -> list[Polyline]:
    """Read curves that run straight through their crossings in another legal way.

    Parameters
    ----------
    curves : sequence of Polyline
        In the plane z = 0.
    mode : {"through", "graph", "split", "waist"}
        ``through``: as they are. ``graph``: cut at every crossing and where one ends on another.
        ``split``: tangent closed curves (Fig. 11b). ``waist``: one curve for each connected part,
        or as few as its open curves allow, with wasp waists (Fig. 11c). In the last two no curve
        crosses another or itself.
    sigma : float
        Noise standard deviation, the scale of roundings; may be 0.
    touching : float
        An open curve that ends within this distance of another ends on it.

    Examples
    --------
    >>> import numpy as np
    >>> u = np.linspace(0.0, 2.0 * np.pi, 99)[:-1]
    >>> eight = Polyline(np.column_stack((np.sin(u), np.sin(2.0 * u), 0.0 * u)), True)
    >>> [len(read_crossings([eight], mode, 0.01)) for mode in ("through", "graph", "split", "waist")]
    [1, 2, 2, 1]
    """
    if mode == "through" or not curves:
        return list(curves)
    read: list[Polyline] = []
    for lines, touches, merging in _attempts(curves, sigma, touching):
        read, clean = _read(lines, arrange(lines, touches, merging), mode, sigma)
        if clean:
            break
    return read


def _attempts(
    curves: Sequence[Polyline], sigma: float, touching: float
) -> Iterator[tuple[Sequence[Polyline], float, float]]:
    """Yield curves, distances of touching and of merging; the next ones where the last lead to crossings.

    Strands that pass by a merged node, or by the way from an end to another curve, may be in the way;
    stretches that coincide have no sides.
    """
    yield curves, touching, sigma
    yield curves, touching, 0.0
    yield curves, 0.0, 0.0
    extent = max(float(np.ptp(line.vertices, axis=0).max()) for line in curves)
    rng = np.random.default_rng(0)
    shift = [1e-5 * extent * rng.uniform(-1.0, 1.0, (len(line.vertices), 2)) for line in curves]
    yield (
        [
            Polyline(line.vertices + np.pad(by, ((0, 0), (0, 1))), line.closed)
            for line, by in zip(curves, shift, strict=True)
        ],
        0.0,
        0.0,
    )


def _read(
    curves: Sequence[Polyline], arrangement: Arrangement, mode: Reading, sigma: float
) -> tuple[list[Polyline], bool]:
    """Curves in the order of the given ones, and whether none crosses another or itself."""
    if not arrangement.arcs:
        return list(curves), not arrangement.nodes
    beside = [curves[k] for k in arrangement.uncut]
    drawn, clean = draw(arrangement, SMOOTHINGS[mode](arrangement), sigma, beside)
    if mode == "split":
        drawn = _without_specks(drawn, arrangement, SPECK * sigma)
    read = [(min(arrangement.arcs[k].curve for k in one.arcs), one.line) for one in drawn]
    read += [(k, curves[k]) for k in arrangement.uncut]
    return [line for _, line in sorted(read, key=lambda one: one[0])], clean


def _without_specks(drawn: Sequence[Drawn], arrangement: Arrangement, least: float) -> list[Drawn]:
    """Leave out closed curves of less than that length, but never all of a connected part."""
    part = arrangement.connected
    longest: dict[int, float] = {}
    for one in drawn:
        k = int(part[one.arcs[0]])
        longest[k] = max(longest.get(k, 0.0), one.line.length)
    return [
        one
        for one in drawn
        if not one.line.closed or one.line.length >= min(least, longest[int(part[one.arcs[0]])])
    ]
