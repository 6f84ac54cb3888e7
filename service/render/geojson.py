"""Results as GeoJSON (RFC 7946), in the coordinates of the input.

A closed curve is a ``LineString`` whose last position repeats the first, with
the property ``closed``, and not a ``Polygon``: the result is a curve and not
the region inside it, curves may be nested, and a figure-8 bounds no valid
polygon.

The property ``kind`` says what a feature is, and no two kinds share a type of
geometry: whoever takes every ``LineString`` for a curve and every ``Point`` for
a crossing is right whatever the method.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import singledispatch
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.results import Crossing, Curve, Graph, GraphEdge, GraphNode, Partition, Reconstruction, TapePolygon
from service.render.documents import floats, multipolygon

__all__ = ["Feature", "collection", "curve_feature", "feature", "feature_collection"]

Feature = dict[str, Any]
Floats = NDArray[np.float64]


@singledispatch
def feature_collection(result: object, points: Floats | None = None) -> Feature:  # noqa: ARG001 # registered functions use it
    """Return the GeoJSON of a result; register a function for each new type of result."""
    raise TypeError(f"no GeoJSON is defined for {type(result).__name__}")


@feature_collection.register
def _(result: Partition, points: Floats | None = None) -> Feature:
    """One MultiPoint a component, and one of the outliers with the label -1."""
    if points is None:
        raise TypeError("the GeoJSON of a partition needs the points")
    order = np.argsort(result.labels, kind="stable")
    labels, starts = np.unique(result.labels[order], return_index=True)
    groups = np.split(order, starts[1:]) if len(order) else []
    return collection(
        [
            feature("MultiPoint", floats(points[group]), {"label": int(label), "size": len(group)})
            for label, group in zip(labels, groups, strict=True)
        ]
    )


@feature_collection.register
def _(result: Reconstruction, points: Floats | None = None) -> Feature:  # noqa: ARG001 # curves say it all
    """One LineString a curve, one Point a crossing; then the tape and the graph of a skeleton, if any."""
    graph = result.graph or Graph((), ())
    return collection(
        [
            *[curve_feature(number, curve) for number, curve in enumerate(result.curves)],
            *[_crossing(crossing) for crossing in result.crossings],
            *_tape(result.tape or ()),
            *[_node(number, node) for number, node in enumerate(graph.nodes)],
            *[_edge(number, edge) for number, edge in enumerate(graph.edges)],
        ]
    )


def curve_feature(number: int, curve: Curve) -> Feature:
    """Return a curve as a LineString."""
    vertices, errors = floats(curve.vertices), curve.standard_errors
    if curve.closed or len(vertices) == 1:  # a LineString has at least two positions
        vertices = np.vstack([vertices, vertices[:1]])
        errors = None if errors is None else np.concatenate([errors, errors[:1]])
    properties = {
        "kind": "curve",
        "curve": number,
        "component": curve.component,
        "closed": curve.closed,
        "length": curve.length,
        "samples": curve.samples,
        "rms_residual": curve.rms_residual,
        "standard_errors": None if errors is None else floats(errors),  # one for each position
    }
    return feature("LineString", vertices, properties)


def _crossing(crossing: Crossing) -> Feature:
    properties = {"kind": "crossing", "curves": crossing.curves, "angle": crossing.angle}
    return feature("Point", floats(crossing.location), properties)


def _tape(tape: Iterable[TapePolygon]) -> list[Feature]:
    """One MultiPolygon a component."""
    components: dict[int, list[TapePolygon]] = {}
    for polygon in tape:
        components.setdefault(polygon.component, []).append(polygon)
    return [
        feature(
            "MultiPolygon",
            multipolygon(polygons)["coordinates"],
            {"kind": "tape", "component": component},
        )
        for component, polygons in components.items()
    ]


def _node(number: int, node: GraphNode) -> Feature:
    properties = {
        "kind": "node",
        "node": number,
        "component": node.component,
        "radius": node.radius,
        "degree": node.degree,
    }
    return feature("MultiPoint", [floats(node.location)], properties)


def _edge(number: int, edge: GraphEdge) -> Feature:
    properties = {
        "kind": "edge",
        "edge": number,
        "nodes": edge.nodes,
        "length": edge.length,
        "widths": floats(edge.widths),
    }
    return feature("MultiLineString", [floats(edge.vertices)], properties)


def feature(kind: str, coordinates: object, properties: dict[str, Any]) -> Feature:
    """Return a feature by its type of geometry."""
    return {
        "type": "Feature",
        "geometry": {"type": kind, "coordinates": coordinates},
        "properties": properties,
    }


def collection(features: list[Feature]) -> Feature:
    """Return the FeatureCollection of features."""
    return {"type": "FeatureCollection", "features": features}
