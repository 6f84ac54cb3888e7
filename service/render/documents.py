"""Results as JSON documents, with the field names of the HTTP contract in its order.

Arrays stay arrays: ``orjson`` writes them without making a Python object of
each number. Numbers that are not finite become ``null``.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np
import orjson
from numpy.typing import ArrayLike, NDArray

from core.results import Curve, Frame, Partition, Reconstruction, Sampling, Stages, Warn

__all__ = ["document", "dump_json", "floats"]

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
        "warnings": [_warning(warning) for warning in result.warnings],
    }


@document.register
def _(result: Reconstruction) -> Document:
    stages = {} if result.stages is None else {"stages": _stages(result.stages)}
    return {
        "method": result.method,
        "reason": result.reason,
        "curves": [_curve(curve) for curve in result.curves],
        "crossings": [
            {"location": floats(crossing.location), "curves": crossing.curves, "angle": crossing.angle}
            for crossing in result.crossings
        ],
        "outliers": _integers(result.outliers),
        "sampling": _sampling(result.sampling),
        "frames": [_frame(frame) for frame in result.frames],
        "warnings": [_warning(warning) for warning in result.warnings],
        **stages,
    }


def _curve(curve: Curve) -> Document:
    return {
        "vertices": floats(curve.vertices),
        "closed": curve.closed,
        "component": curve.component,
        "length": curve.length,
        "samples": curve.samples,
        "rms_residual": curve.rms_residual,
    }


def _sampling(sampling: Sampling) -> Document:
    return {
        "sigma": sampling.sigma,
        "density": sampling.density,
        "epsilon": sampling.epsilon,
        "nyquist": {
            "compliant": sampling.nyquist.compliant,
            "margin_sigmas": sampling.nyquist.margin_sigmas,
            "violations": [
                {
                    "location": floats(violation.location),
                    "gap_sigmas": violation.gap_sigmas,
                    "reason": violation.reason,
                }
                for violation in sampling.nyquist.violations
            ],
        },
    }


def _frame(frame: Frame) -> Document:
    return {
        "component": frame.component,
        "origin": floats(frame.origin),
        "axes": floats(frame.axes),
        "planarity": frame.planarity,
    }


def _stages(stages: Stages) -> Document:
    return {
        "balls": [
            {
                "centre": floats(ball.centre),
                "radius": ball.radius,
                "direction": floats(ball.direction),
                "samples": ball.samples,
                "component": ball.component,
            }
            for ball in stages.balls
        ],
        "march": [floats(vertices) for vertices in stages.march],
    }


def _warning(warning: Warn) -> Document:
    place = {} if warning.location is None else {"location": floats(warning.location)}
    return {"code": warning.code, "message": warning.message, **place}
