"""The built-in point sets as answers; runs in the workers, for :mod:`core.truth` needs scipy."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np

from core.errors import InvalidInput
from core.truth import PointSet, describe, names, point_set
from core.truth.point_sets import family
from service.errors import NotFound
from service.problems import Problem, problem
from service.render import dump_json, points_table
from service.work.tasks import Answer

__all__ = ["catalogue", "draw"]


def catalogue() -> list[dict[str, Any]]:
    """Name, description and defaults of each point set, as in :class:`service.answers.ExampleSummary`."""
    return [{"name": name, "description": describe(name), "defaults": _defaults(name)} for name in names()]


def draw(name: str, chosen: dict[str, Any], form: str, media_type: str) -> Answer | Problem:
    """Draw a point set.

    Parameters
    ----------
    name : str
    chosen : dict
        ``n``, ``sigma``, ``outliers`` and ``seed``, as far as they are not to be the defaults.
    form, media_type : str
        How to write it: json, csv or npy.
    """
    if name not in names():
        return problem(NotFound("there is no point set of this name; /examples lists them"))
    arguments = _defaults(name) | chosen
    try:
        sample = point_set(name, **arguments)
    except (InvalidInput, MemoryError) as error:
        return problem(error, where=("query",))
    return Answer(_WRITERS[form](sample, arguments), media_type)


def _defaults(name: str) -> dict[str, Any]:
    chosen = family(name)
    return {"n": chosen.size, "sigma": chosen.sigma, "outliers": 0.0, "seed": 0}


def _json(sample: PointSet, arguments: dict[str, Any]) -> bytes:
    truth = {
        "sigma": sample.sigma,
        "curves": [
            {"vertices": one.vertices, "closed": one.closed, "length": one.length} for one in sample.curves
        ],
        "curve_of": sample.curve_of,
        "crossings": sample.crossings,
    }
    document = {
        "name": sample.name,
        "description": describe(sample.name),
        "parameters": arguments,
        "points": sample.points,
        "truth": truth,
    }
    return dump_json(document)


def _csv(sample: PointSet, _arguments: dict[str, Any]) -> bytes:
    return points_table(sample.points)


def _npy(sample: PointSet, _arguments: dict[str, Any]) -> bytes:
    file = BytesIO()
    np.save(file, sample.points)
    return file.getvalue()


_WRITERS: dict[str, Callable[[PointSet, dict[str, Any]], bytes]] = {"json": _json, "csv": _csv, "npy": _npy}
