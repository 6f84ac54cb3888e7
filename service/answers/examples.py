"""The answers of the built-in point sets."""

from __future__ import annotations

from pydantic import Field

from service.answers.base import Answer, Coordinates, Link

__all__ = ["ExampleAnswer", "ExampleList", "ExampleParameters", "ExampleSummary"]


class ExampleParameters(Answer):
    """What a point set is drawn with."""

    n: int = Field(description="Number of samples; outliers come on top.")
    sigma: float = Field(description="Standard deviation of the noise, as a fraction of the diagonal.")
    outliers: float = Field(description="Number of uniform outliers, as a fraction of n.")
    seed: int


class ExampleSummary(Answer):
    """A built-in point set."""

    name: str
    description: str
    defaults: ExampleParameters
    links: list[Link]


class ExampleList(Answer):
    """The built-in point sets."""

    examples: list[ExampleSummary]
    links: list[Link]


class TrueCurve(Answer):
    """An exact curve as a dense polyline; a closed one does not repeat its first vertex."""

    vertices: list[Coordinates]
    closed: bool
    length: float


class Truth(Answer):
    """Where the points of an example come from."""

    sigma: float = Field(description="Standard deviation of the noise, in the units of the points.")
    curves: list[TrueCurve]
    curve_of: list[int] = Field(description="The curve that each point was drawn from; -1 is an outlier.")
    crossings: list[Coordinates]


class ExampleAnswer(Answer):
    """A point set with its truth."""

    name: str
    description: str
    parameters: ExampleParameters
    points: list[Coordinates]
    truth: Truth
