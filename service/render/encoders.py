"""From results to bytes: one row a form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from service.render.csv import table
from service.render.documents import document, dump_json
from service.render.dxf import lines, write_dxf
from service.render.geojson import feature_collection
from service.render.meshes import mesh_of, write_glb, write_obj, write_ply, write_stl
from service.render.pictures import scene
from service.render.png import draw_png
from service.render.report import report
from service.render.svg import draw_svg

__all__ = ["encode"]

Floats = NDArray[np.float64]

_ENCODERS: dict[str, Callable[[Any, Floats | None], bytes]] = {
    "json": lambda result, _: dump_json(document(result)),
    "geojson": lambda result, points: dump_json(feature_collection(result, points)),
    "csv": table,
    "txt": lambda result, _: report(result).encode(),
    "svg": lambda result, points: draw_svg(scene(result, points)),
    "png": lambda result, points: draw_png(scene(result, points)),
    "dxf": lambda result, _: write_dxf(lines(result)),
    "stl": lambda result, _: write_stl(mesh_of(result)),
    "obj": lambda result, _: write_obj(mesh_of(result)),
    "ply": lambda result, _: write_ply(mesh_of(result)),
    "glb": lambda result, _: write_glb(mesh_of(result)),
}


def encode(result: object, form: str, points: Floats | None = None) -> bytes:
    """Write a result in one of the `FORMS`.

    Parameters
    ----------
    result : Partition, Reconstruction or another registered type
    form : str
        A key of `FORMS`.
    points : (N, d) array, optional
        The samples: pictures show them, and the forms of a partition need them.

    Raises
    ------
    KeyError
        For a form that does not exist.
    TypeError
        For a result that has no such form, or points that are missing.
    """
    return _ENCODERS[form](result, points)
