"""The answer of the partition."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from service.answers.base import Answer, Coordinates, Frame, Warn

__all__ = ["Component", "PartitionAnswer"]


class Component(Answer):
    """A class of extended neighbours (§3.3)."""

    label: int
    size: int
    bbox: Annotated[list[Coordinates], Field(min_length=2, max_length=2)] = Field(
        description="Lower and upper corner."
    )
    frame: Frame


class PartitionAnswer(Answer):
    """A label for each point, and what is known of each component."""

    epsilon: float = Field(description="Largest hop between extended neighbours, in input units.")
    epsilon_source: Literal["estimated", "given"]
    count: int = Field(description="Number of components.")
    labels: list[int] = Field(description="One for each point, in the order of the input; -1 is an outlier.")
    components: list[Component]
    warnings: list[Warn]
