"""The point sets of the comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from core.truth import held_out_names

__all__ = ["FAMILIES", "GROUPS", "QUICK", "Plan", "Set", "group_of", "over_n", "over_sigma", "over_time"]

GROUPS: dict[str, tuple[str, ...]] = {
    "open": ("s_shape", "cubic", "random_open"),
    "closed": ("flower", "bean", "random_closed"),
    "crossing": ("figure_8", "bow", "pentagram"),
    "corners": ("square", "star"),
    "several": ("disjoint", "parallel_waves", "linked_ellipses"),
}
FAMILIES = tuple(name for names in GROUPS.values() for name in names)


@dataclass(frozen=True, slots=True)
class Set:
    """What determines a point set; ``sigma`` is a fraction of the diagonal."""

    family: str
    n: int
    sigma: float
    seed: int

    @property
    def is_held_out(self) -> bool:
        """Whether no constant of Tapeline was chosen with this family."""
        return self.family in held_out_names()


@dataclass(frozen=True, slots=True)
class Plan:
    """The sizes and the noise of the sweeps."""

    families: tuple[str, ...] = FAMILIES
    sizes: tuple[int, ...] = (300, 1000, 5000, 50_000)
    sigma: float = 0.01
    sigmas: tuple[float, ...] = (0.0025, 0.005, 0.01, 0.02, 0.04)
    n: int = 1000
    timed: tuple[int, ...] = (1000, 10_000, 100_000, 1_000_000)


QUICK = Plan(
    ("s_shape", "bean", "figure_8", "star", "disjoint"),
    (300, 1000),
    0.01,
    (0.005, 0.02),
    1000,
    (1000, 10_000),
)


def group_of(family: str) -> str:
    """Return the group of a family."""
    return next(group for group, names in GROUPS.items() if family in names)


def over_n(plan: Plan, seeds: Sequence[int]) -> list[Set]:
    """Return the sets of every size at one noise."""
    return [Set(*one) for one in product(plan.families, plan.sizes, (plan.sigma,), seeds)]


def over_sigma(plan: Plan, seeds: Sequence[int]) -> list[Set]:
    """Return the sets of every noise at one size."""
    return [Set(*one) for one in product(plan.families, (plan.n,), plan.sigmas, seeds)]


def over_time(plan: Plan) -> list[Set]:
    """Return sets of an open S that grow."""
    return [Set("s_shape", n, plan.sigma, 1000) for n in plan.timed]
