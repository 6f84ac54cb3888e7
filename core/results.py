"""What the core answers with: frozen dataclasses over numpy arrays.

Coordinates are in the frame, the units and the dimension (2 or 3, ``d`` below)
of the input. The field names are those of the HTTP contract.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from core.sampling_block import ComponentSampling, CurveGap, Nyquist, Sampling, SigmaAlong, Violation

__all__ = [
    "Ball",
    "Component",
    "ComponentSampling",
    "Containment",
    "Crossing",
    "Curve",
    "CurveGap",
    "Delaunay",
    "Diagnosis",
    "Evidence",
    "Frame",
    "Graph",
    "GraphEdge",
    "GraphNode",
    "Nyquist",
    "Partition",
    "Reconstruction",
    "Sampling",
    "SigmaAlong",
    "SkeletonStages",
    "Stages",
    "TapePolygon",
    "Violation",
    "Warn",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Warn:
    """Something that the caller should know, with a stable ``code`` and, when it has one, a place."""

    code: str
    message: str
    location: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Right-handed orthonormal frame [X_p Y_p Z_p O_p] of a component (§3.1).

    Attributes
    ----------
    component : int
    origin : (3,) array
        O_p, the centre of gravity; z = 0 for 2D input.
    axes : (3, 3) array
        Rows X_p, Y_p, Z_p by decreasing variance; Z_p is the normal of the best plane.
    planarity : float
        1 - sigma_z / sigma_y, between 0 (no plane) and 1 (exactly planar).
    """

    component: int
    origin: Floats
    axes: Floats
    planarity: float


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """A class S_i of extended neighbours (§3.3); ``bbox`` is (2, d): lower and upper corner."""

    label: int
    size: int
    bbox: Floats
    frame: Frame


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """The partition of a point set into extended neighbours; ``labels`` is (N,), -1 for outliers."""

    epsilon: float
    epsilon_source: str
    labels: Ints
    components: tuple[Component, ...]
    warnings: tuple[Warn, ...] = ()

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.components)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A piecewise-linear curve; a closed one does not repeat its first vertex.

    Attributes
    ----------
    vertices : (M, d) array
    closed : bool
    component : int
    length : float
        The closing edge of a closed curve included.
    samples : int
        Number of samples that this curve explains.
    rms_residual : float
        RMS distance of those samples from the curve.
    standard_errors : (M,) array or None
        Pointwise standard error at the vertices, across the curve; None where a stretch has no fit.
    """

    vertices: Floats
    closed: bool
    component: int
    length: float
    samples: int
    rms_residual: float
    standard_errors: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """A place where two curves (or one, twice) cross; ``angle`` in degrees, 0 to 90."""

    location: Floats
    curves: tuple[int, int]
    angle: float


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What speaks for and against one method's curves of a component.

    Attributes
    ----------
    component : int
    method : {"pca", "skeleton"}
    reason : str
        Why they were chosen, or not, in one sentence.
    curves, closed, crossings : int
        How many curves, how many of them closed, how many crossings.
    sigma : float
        Noise about them.
    explained : float
        Share of the samples that they explain, 0 to 1.
    largest_gap : float
        Longest stretch of curve without a sample, in mean distances between samples.
    nats : float
        How much longer the samples' description by them is than by the chosen ones; 0 for those.
    """

    component: int
    method: str
    reason: str
    curves: int
    closed: int
    crossings: int
    sigma: float
    explained: float
    largest_gap: float
    nats: float


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """A local ball B(p, r) of the march (§4.2.1) with its fitted direction v."""

    centre: Floats
    radius: float
    direction: Floats
    samples: int
    component: int


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """Intermediate results of the march, for pictures and for learning.

    ``balls`` in marching order; ``march`` the vertices before joining and refinement.
    """

    balls: tuple[Ball, ...] = ()
    march: tuple[Floats, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class TapePolygon:
    """A connected part of the tape polygon (§4.4.1): loops L_0 and L_1 ... L_m.

    Attributes
    ----------
    outer : (M, d) array
        The outer loop, counter-clockwise in the component's plane; the first vertex is not repeated.
    holes : tuple of (M, d) arrays
        Clockwise.
    component : int
    """

    outer: Floats
    holes: tuple[Floats, ...]
    component: int


@dataclass(frozen=True, slots=True, eq=False)
class Containment:
    """Whether the skeleton lies in the tape, SK(T) in T (§4.5), and the samples too.

    Attributes
    ----------
    covered : bool
    passes : int
        How often the border was resampled; of several components the most.
    samples_inside : float
        Share of the samples that lie in the tape, 0 to 1. Its border is a level of density, which
        Gaussian noise exceeds a little everywhere.
    """

    covered: bool
    passes: int
    samples_inside: float


@dataclass(frozen=True, slots=True, eq=False)
class GraphNode:
    """A fork or an end of the skeleton; ``radius`` is the tape's half-width there."""

    location: Floats
    radius: float
    degree: int
    component: int


@dataclass(frozen=True, slots=True, eq=False)
class GraphEdge:
    """A stretch of the skeleton between two nodes (one twice for a loop).

    Attributes
    ----------
    nodes : (int, int)
        Indices of the nodes at its first and last vertex.
    vertices : (M, d) array
    widths : (M,) array
        Width of the tape at the vertices.
    length : float
    """

    nodes: tuple[int, int]
    vertices: Floats
    widths: Floats
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """The skeleton without hair, as a graph."""

    nodes: tuple[GraphNode, ...]
    edges: tuple[GraphEdge, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Delaunay:
    """The Delaunay triangles of the samples and why some were kept (§4.4).

    Of more than 100 000 samples of a component a spread subsample is triangulated.

    Attributes
    ----------
    triangles : (T, 3) array of int
        Indices of points in the input.
    enclosed, small_area, short_edges, accepted : (T,) arrays of bool
        Kept for lying in a local ball, for their area, for their edges; and all that make the tape,
        false holes filled.
    bridges : (B, 2) array of int
        Edges kept without a triangle.
    """

    triangles: Ints
    enclosed: NDArray[np.bool_]
    small_area: NDArray[np.bool_]
    short_edges: NDArray[np.bool_]
    accepted: NDArray[np.bool_]
    bridges: Ints


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonStages:
    """Intermediate results of the skeleton method (Figs. 5 and 10).

    Attributes
    ----------
    balls : tuple of Ball
        Local balls that gave the typical triangles.
    delaunay : Delaunay
    border : tuple of (M, d) arrays
        The resampled loops of the tape's border.
    voronoi : (E, 2, d) array
        Ends of all Voronoi edges in the tape, hair included.
    """

    balls: tuple[Ball, ...]
    delaunay: Delaunay
    border: tuple[Floats, ...]
    voronoi: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Reconstruction:
    """Curves, and all that is known of how good they are.

    ``tape``, ``containment`` and ``graph`` of a skeleton only; ``decisions`` (one a component) and
    ``alternatives`` (what was not chosen) where there was a choice of methods.
    """

    method: str
    reason: str
    curves: tuple[Curve, ...]
    crossings: tuple[Crossing, ...]
    outliers: Ints
    sampling: Sampling
    frames: tuple[Frame, ...]
    warnings: tuple[Warn, ...] = ()
    tape: tuple[TapePolygon, ...] | None = None
    containment: Containment | None = None
    graph: Graph | None = None
    decisions: tuple[Evidence, ...] | None = None
    alternatives: tuple[Evidence, ...] | None = None
    stages: Stages | SkeletonStages | None = None
    labels: Ints = field(default_factory=lambda: np.zeros(0, np.int64), repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """What a point set is fit for: ``method`` and ``reason`` as ``Reconstruction`` would have them.

    Attributes
    ----------
    verdict : str
        Whether the samples are good enough, in one sentence.
    curves, closed, crossings : int
        How many would be found.
    outliers : (K,) array of int
        Indices of points that no curve explains.
    """

    method: str
    reason: str
    verdict: str
    curves: int
    closed: int
    crossings: int
    outliers: Ints
    sampling: Sampling
    frames: tuple[Frame, ...]
    decisions: tuple[Evidence, ...]
    alternatives: tuple[Evidence, ...]
    warnings: tuple[Warn, ...] = ()
