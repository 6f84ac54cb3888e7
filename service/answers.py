"""The JSON answers of the service, as pydantic models, for the OpenAPI document.

Answers are written by :mod:`service.render` straight from the results' arrays,
without passing through these models: a million rows would take seconds. The
tests read real answers back through them.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "ErrorItem",
    "ExampleAnswer",
    "ExampleList",
    "ExampleParameters",
    "ExampleSummary",
    "Health",
    "Landing",
    "Link",
    "PartitionAnswer",
    "ProblemDocument",
    "Readiness",
    "ReconstructionAnswer",
]


class _Answer(BaseModel):
    model_config = ConfigDict(extra="forbid")


Coordinates = Annotated[list[float], Field(min_length=2, max_length=3, description="x, y and, in 3D, z.")]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


class Warn(_Answer):
    """Something that the caller should know."""

    code: str = Field(description="Stable name, for programs.")
    message: str
    location: Coordinates | None = None


class Frame(_Answer):
    """Right-handed orthonormal frame of a component (§3.1)."""

    component: int
    origin: Vector = Field(description="Centre of gravity.")
    axes: Annotated[list[Vector], Field(min_length=3, max_length=3)] = Field(
        description="Unit vectors by decreasing variance; the last is the normal of the best plane."
    )
    planarity: float = Field(description="Between 0 (no plane) and 1 (exactly planar).")


class Component(_Answer):
    """A class of extended neighbours (§3.3)."""

    label: int
    size: int
    bbox: Annotated[list[Coordinates], Field(min_length=2, max_length=2)] = Field(
        description="Lower and upper corner."
    )
    frame: Frame


class PartitionAnswer(_Answer):
    """A label for each point, and what is known of each component."""

    epsilon: float = Field(description="Largest hop between extended neighbours, in input units.")
    epsilon_source: Literal["estimated", "given"]
    count: int = Field(description="Number of components.")
    labels: list[int] = Field(description="One for each point, in the order of the input; -1 is an outlier.")
    components: list[Component]
    warnings: list[Warn]


class Curve(_Answer):
    """A piecewise-linear curve; a closed one does not repeat its first vertex."""

    vertices: list[Coordinates]
    closed: bool
    component: int
    length: float
    samples: int = Field(description="Number of samples that this curve explains.")
    rms_residual: float = Field(description="RMS distance of those samples from the curve.")


class Crossing(_Answer):
    """A place where two curves, or one with itself, cross."""

    location: Coordinates
    curves: Annotated[list[int], Field(min_length=2, max_length=2)]
    angle: float = Field(description="In degrees, 0 to 90.")


class Violation(_Answer):
    """A place where the sample is not Nyquist-compliant (§1)."""

    location: Coordinates
    gap_sigmas: float
    reason: str


class Nyquist(_Answer):
    """Whether the noise is below half of the smallest detail, and by what margin."""

    compliant: bool
    margin_sigmas: float | None
    violations: list[Violation]


class Sampling(_Answer):
    """What the data say of themselves."""

    sigma: float = Field(description="Standard deviation of the noise normal to the curve.")
    density: float = Field(description="Samples per unit of length.")
    epsilon: float
    nyquist: Nyquist


class Ball(_Answer):
    """A local ball of the march with its fitted direction (§4.2.1)."""

    centre: Coordinates
    radius: float
    direction: Coordinates
    samples: int
    component: int


class Stages(_Answer):
    """Intermediate results of the march."""

    balls: list[Ball]
    march: list[list[Coordinates]] = Field(description="The vertices before joining and refinement.")


class ReconstructionAnswer(_Answer):
    """Curves, and all that is known of how good they are."""

    method: Literal["pca"]
    reason: str
    curves: list[Curve]
    crossings: list[Crossing]
    outliers: list[int] = Field(description="Indices of the points that no curve explains.")
    sampling: Sampling
    frames: list[Frame]
    warnings: list[Warn]
    stages: Stages | None = Field(None, description="Only when `include` names it.")


class Link(_Answer):
    """A link (RFC 8288)."""

    href: str
    rel: str
    type: str
    title: str | None = None


class ExampleParameters(_Answer):
    """What a point set is drawn with."""

    n: int = Field(description="Number of samples; outliers come on top.")
    sigma: float = Field(description="Standard deviation of the noise, as a fraction of the diagonal.")
    outliers: float = Field(description="Number of uniform outliers, as a fraction of n.")
    seed: int


class ExampleSummary(_Answer):
    """A built-in point set."""

    name: str
    description: str
    defaults: ExampleParameters
    links: list[Link]


class ExampleList(_Answer):
    """The built-in point sets."""

    examples: list[ExampleSummary]
    links: list[Link]


class TrueCurve(_Answer):
    """An exact curve as a dense polyline; a closed one does not repeat its first vertex."""

    vertices: list[Coordinates]
    closed: bool
    length: float


class Truth(_Answer):
    """Where the points of an example come from."""

    sigma: float = Field(description="Standard deviation of the noise, in the units of the points.")
    curves: list[TrueCurve]
    curve_of: list[int] = Field(description="The curve that each point was drawn from; -1 is an outlier.")
    crossings: list[Coordinates]


class ExampleAnswer(_Answer):
    """A point set with its truth."""

    name: str
    description: str
    parameters: ExampleParameters
    points: list[Coordinates]
    truth: Truth


class Health(_Answer):
    """The process answers."""

    status: Literal["ok"] = "ok"


class Readiness(_Answer):
    """The workers are warm."""

    status: Literal["ready"] = "ready"
    workers: int = Field(description="Warm workers now.")


class Landing(_Answer):
    """Where everything is."""

    title: str
    description: str
    version: str
    links: list[Link]


class ErrorItem(_Answer):
    """One thing that is wrong, and where."""

    loc: list[str | int] = Field(description='Path to it, such as ["body", "points", 17, 1].')
    msg: str
    type: str = Field(description="Stable name, for programs.")


class ProblemDocument(_Answer):
    """A problem document (RFC 9457)."""

    type: str = Field(description="Stable name of the kind of problem, for programs.")
    title: str
    status: int
    detail: str = Field(description="What is wrong here, and what to do about it.")
    instance: str = Field(description="This one occurrence; the same as in the log.")
    errors: list[ErrorItem] = Field(default_factory=list)
