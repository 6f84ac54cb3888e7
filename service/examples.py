"""The built-in point sets as answers, and solids as scans; runs in the workers, for it needs scipy."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np

from core.errors import InvalidInput
from core.truth import PointSet, Scanner, describe, names, point_set, scan, solid, solid_names
from core.truth.point_sets import family
from service.errors import NotFound
from service.problems import Problem, problem
from service.render import dump_json, points_table
from service.render.range_grids import write_conf, write_range_ply
from service.work.tasks import Answer

__all__ = ["catalogue", "draw", "scan_files", "solids"]


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


def solids() -> dict[str, str]:
    """Describe the built-in solids, by name."""
    return {name: solid(name).description for name in solid_names()}


def scan_files(name: str, chosen: dict[str, Any]) -> dict[str, bytes]:
    """Scan a solid from all sides.

    Parameters
    ----------
    name : str
    chosen : dict
        ``views``, ``pixels``, ``sigma`` (a fraction of the size) and ``seed``, as far as they are not to
        be the defaults.

    Returns
    -------
    dict of str to bytes
        PLY range grids by the names of their files, and the ``.conf`` file with their poses.

    Raises
    ------
    InvalidParameter
        For a scanner without views or pixels, or with negative noise.
    """
    one = solid(name)
    settings = {key: value for key, value in chosen.items() if key != "sigma"}
    if "sigma" in chosen:
        settings["noise"] = chosen["sigma"] * one.extent
    images = scan(one, Scanner(**settings))
    width = len(str(len(images) - 1))
    files = {f"{name}{k:0{width}}.ply": image for k, image in enumerate(images)}
    poses = {key: image.pose for key, image in files.items() if image.pose is not None}
    return {key: write_range_ply(image) for key, image in files.items()} | {f"{name}.conf": write_conf(poses)}


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
