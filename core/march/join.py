"""From fragments to curves (§4.2.2, §5.1): the cheapest bridges are taken first, then chains read off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.cloud.sampling import Sample
from core.march.bridge import Bridge, End, admissible_bridges, tip_of
from core.march.fragments import Fragment
from core.march.prune import without_overlaps
from core.refine.polyline import Polyline

__all__ = ["join_fragments"]

Floats = NDArray[np.float64]
EndKey = tuple[int, bool]  # fragment, and whether its last node or its first


def join_fragments(sample: Sample, fragments: list[Fragment]) -> list[Polyline]:
    """Join ends of fragments where the samples allow it; ends of one fragment close it.

    Parameters
    ----------
    sample : Sample
    fragments : list of Fragment

    Returns
    -------
    list of Polyline
    """
    done = [f.polyline for f in fragments if f.closed]
    opened = without_overlaps([f for f in fragments if not f.closed])
    if not opened:
        return done
    links = _links(admissible_bridges(sample, opened))
    return done + _Chains(sample, opened, links).read()


def _links(bridges: list[Bridge]) -> dict[EndKey, Bridge]:
    """Take bridges greedily; each end is used once."""
    links: dict[EndKey, Bridge] = {}
    for bridge in bridges:
        a, b = _keys(bridge)
        if a not in links and b not in links:
            links[a] = links[b] = bridge
    return links


def _keys(bridge: Bridge) -> tuple[EndKey, EndKey]:
    first, second = bridge.first, bridge.second
    return (first.fragment, first.last), (second.fragment, second.last)


class _Chains:
    """Reads curves off fragments and links: from every free end, then around what is closed."""

    def __init__(self, sample: Sample, opened: list[Fragment], links: dict[EndKey, Bridge]) -> None:
        self._sample, self._opened, self._links = sample, opened, links
        self._used = [False] * len(opened)

    def read(self) -> list[Polyline]:
        keys = [(k, last) for k in range(len(self._opened)) for last in (False, True)]
        free = [key for key in keys if key not in self._links]
        return [self._chain(k, last) for k, last in free + keys[::2] if not self._used[k]]

    def _chain(self, k: int, entered_at_last: bool) -> Polyline:
        """Follow links from one end until a free end or the start is reached."""
        first = k
        parts = [self._tip((k, entered_at_last))[::-1]]
        while True:
            self._used[k] = True
            course = self._course(k)
            parts.append(course[::-1] if entered_at_last else course)
            leaving = (k, not entered_at_last)
            if leaving not in self._links:
                parts.append(self._tip(leaving))
                return Polyline(np.concatenate(parts), False)
            bridge = self._links[leaving]
            parts.append(bridge.between)
            a, b = _keys(bridge)
            k, entered_at_last = b if leaving == a else a
            if self._used[k]:
                return Polyline(np.concatenate(parts), k == first)

    def _course(self, k: int) -> Floats:
        """A fragment's vertices without those that its bridges take back."""
        centres = self._opened[k].centres
        return centres[self._depth((k, False)) : len(centres) - self._depth((k, True))]

    def _depth(self, key: EndKey) -> int:
        if key not in self._links:
            return 0
        bridge = self._links[key]
        return bridge.first.depth if _keys(bridge)[0] == key else bridge.second.depth

    def _tip(self, key: EndKey) -> Floats:
        if key in self._links:
            return np.zeros((0, 3))
        fragment = self._opened[key[0]]
        return tip_of(self._sample, End.of(key[0], fragment, key[1]), fragment)
