"""What the reconstruction is to reach, beside what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Goal", "table"]


@dataclass(frozen=True, slots=True)
class Goal:
    """A figure to reach: ``measured`` at least ``bound``, or at most, shown in the format ``shown``."""

    what: str
    measured: float
    bound: float
    at_most: bool = False
    shown: str = ".1%"

    @property
    def reached(self) -> bool:
        """Whether the figure was reached in this run."""
        return self.measured <= self.bound if self.at_most else self.measured >= self.bound


def table(goals: Sequence[Goal]) -> list[str]:
    """Return a markdown table."""
    lines = ["| figure | goal | measured | reached |", "|---|---|---|---|"]
    for one in goals:
        sign = "≤" if one.at_most else "≥"
        lines.append(
            f"| {one.what} | {sign} {one.bound:{one.shown}} | {one.measured:{one.shown}} "
            f"| {'yes' if one.reached else 'no'} |"
        )
    return lines
