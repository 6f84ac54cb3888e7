"""Results as JSON documents, with the field names of the HTTP contract in its order.

Arrays stay arrays: ``orjson`` writes them without making a Python object of
each number. Numbers that are not finite become ``null``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import singledispatch
from typing import Any

import numpy as np
import orjson
from numpy.typing import ArrayLike, NDArray

from core.results import (
    Ball,
    ComponentSampling,
    Containment,
    Curve,
    CurveGap,
    Delaunay,
    Diagnosis,
    Evidence,
    Frame,
    Graph,
    Nyquist,
    Partition,
    Reconstruction,
    Sampling,
    SigmaAlong,
    SkeletonStages,
    Stages,
    TapePolygon,
    Violation,
    Warn,
)

__all__ = [
    "Document",
    "curve_document",
    "document",
    "dump_json",
    "floats",
    "multipolygon",
    "warning_document",
]

Document = dict[str, Any]


@singledispatch
def document(result: object) -> Document:
    """Return the JSON document of a result; register a function for each new type of result."""
    raise TypeError(f"no JSON document is defined for {type(result).__name__}")


def dump_json(value: object) -> bytes:
    """Write JSON; numpy arrays and numbers are allowed anywhere."""
    return orjson.dumps(value, option=orjson.OPT_SERIALIZE_NUMPY)


def floats(values: ArrayLike) -> NDArray[np.float64]:
    """Lay numbers out as ``orjson`` wants them: C-contiguous and in native byte order."""
    return np.ascontiguousarray(values, dtype=np.float64)


def _booleans(values: ArrayLike) -> NDArray[np.bool_]:
    return np.ascontiguousarray(values, dtype=np.bool_)


def _integers(values: ArrayLike) -> NDArray[np.int64]:
    return np.ascontiguousarray(values, dtype=np.int64)


@document.register
def _(result: Partition) -> Document:
    return {
        "epsilon": result.epsilon,
        "epsilon_source": result.epsilon_source,
        "count": result.count,
        "labels": _integers(result.labels),
        "components": [
            {
                "label": component.label,
                "size": component.size,
                "bbox": floats(component.bbox),
                "frame": _frame(component.frame),
            }
            for component in result.components
        ],
        "warnings": [warning_document(warning) for warning in result.warnings],
    }


@document.register
def _(result: Reconstruction) -> Document:
    stages = {} if result.stages is None else {"stages": _stages(result.stages)}
    return {
        "method": result.method,
        "reason": result.reason,
        "curves": [curve_document(curve) for curve in result.curves],
        "crossings": [
            {"location": floats(crossing.location), "curves": crossing.curves, "angle": crossing.angle}
            for crossing in result.crossings
        ],
        "outliers": _integers(result.outliers),
        "sampling": _sampling(result.sampling),
        "frames": [_frame(frame) for frame in result.frames],
        "warnings": [warning_document(warning) for warning in result.warnings],
        **_choice(result),
        **_skeleton(result),
        **stages,
    }


@document.register
def _(result: Diagnosis) -> Document:
    return {
        "verdict": result.verdict,
        "method": result.method,
        "reason": result.reason,
        "curves": result.curves,
        "closed": result.closed,
        "crossings": result.crossings,
        "outliers": _integers(result.outliers),
        "sampling": _sampling(result.sampling),
        "frames": [_frame(frame) for frame in result.frames],
        "decisions": [_evidence(evidence) for evidence in result.decisions],
        "alternatives": [_evidence(evidence) for evidence in result.alternatives],
        "warnings": [warning_document(warning) for warning in result.warnings],
    }


def _choice(result: Reconstruction) -> Document:
    """Why each component got its curves, where there was a choice of methods."""
    if result.decisions is None:
        return {}
    return {
        "decisions": [_evidence(evidence) for evidence in result.decisions],
        "alternatives": [_evidence(evidence) for evidence in result.alternatives or ()],
    }


def _evidence(evidence: Evidence) -> Document:
    return {
        "component": evidence.component,
        "method": evidence.method,
        "reason": evidence.reason,
        "curves": evidence.curves,
        "closed": evidence.closed,
        "crossings": evidence.crossings,
        "sigma": evidence.sigma,
        "explained": evidence.explained,
        "largest_gap": evidence.largest_gap,
        "nats": evidence.nats,
    }


def _skeleton(result: Reconstruction) -> Document:
    """What only the skeleton method finds.

    Where the skeleton was asked for, and the samples have no tape, it is an empty one; where there was
    a choice of methods, null.
    """
    if result.decisions is not None and not result.tape:
        return dict.fromkeys(("tape", "tape_components", "containment", "graph"))
    if result.tape is None:
        return {}
    return {
        "tape": multipolygon(result.tape),
        "tape_components": [polygon.component for polygon in result.tape],
        "containment": None if result.containment is None else _containment(result.containment),
        "graph": _graph(result.graph or Graph((), ())),
    }


def multipolygon(tape: Iterable[TapePolygon]) -> Document:
    """Return the GeoJSON geometry of polygons, whose rings repeat their first position."""
    rings = [[_ring(loop) for loop in (polygon.outer, *polygon.holes)] for polygon in tape]
    return {"type": "MultiPolygon", "coordinates": rings}


def _ring(loop: NDArray[np.float64]) -> NDArray[np.float64]:
    return floats(np.concatenate([loop, loop[:1]]))


def _containment(containment: Containment) -> Document:
    return {
        "covered": containment.covered,
        "passes": containment.passes,
        "samples_inside": containment.samples_inside,
    }


def _graph(graph: Graph) -> Document:
    return {
        "nodes": [
            {
                "location": floats(node.location),
                "radius": node.radius,
                "degree": node.degree,
                "component": node.component,
            }
            for node in graph.nodes
        ],
        "edges": [
            {
                "nodes": edge.nodes,
                "vertices": floats(edge.vertices),
                "widths": floats(edge.widths),
                "length": edge.length,
            }
            for edge in graph.edges
        ],
    }


def curve_document(curve: Curve) -> Document:
    """Return the document of a curve."""
    errors = curve.standard_errors
    return {
        "vertices": floats(curve.vertices),
        "closed": curve.closed,
        "component": curve.component,
        "length": curve.length,
        "samples": curve.samples,
        "rms_residual": curve.rms_residual,
        "standard_errors": None if errors is None else floats(errors),
    }


def _sampling(sampling: Sampling) -> Document:
    gap = sampling.largest_gap
    return {
        "sigma": sampling.sigma,
        "sigma_error": sampling.sigma_error,
        "density": sampling.density,
        "epsilon": sampling.epsilon,
        "nyquist": _nyquist(sampling.nyquist),
        "sigma_along": [_sigma_along(along) for along in sampling.sigma_along],
        "largest_gap": None if gap is None else _gap(gap),
        "components": [_component_sampling(component) for component in sampling.components],
    }


def _nyquist(nyquist: Nyquist) -> Document:
    place = nyquist.margin_location
    return {
        "compliant": nyquist.compliant,
        "margin_sigmas": nyquist.margin_sigmas,
        "margin_location": None if place is None else floats(place),
        "violations": [_violation(violation) for violation in nyquist.violations],
    }


def _violation(violation: Violation) -> Document:
    return {
        "location": floats(violation.location),
        "gap_sigmas": violation.gap_sigmas,
        "reason": violation.reason,
        "kind": violation.kind,
        "advice": violation.advice,
    }


def _sigma_along(along: SigmaAlong) -> Document:
    return {"curve": along.curve, "locations": floats(along.locations), "sigma": floats(along.sigma)}


def _gap(gap: CurveGap) -> Document:
    return {
        "location": floats(gap.location),
        "curve": gap.curve,
        "length": gap.length,
        "spacings": gap.spacings,
        "expected": gap.expected,
    }


def _component_sampling(component: ComponentSampling) -> Document:
    return {
        "label": component.label,
        "size": component.size,
        "sigma": component.sigma,
        "sigma_error": component.sigma_error,
        "density": component.density,
    }


def _frame(frame: Frame) -> Document:
    return {
        "component": frame.component,
        "origin": floats(frame.origin),
        "axes": floats(frame.axes),
        "planarity": frame.planarity,
    }


def _stages(stages: Stages | SkeletonStages) -> Document:
    balls = [_ball(ball) for ball in stages.balls]
    if isinstance(stages, Stages):
        return {"balls": balls, "march": [floats(vertices) for vertices in stages.march]}
    return {
        "balls": balls,
        "delaunay": _delaunay(stages.delaunay),
        "border": [floats(loop) for loop in stages.border],
        "voronoi": floats(stages.voronoi),
    }


def _ball(ball: Ball) -> Document:
    return {
        "centre": floats(ball.centre),
        "radius": ball.radius,
        "direction": floats(ball.direction),
        "samples": ball.samples,
        "component": ball.component,
    }


def _delaunay(delaunay: Delaunay) -> Document:
    return {
        "triangles": _integers(delaunay.triangles),
        "enclosed": _booleans(delaunay.enclosed),
        "small_area": _booleans(delaunay.small_area),
        "short_edges": _booleans(delaunay.short_edges),
        "accepted": _booleans(delaunay.accepted),
        "bridges": _integers(delaunay.bridges),
    }


def warning_document(warning: Warn) -> Document:
    """Return the document of a warning."""
    place = {} if warning.location is None else {"location": floats(warning.location)}
    return {"code": warning.code, "message": warning.message, **place}
