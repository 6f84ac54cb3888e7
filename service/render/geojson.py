"""Results as GeoJSON (RFC 7946), in the coordinates of the input.

A closed curve is a ``LineString`` whose last position repeats the first, with
the property ``closed``, and not a ``Polygon``: the result is a curve and not
the region inside it, curves may be nested, and a figure-8 bounds no valid
polygon.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.results import Curve, Partition, Reconstruction
from service.render.documents import floats

__all__ = ["feature_collection"]

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
    return _collection(
        [
            _feature("MultiPoint", floats(points[group]), {"label": int(label), "size": len(group)})
            for label, group in zip(labels, groups, strict=True)
        ]
    )


@feature_collection.register
def _(result: Reconstruction, points: Floats | None = None) -> Feature:  # noqa: ARG001 # curves say it all
    """One LineString a curve, and one Point a crossing."""
    curves = [_curve(number, curve) for number, curve in enumerate(result.curves)]
    crossings = [
        _feature("Point", floats(crossing.location), {"curves": crossing.curves, "angle": crossing.angle})
        for crossing in result.crossings
    ]
    return _collection(curves + crossings)


def _curve(number: int, curve: Curve) -> Feature:
    vertices = floats(curve.vertices)
    if curve.closed or len(vertices) == 1:  # a LineString has at least two positions
        vertices = np.vstack([vertices, vertices[:1]])
    properties = {
        "curve": number,
        "component": curve.component,
        "closed": curve.closed,
        "length": curve.length,
        "samples": curve.samples,
        "rms_residual": curve.rms_residual,
    }
    return _feature("LineString", vertices, properties)


def _feature(kind: str, coordinates: Floats, properties: dict[str, Any]) -> Feature:
    return {
        "type": "Feature",
        "geometry": {"type": kind, "coordinates": coordinates},
        "properties": properties,
    }


def _collection(features: list[Feature]) -> Feature:
    return {"type": "FeatureCollection", "features": features}
