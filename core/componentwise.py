"""Computations that go component by component: here and at once, or in parts anywhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.cloud.partition import partition
from core.cloud.points import as_points
from core.division import Division, Part, balanced
from core.errors import DegenerateInput
from core.parameters import CommonParameters
from core.prepared import Prepared, prepared
from core.progress import Progress, tell, within
from core.refine.blobs import is_blob
from core.results import Component, Partition
from core.solved import Solved

__all__ = ["Componentwise", "Piece", "Pieces"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Answer = TypeVar("Answer")

LEAST_POINTS = 6
BASE = 5000.0  # samples that take as long as what every component takes
SOLVED = 0.15, 0.85  # fractions of the whole between which the components are solved
SCALED = 0.1  # fraction of a component's work after which its scale is known


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A component with its samples, (n, d) in the user's frame, and their indices (n,) in the input."""

    component: Component
    members: Ints
    points: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Pieces(Part):
    """Components that are solved together; ``count`` is how many the point set has in all."""

    parameters: CommonParameters
    pieces: tuple[Piece, ...]
    count: int


@dataclass(frozen=True, slots=True)
class Componentwise(Generic[Answer]):
    """A computation that partitions the points, solves each component, and tells about all together.

    Attributes
    ----------
    parameters : type of CommonParameters
        For defaults.
    method : callable
        ``method(prepared, parameters, progress)``: solves a component; None where nothing lines up.
    answer : callable
        ``answer(points, partition, solved, **flags)``.
    """

    parameters: type[CommonParameters]
    method: Callable[[Prepared, Any, Progress | None], Solved | None]
    answer: Callable[..., Answer]

    def __call__(
        self,
        points: ArrayLike,
        parameters: CommonParameters | None,
        *,
        progress: Progress | None = None,
        **flags: bool,
    ) -> Answer:
        """Compute it here and at once.

        Parameters
        ----------
        points : array_like, (N, d)
        parameters : CommonParameters, optional
        progress : Progress, optional
        **flags : bool
            Of the answer.
        """
        points, parameters = as_points(points), parameters or self.parameters()
        tell(progress, 0.0, "partitioning")
        parts = _partitioned(points, parameters)
        solving = within(progress, *SOLVED)
        solved = list(
            self._solved(_pieces(points, parts), parts.components, parts.count, parameters, solving)
        )
        return self._told(points, parts, solved, within(progress, SOLVED[1], 1.0), flags)

    @property
    def division(self) -> Division:
        """The same in parts."""
        return Division(self._split, self._solve, self._join)

    def _split(self, points: ArrayLike, parameters: CommonParameters | None) -> tuple[Pieces, ...]:
        points, parameters = as_points(points), parameters or self.parameters()
        parts = _partitioned(points, parameters)
        groups = balanced([_work(component) for component in parts.components])
        pieces = list(_pieces(points, parts)) if groups else []
        return tuple(
            Pieces(
                name=_named([parts.components[k] for k in group], parts.count),
                work=sum(_work(parts.components[k]) for k in group),
                parameters=parameters,
                pieces=tuple(pieces[k] for k in group),
                count=parts.count,
            )
            for group in groups
        )

    def _solve(self, part: Pieces, progress: Progress | None) -> tuple[Solved, ...]:
        components = [piece.component for piece in part.pieces]
        solved = tuple(self._solved(part.pieces, components, part.count, part.parameters, progress))
        tell(progress, 1.0, "done")
        return solved

    def _join(
        self,
        points: ArrayLike,
        parameters: CommonParameters | None,
        solved: Sequence[Iterable[Solved]],
        *,
        progress: Progress | None = None,
        **flags: bool,
    ) -> Answer:
        points, parameters = as_points(points), parameters or self.parameters()
        together = sorted((one for part in solved for one in part), key=lambda one: one.component.label)
        parts = _partitioned(points, parameters)
        return self._told(points, parts, together, progress, flags)

    def _solved(
        self,
        pieces: Iterable[Piece],
        components: Sequence[Component],
        count: int,
        parameters: CommonParameters,
        progress: Progress | None,
    ) -> Iterator[Solved]:
        """Solve components one after the other; those where nothing lines up are left out."""
        shares = np.cumsum([0.0, *(_work(component) for component in components)]).tolist()
        for k, piece in enumerate(pieces):
            where = f"component {piece.component.label + 1} of {count}: "
            own = within(progress, shares[k] / shares[-1], shares[k + 1] / shares[-1], where)
            tell(own, 0.0, "estimating its scale")
            one = prepared(piece.points, piece.members, piece.component, parameters)
            solved = self.method(one, parameters, within(own, SCALED, 1.0))
            if solved is not None:
                yield solved

    def _told(
        self,
        points: Floats,
        parts: Partition,
        solved: list[Solved],
        progress: Progress | None,
        flags: dict[str, bool],
    ) -> Answer:
        """Tell about all components together."""
        if not solved:
            raise DegenerateInput(
                "No curve can be seen in these points: nowhere do enough of them line up. "
                "Give more points, or a larger epsilon.",
                ("points",),
            )
        tell(progress, 0.0, "putting the answer together")
        answer = self.answer(points, parts, _without_clumps(solved), **flags)
        tell(progress, 1.0, "done")
        return answer


def _partitioned(points: Floats, parameters: CommonParameters) -> Partition:
    _require_enough(points)
    return partition(points, parameters)


def _require_enough(points: Floats) -> None:
    if (
        len(np.unique(points[: 4 * LEAST_POINTS], axis=0)) < LEAST_POINTS
        and len(np.unique(points, axis=0)) < LEAST_POINTS
    ):
        raise DegenerateInput(
            f"A curve needs at least {LEAST_POINTS} distinct points; there are fewer.", ("points",)
        )


def _pieces(points: Floats, parts: Partition) -> Iterator[Piece]:
    """The components with their samples, one after the other."""
    order = np.argsort(parts.labels, kind="stable")
    first = len(points) - sum(component.size for component in parts.components)  # outliers have label -1
    for component in parts.components:
        members = order[first : first + component.size]
        first += component.size
        yield Piece(component, members, points[members])


def _work(component: Component) -> float:
    """What solving a component costs, in samples."""
    return BASE + component.size


def _named(components: Sequence[Component], count: int) -> str:
    """Tell which components they are."""
    first = components[0].label + 1
    if len(components) == 1:
        return f"component {first} of {count}"
    return f"component {first} and {len(components) - 1} more of {count}"


def _without_clumps(solved: list[Solved]) -> list[Solved]:
    """Leave out components that are but clumps of outliers, unless all are: their samples are outliers."""
    clump = [
        all(is_blob(one.points, line, one.refined.sigma, one.frame.flat) for line in one.refined.curves)
        for one in solved
    ]
    if all(clump):
        return solved
    return [one for one, left_out in zip(solved, clump, strict=True) if not left_out]
