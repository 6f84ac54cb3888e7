"""What was measured, kept in a file part by part, so that the page can be written again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["CompletionRow", "MeshRow", "Rows", "SlicingRow", "StackRow", "by_name", "load", "save"]


@dataclass(frozen=True, slots=True)
class MeshRow:
    """One program on one object.

    ``rms``, ``high`` and ``largest`` are distances to the truth both ways, in its units; of real scans only
    ``rms`` is known: from the scan points to the mesh. ``together`` are seconds by the clock with two
    processes. A ``problem`` says why there is no mesh.
    """

    name: str
    program: str
    points: int = 0
    levels: int = 0
    true_components: int = 1
    true_genus: int = 0
    components: int = 0
    genus: int = 0
    closed: bool = False
    manifold: bool = False
    self_intersections: int = 0
    faces: int = 0
    rms: float = float("inf")
    high: float = float("inf")
    largest: float = float("inf")
    cpu: float = float("inf")
    clock: float = float("inf")
    together: float = 0.0
    stages: tuple[float, ...] = ()
    method: str = ""
    completed: int = 0
    problem: str = ""

    @property
    def right(self) -> bool:
        """Whether genus and number of components are those of the object."""
        return (self.components, self.genus) == (self.true_components, self.true_genus)

    @property
    def sound(self) -> bool:
        """Whether every edge has two faces and every vertex one fan."""
        return self.closed and self.manifold


@dataclass(frozen=True, slots=True)
class SlicingRow:
    """CPU seconds of one way to cut a mesh of so many triangles by so many planes."""

    way: str
    triangles: int
    planes: int
    seconds: float


@dataclass(frozen=True, slots=True)
class StackRow:
    """Random stacks: how many were closed manifolds that do not cut themselves, and how they were made."""

    stacks: int
    sound: int
    fallbacks: int
    empty: int
    failures: int
    median: float
    longest: float
    wrong: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class CompletionRow:
    """One level that was damaged: its error and its neighbours', and whether it is told as completed.

    ``rms`` is infinite where no contour is left.
    """

    name: str
    levels: int
    kind: str
    height: float
    rms: float
    neighbours: float
    told: bool
    right: bool


@dataclass(slots=True)
class Rows:
    """All that was measured; a part that was not is empty."""

    seconds: dict[str, float] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    solids: list[MeshRow] = field(default_factory=list)
    scans: list[MeshRow] = field(default_factory=list)
    slicing: list[SlicingRow] = field(default_factory=list)
    stacks: list[StackRow] = field(default_factory=list)
    completion: list[CompletionRow] = field(default_factory=list)


_KINDS: dict[str, type[Any]] = {
    "solids": MeshRow,
    "scans": MeshRow,
    "slicing": SlicingRow,
    "stacks": StackRow,
    "completion": CompletionRow,
}


def save(rows: Rows, file: Path) -> None:
    """Write all rows."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(asdict(rows), indent=1))


def load(file: Path) -> Rows:
    """Read what was written; nothing from a file that is not there."""
    if not file.exists():
        return Rows()
    known = json.loads(file.read_text())
    parts = {name: [_row(kind, one) for one in known[name]] for name, kind in _KINDS.items()}
    return Rows(known["seconds"], known["versions"], **parts)


def _row(kind: type[Any], told: dict[str, Any]) -> Any:
    return kind(**{name: tuple(one) if isinstance(one, list) else one for name, one in told.items()})


def by_name(rows: Sequence[MeshRow], program: str) -> dict[str, MeshRow]:
    """Return the rows of one program by the names of objects."""
    return {row.name: row for row in rows if row.program == program}
