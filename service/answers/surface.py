"""The answers of the way from scans to a surface."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from service.answers.base import Answer, Vector, Warn
from service.answers.curves import Curve

__all__ = ["ContoursAnswer", "SliceAnswer", "SurfaceAnswer"]

Triple = Annotated[list[int], Field(min_length=3, max_length=3)]


class Slice(Answer):
    """What the plane at one height cuts of all scans."""

    height: float = Field(description="Along the axis.")
    points: list[Vector] = Field(description="Samples of the contours, in the plane.")
    polylines: list[list[Vector]] = Field(
        description="The same, linked; a closed one does not repeat its first vertex."
    )
    closed: list[bool] = Field(description="One for each polyline.")


class SliceAnswer(Answer):
    """Scans cut by parallel planes."""

    axis: Vector = Field(description="Unit vector across the planes.")
    slices: list[Slice] = Field(description="By height; empty where nothing is cut.")
    warnings: list[Warn]


class ContourLevel(Answer):
    """The contours at one height."""

    height: float = Field(description="Along the axis.")
    curves: list[Curve]
    completed: bool = Field(description="Whether samples were missing, and the neighbours filled in.")


class ContoursAnswer(Answer):
    """The contours of all levels."""

    axis: Vector = Field(description="Unit vector across the planes.")
    slices: list[ContourLevel] = Field(description="By height.")
    warnings: list[Warn]


class Mesh(Answer):
    """A triangle mesh."""

    vertices: list[Vector]
    faces: list[Triple] = Field(
        description="Indices of vertices, from 0, counter-clockwise seen from outside."
    )


class SurfaceReport(Answer):
    """What is known of a surface, computed from its mesh."""

    closed: bool = Field(description="Whether every edge has two faces.")
    manifold: bool = Field(description="Whether no edge has more, and the faces at every vertex are one fan.")
    components: int = Field(description="Parts that do not touch.")
    euler: int = Field(description="Vertices minus edges plus faces.")
    genus: int = Field(description="Handles, of all parts together.")
    volume: float
    area: float
    self_intersections: int = Field(description="Pairs of faces that cut each other.")
    completed_levels: list[float] = Field(description="Heights of levels completed from their neighbours'.")
    rms_residual: float | None = Field(
        description="RMS distance of the scan points to the mesh; null where contours were given."
    )
    method: Literal["slabs", "distance"] = Field(description="How the contours were spanned.")


class SurfaceAnswer(Answer):
    """One closed surface."""

    mesh: Mesh
    report: SurfaceReport
    slices: list[ContourLevel] | None = Field(
        None, description="The contours that it goes through; only when asked for."
    )
    warnings: list[Warn]
