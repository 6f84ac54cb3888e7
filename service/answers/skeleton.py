"""The tape polygon, its skeleton and what led to them, as answers have them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from service.answers.base import Answer, Coordinates, Pair
from service.answers.curves import Ball

__all__ = ["Containment", "Graph", "MultiPolygon", "SkeletonStages"]


class MultiPolygon(Answer):
    """A GeoJSON MultiPolygon (RFC 7946): rings repeat their first position; the first is the outer one."""

    type: Literal["MultiPolygon"]
    coordinates: list[
        Annotated[list[Annotated[list[Coordinates], Field(min_length=4)]], Field(min_length=1)]
    ] = Field(description="Polygons, each a list of rings: the outer loop L_0, then the holes.")


class Containment(Answer):
    """Whether the skeleton lies in the tape (§4.5), and the samples too."""

    covered: bool = Field(description="Whether all of the skeleton lies in the tape.")
    passes: int = Field(description="How often the tape's border was resampled; of several tapes the most.")
    samples_inside: float = Field(description="Share of the samples that lie in the tape, 0 to 1.")


class GraphNode(Answer):
    """A fork or an end of the skeleton."""

    location: Coordinates
    radius: float = Field(description="Half-width of the tape there.")
    degree: int = Field(description="Number of edges that end there: 1 at an end, 3 or more at a fork.")
    component: int


class GraphEdge(Answer):
    """A stretch of the skeleton between two nodes."""

    nodes: Pair = Field(
        description="Indices of the nodes at its first and its last vertex; one twice for a loop."
    )
    vertices: list[Coordinates]
    widths: list[float] = Field(description="Width of the tape at each vertex.")
    length: float


class Graph(Answer):
    """The skeleton without hair."""

    nodes: list[GraphNode]
    edges: list[GraphEdge]


class Delaunay(Answer):
    """The Delaunay triangles of the samples, and which of them are small (§4.4)."""

    triangles: list[Annotated[list[int], Field(min_length=3, max_length=3)]] = Field(
        description="Indices of points of the input."
    )
    enclosed: list[bool] = Field(description="For each triangle: kept for lying in a local ball.")
    small_area: list[bool] = Field(description="For each triangle: kept for its area.")
    short_edges: list[bool] = Field(description="For each triangle: kept for its longest edge.")
    accepted: list[bool] = Field(description="For each triangle: part of the tape; false holes are filled.")
    bridges: list[Pair] = Field(description="Edges kept without a triangle, as indices of points.")


class SkeletonStages(Answer):
    """Intermediate results of the skeleton method."""

    balls: list[Ball] = Field(description="The local balls that gave the typical triangles.")
    delaunay: Delaunay
    border: list[list[Coordinates]] = Field(
        description="The tape's border, resampled; loops, which do not repeat their first vertex."
    )
    voronoi: list[Annotated[list[Coordinates], Field(min_length=2, max_length=2)]] = Field(
        description="The two ends of each Voronoi edge that is dual to an edge in the tape, hair included."
    )
