"""Whether the samples are good enough, in one sentence."""

from __future__ import annotations

from core.results import Sampling, Violation

__all__ = ["verdict_of"]

WORST_FIRST = ("branches-hidden", "branches-too-near", "gap-in-samples", "turn-too-sharp")
NAMES = {
    "branches-hidden": ("stretch that may hide two branches", "stretches that may hide two branches"),
    "branches-too-near": (
        "place with branches too near each other",
        "places with branches too near each other",
    ),
    "gap-in-samples": ("gap longer than chance leaves", "gaps longer than chance leaves"),
    "turn-too-sharp": ("turn too sharp for the noise", "turns too sharp for the noise"),
}


def verdict_of(sampling: Sampling) -> str:
    """Say in one sentence whether the samples are good enough, the worst thing first.

    Parameters
    ----------
    sampling : Sampling
    """
    violations = sampling.nyquist.violations
    if not violations:
        margin = sampling.nyquist.margin_sigmas
        near = f"; the nearest branches are {margin:.1f} sigma apart" if margin is not None else ""
        return f"The samples are good enough: the noise stays below half of the smallest detail{near}."
    worst = min(violations, key=_rank)
    rest = [
        _counted(kind, [v for v in violations if v.kind == kind and v is not worst]) for kind in WORST_FIRST
    ]
    more = ", ".join(each for each in rest if each)
    return f"The samples are not good enough: {worst.reason}{f'; and {more}' if more else ''}."


def _rank(violation: Violation) -> tuple[int, float]:
    return WORST_FIRST.index(violation.kind), violation.gap_sigmas


def _counted(kind: str, those: list[Violation]) -> str:
    return f"{len(those)} more {NAMES[kind][len(those) > 1]}" if those else ""
