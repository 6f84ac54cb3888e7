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
    "PcaAnswer",
    "ProblemDocument",
    "Readiness",
    "SkeletonAnswer",
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
    """A local ball with its fitted direction (§4.2.1)."""

    centre: Coordinates
    radius: float
    direction: Coordinates
    samples: int
    component: int


class _Reconstruction(_Answer):
    """Curves, and all that is known of how good they are, by whatever method."""

    method: str
    reason: str
    curves: list[Curve]
    crossings: list[Crossing]
    outliers: list[int] = Field(description="Indices of the points that no curve explains.")
    sampling: Sampling
    frames: list[Frame]
    warnings: list[Warn]


class PcaStages(_Answer):
    """Intermediate results of the march."""

    balls: list[Ball] = Field(description="In marching order.")
    march: list[list[Coordinates]] = Field(description="The vertices before joining and refinement.")


class PcaAnswer(_Reconstruction):
    """Curves, and all that is known of how good they are."""

    method: Literal["pca"]
    stages: PcaStages | None = Field(None, description="Only when `include` names it.")


class MultiPolygon(_Answer):
    """A GeoJSON MultiPolygon (RFC 7946): rings repeat their first position; the first is the outer one."""

    type: Literal["MultiPolygon"]
    coordinates: list[
        Annotated[list[Annotated[list[Coordinates], Field(min_length=4)]], Field(min_length=1)]
    ] = Field(description="Polygons, each a list of rings: the outer loop L_0, then the holes.")


class Containment(_Answer):
    """Whether the skeleton lies in the tape (§4.5), and the samples too."""

    covered: bool = Field(description="Whether all of the skeleton lies in the tape.")
    passes: int = Field(description="How often the tape's border was resampled; of several tapes the most.")
    samples_inside: float = Field(description="Share of the samples that lie in the tape, 0 to 1.")


class GraphNode(_Answer):
    """A fork or an end of the skeleton."""

    location: Coordinates
    radius: float = Field(description="Half-width of the tape there.")
    degree: int = Field(description="Number of edges that end there: 1 at an end, 3 or more at a fork.")
    component: int


class GraphEdge(_Answer):
    """A stretch of the skeleton between two nodes."""

    nodes: Annotated[list[int], Field(min_length=2, max_length=2)] = Field(
        description="Indices of the nodes at its first and its last vertex; one twice for a loop."
    )
    vertices: list[Coordinates]
    widths: list[float] = Field(description="Width of the tape at each vertex.")
    length: float


class Graph(_Answer):
    """The skeleton without hair."""

    nodes: list[GraphNode]
    edges: list[GraphEdge]


Pair = Annotated[list[int], Field(min_length=2, max_length=2)]


class Delaunay(_Answer):
    """The Delaunay triangles of the samples, and which of them are small (§4.4)."""

    triangles: list[Annotated[list[int], Field(min_length=3, max_length=3)]] = Field(
        description="Indices of points of the input."
    )
    enclosed: list[bool] = Field(description="For each triangle: kept for lying in a local ball.")
    small_area: list[bool] = Field(description="For each triangle: kept for its area.")
    short_edges: list[bool] = Field(description="For each triangle: kept for its longest edge.")
    accepted: list[bool] = Field(description="For each triangle: part of the tape; false holes are filled.")
    bridges: list[Pair] = Field(description="Edges kept without a triangle, as indices of points.")


class SkeletonStages(_Answer):
    """Intermediate results of the skeleton method."""

    balls: list[Ball] = Field(description="The local balls that gave the typical triangles.")
    delaunay: Delaunay
    border: list[list[Coordinates]] = Field(
        description="The tape's border, resampled; loops, which do not repeat their first vertex."
    )
    voronoi: list[Annotated[list[Coordinates], Field(min_length=2, max_length=2)]] = Field(
        description="The two ends of each Voronoi edge that is dual to an edge in the tape, hair included."
    )


class SkeletonAnswer(_Reconstruction):
    """Curves, the tape polygon and the skeleton that they were read from."""

    method: Literal["skeleton"]
    tape: MultiPolygon = Field(description="The tape polygon T (§4.4).")
    tape_components: list[int] = Field(description="For each polygon of the tape: its component.")
    containment: Containment | None = Field(
        description="Null without a tape: sparse or collinear samples are joined to their neighbours instead."
    )
    graph: Graph
    stages: SkeletonStages | None = Field(None, description="Only when `include` names it.")


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
