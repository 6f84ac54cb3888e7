"""Curves and where they cross, as answers have them."""

from __future__ import annotations

from pydantic import Field

from service.answers.base import Answer, Coordinates, Pair

__all__ = ["Ball", "Crossing", "Curve", "PcaStages"]


class Curve(Answer):
    """A piecewise-linear curve; a closed one does not repeat its first vertex."""

    vertices: list[Coordinates]
    closed: bool
    component: int
    length: float
    samples: int = Field(description="Number of samples that this curve explains.")
    rms_residual: float = Field(description="RMS distance of those samples from the curve.")
    standard_errors: list[float] | None = Field(
        description="Standard error of the curve at each vertex, across it, in input units: of a smooth "
        "curve the truth lies within two of them at about 95 % of its length. Null where it was not fitted."
    )


class Crossing(Answer):
    """A place where two curves, or one with itself, cross."""

    location: Coordinates
    curves: Pair
    angle: float = Field(description="In degrees, 0 to 90.")


class Ball(Answer):
    """A local ball with its fitted direction (§4.2.1)."""

    centre: Coordinates
    radius: float
    direction: Coordinates
    samples: int
    component: int


class PcaStages(Answer):
    """Intermediate results of the march."""

    balls: list[Ball] = Field(description="In marching order.")
    march: list[list[Coordinates]] = Field(description="The vertices before joining and refinement.")
