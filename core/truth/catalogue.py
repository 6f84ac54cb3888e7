"""The names of all families, and what each set of them is for."""

from __future__ import annotations

from core.errors import InvalidParameter
from core.truth.apart import APART
from core.truth.crossing_families import CROSSING
from core.truth.families import BUILT_IN, Family
from core.truth.hard_families import HARD
from core.truth.held_out import HELD_OUT
from core.truth.held_out_crossings import HELD_OUT_CROSSING

__all__ = ["describe", "family", "hard_names", "held_apart_names", "held_out_names", "names"]

_BUILT_IN = (*BUILT_IN, *CROSSING)
_HELD_OUT = (*HELD_OUT, *HELD_OUT_CROSSING)
_FAMILIES = {one.name: one for one in (*_BUILT_IN, *_HELD_OUT, *HARD, *APART)}


def names() -> tuple[str, ...]:
    """Return the names of the built-in families."""
    return tuple(one.name for one in _BUILT_IN)


def held_out_names() -> tuple[str, ...]:
    """Return the names of the families kept for tests and benchmarks."""
    return tuple(one.name for one in _HELD_OUT)


def hard_names() -> tuple[str, ...]:
    """Return the names of the families with fine detail, sharp corners or curves of unequal size."""
    return tuple(one.name for one in HARD)


def held_apart_names() -> tuple[str, ...]:
    """Return the names of the families that only final figures are measured with, never a tuning run."""
    return tuple(one.name for one in APART)


def family(name: str) -> Family:
    """Return the family of that name.

    Raises
    ------
    InvalidParameter
        When there is none, at ``("name",)``.
    """
    if name not in _FAMILIES:
        known = ", ".join(names())
        raise InvalidParameter(f"There is no point set of that name; the names are {known}.", ("name",))
    return _FAMILIES[name]


def describe(name: str) -> str:
    """Return one line on what the family shows."""
    return family(name).description
