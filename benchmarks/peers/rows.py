"""What is measured of each contestant on each point set, and how that is kept."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from benchmarks.peers.sets import Set

__all__ = ["Row", "append", "load"]


@dataclass(frozen=True, slots=True)
class Row:
    """One contestant on one point set; lengths in units of the true noise.

    ``problem`` is empty where there is an answer; ``timed`` tells a row of the sweep over time. ``rms`` and
    ``back`` are the RMS distances from the truth to the result and back, ``maximum`` the larger of the two
    largest.
    """

    contestant: str
    family: str
    n: int
    sigma: float
    seed: int
    timed: bool
    problem: str
    setting: str
    number: int
    seconds: float
    flags: bool = False
    crossings: bool = False
    topology: bool = False
    rms: float = float("inf")
    back: float = float("inf")
    maximum: float = float("inf")
    oracle: float = float("nan")
    rule_topology: bool = False
    rule_rms: float = float("inf")

    @property
    def rule_ratio(self) -> float:
        """RMS error of the one rule as a multiple of the oracle's."""
        return self.rule_rms / self.oracle

    @property
    def key(self) -> tuple[object, ...]:
        """What a later measurement of the same replaces."""
        return self.contestant, self.family, self.n, self.sigma, self.seed, self.timed

    @property
    def set(self) -> Set:
        """The point set."""
        return Set(self.family, self.n, self.sigma, self.seed)

    @property
    def ratio(self) -> float:
        """RMS error as a multiple of the oracle's."""
        return self.rms / self.oracle


def append(file: Path, rows: Iterable[Row]) -> None:
    """Write rows at the end of a file, one a line."""
    with file.open("a") as out:
        out.writelines(json.dumps(asdict(row)) + "\n" for row in rows)


def load(file: Path) -> list[Row]:
    """Read rows; of several with one key the last."""
    if not file.exists():
        return []
    names = {one.name for one in fields(Row)}
    kept: dict[tuple[object, ...], Row] = {}
    for line in file.read_text().splitlines():
        known = json.loads(line)
        row = Row(**{name: value for name, value in known.items() if name in names})
        kept[row.key] = row
    return list(kept.values())
