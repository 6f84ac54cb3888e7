"""THE table of processes: one row for each thing that the service computes.

The routes, the OpenAPI document and the command line are derived from it. The
functions are named by import path, so that reading the table imports neither
scipy nor numba: only the workers resolve them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

from pydantic import BaseModel

from core.parameters import (
    PartitionParameters,
    PcaParameters,
    ReconstructParameters,
    SkeletonParameters,
)
from core.surface.parameters import ContourParameters, SliceParameters, SurfaceParameters
from service.answers import (
    ContoursAnswer,
    DiagnosisAnswer,
    PartitionAnswer,
    PcaAnswer,
    ReconstructAnswer,
    SkeletonAnswer,
    SliceAnswer,
    SurfaceAnswer,
)

__all__ = ["PROCESSES", "Process", "find", "process"]


@dataclass(frozen=True, slots=True)
class Process:
    """One row of the table.

    Attributes
    ----------
    id : str
        Name for programs; also the OpenAPI operation id, with underscores.
    path : str
        Where it is posted to.
    title, description : str
        For people; the description may have Markdown.
    parameters : type of BaseModel
        Its parameters, from :mod:`core.parameters` or :mod:`core.surface.parameters`.
    answer : type of BaseModel
        The JSON answer, from :mod:`service.answers`.
    function : str
        ``module:name`` of ``function(points or scans, parameters, *, progress, **{include: bool})``.
    include : frozenset of str
        Names allowed in ``include``; each is a flag of the function.
    forms : tuple of str
        Forms of the answer, the default first; keys of ``service.render.FORMS``.
    division : str or None
        ``module:name`` of the :class:`core.division.Division` by which large jobs fall into parts.
    takes : {"points", "scans"}
        What it works on: a point cloud, or :class:`core.surface.results.Scans`.
    """

    id: str
    path: str
    title: str
    description: str
    parameters: type[BaseModel]
    answer: type[BaseModel]
    function: str
    include: frozenset[str] = frozenset()
    forms: tuple[str, ...] = ("json", "geojson", "csv", "svg", "png", "dxf")
    division: str | None = None
    takes: Literal["points", "scans"] = "points"

    def resolve(self) -> Callable[..., Any]:
        """Import the function (in a worker or in the command line, never in the web process)."""
        module, _, name = self.function.partition(":")
        function: Callable[..., Any] = getattr(import_module(module), name)
        return function

    def flags(self, include: frozenset[str]) -> dict[str, bool]:
        """Say for each part that may be included whether it shall be."""
        return {name: name in include for name in self.include}


class DiagnoseParameters(ReconstructParameters):
    """Parameters of the diagnosis: those of the reconstruction that it speaks of."""


PROCESSES: tuple[Process, ...] = (
    Process(
        id="reconstruct",
        path="/reconstruct",
        title="Reconstruct curves by the method that the data call for",
        description="Runs the PCA march and the skeleton, and gives each component the curves that explain "
        "its samples better. `reason` says why, `alternatives` what the other method would have given. "
        "Curves have a standard error at each vertex, and `sampling` says whether the samples are good "
        "enough. Every parameter left out follows from the data.",
        parameters=ReconstructParameters,
        answer=ReconstructAnswer,
        function="core.methods:reconstruct",
        division="core.divisions:RECONSTRUCT",
        include=frozenset({"stages"}),
    ),
    Process(
        id="diagnose",
        path="/diagnose",
        title="Tell whether a point cloud is good enough, and which method it calls for",
        description="Tells noise, density, gaps and Nyquist compliance: whether the noise stays below half "
        "of the smallest detail. Each violation has its place, and says what to do about it. Curves are "
        "found as they are in `/reconstruct`, and only counted.",
        parameters=DiagnoseParameters,
        answer=DiagnosisAnswer,
        function="core.methods:diagnose",
        division="core.divisions:DIAGNOSE",
        forms=("json", "txt", "svg", "png"),
    ),
    Process(
        id="partition",
        path="/partition",
        title="Partition a point cloud into extended neighbours",
        description="Two points belong together when hops of at most `epsilon` from point to point lead from "
        "one to the other. Every point gets the label of its component, or -1 when it is an outlier.",
        parameters=PartitionParameters,
        answer=PartitionAnswer,
        function="core.methods:partition",
        forms=("json", "geojson", "csv", "svg", "png"),
    ),
    Process(
        id="reconstruct-pca",
        path="/reconstruct/pca",
        title="Reconstruct curves by the PCA march",
        description="Marches along each component from local ball to local ball, in the direction of its "
        "first principal axis, and refines what it finds. Every parameter left out follows from the data.",
        parameters=PcaParameters,
        answer=PcaAnswer,
        function="core.methods:pca",
        division="core.divisions:PCA",
        include=frozenset({"stages"}),
    ),
    Process(
        id="reconstruct-skeleton",
        path="/reconstruct/skeleton",
        title="Reconstruct curves by the tape polygon and its skeleton",
        description="Covers each component with a tape polygon, the small ones of the Delaunay triangles of "
        "its samples, and reads the curves from the tape's Voronoi skeleton. The tape, the skeleton as a "
        "graph with widths, and whether the one contains the other are part of the answer. `crossings` says "
        "how curves that cross are read. Every parameter left out follows from the data.",
        parameters=SkeletonParameters,
        answer=SkeletonAnswer,
        function="core.methods:skeleton",
        division="core.divisions:SKELETON",
        include=frozenset({"stages"}),
    ),
    Process(
        id="slice",
        path="/slice",
        title="Cut meshes and range images by parallel planes",
        description="Triangulates range images, without depth discontinuities and what is seen at a grazing "
        "angle, and cuts all meshes by planes across an axis. Each slice has its samples, and the polylines "
        "that they lie on.",
        parameters=SliceParameters,
        answer=SliceAnswer,
        function="core.surface.methods:slices",
        takes="scans",
    ),
    Process(
        id="reconstruct-contours",
        path="/reconstruct/contours",
        title="Reconstruct the closed contours of slices",
        description="Takes slices, or cuts meshes and range images as `/slice` does, and reconstructs the "
        "closed curves of each level. Levels whose samples leave gaps, or are missing, are completed from "
        "their neighbours, and named.",
        parameters=ContourParameters,
        answer=ContoursAnswer,
        function="core.surface.methods:contours",
        division="core.divisions:CONTOURS",
        takes="scans",
    ),
    Process(
        id="reconstruct-surface",
        path="/reconstruct/surface",
        title="Reconstruct one closed surface from range images, meshes, slices or contours",
        description="Reconstructs contours as `/reconstruct/contours` does, or takes those that are given, "
        "and spans them by a closed, oriented mesh: contours may branch, merge, begin and end, and be "
        "nested. The report is computed from the mesh itself.",
        parameters=SurfaceParameters,
        answer=SurfaceAnswer,
        function="core.surface.methods:surface",
        division="core.divisions:SURFACE",
        include=frozenset({"slices"}),
        forms=("json", "stl", "obj", "ply", "glb", "svg", "png"),
        takes="scans",
    ),
)


def process(identifier: str) -> Process:
    """Return the row with this id.

    Raises
    ------
    KeyError
        When there is none.
    """
    return find(PROCESSES, identifier)


def find(table: Iterable[Process], identifier: str) -> Process:
    """Return the row of a table with this id.

    Raises
    ------
    KeyError
        When there is none.
    """
    for row in table:
        if row.id == identifier:
            return row
    raise KeyError(identifier)
