"""Figures 7 to 9: range images of a built-in bust, its levels, and the surface; and those of other solids."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from benchmarks.figures.layers import draw_cloud, frame, heading
from benchmarks.plots import RESULT, TRUTH, closed_line, new, save
from core.surface.methods import contours, slices, surface
from core.surface.parameters import SurfaceParameters
from core.surface.range_image import triangulate
from core.surface.results import ContourLevel, Contours, Mesh, Scans, Slices, Surface
from core.truth import Scanner, scan, solid
from service.render import stack_of
from service.render.plane import three_quarter
from service.render.shaded import brightness

__all__ = ["figure_7", "figure_8", "figure_9", "solids", "way"]

Floats = NDArray[np.float64]

LEVELS = 128
PIXELS = 500  # of a panel
STONE = "#7fa3c4"
SCANS = ("#5b9bd5", "#e6a65d", "#70ad77", "#c98bb9", "#d9c25a", "#8e9bd0", "#d98a7b", "#6fb7b7")
FILL, FILLED = "#e4eff7", "#fadfcb"
OTHERS = ("torus", "double_torus", "fork", "pair")


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """All that lies on the way from a solid to its surface."""

    meshes: tuple[Mesh, ...]
    slices: Slices
    contours: Contours
    surface: Surface


@lru_cache(maxsize=1)
def way_of(name: str, levels: int) -> Way:
    """Scan a built-in solid from twelve sides, and reconstruct it."""
    images = scan(solid(name), Scanner(views=12))
    scans, parameters = Scans(range_images=images), SurfaceParameters(levels=levels)
    cut, found, made = slices(scans, parameters), contours(scans, parameters), surface(scans, parameters)
    return Way(tuple(triangulate(image) for image in images), cut, found, made)


def looking(turn: float = 0.0) -> Floats:
    """Return the rows right, up and towards the eye, of a look from the front right, turned by degrees."""
    (sine, cosine) = np.sin(np.radians(turn)), np.cos(np.radians(turn))
    return three_quarter(np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))


def draw_meshes(
    axis: Any, meshes: tuple[Mesh, ...], look: Floats, colours: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Draw shaded meshes, each in its own colour, those nearer in front; tell where they are."""
    sizes = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    whole = Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + first for mesh, first in zip(meshes, sizes, strict=False)]),
    )
    group = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    low, high, image = brightness(whole, look, PIXELS, np.asarray(2.0 * group, np.float64))
    value = np.nan_to_num(np.abs(image))
    which = (value // 2.0).astype(int)
    fine = np.array([_ramp(colour) for colour in colours])[
        which % len(colours), (255 * (value % 2.0)).astype(int)
    ]
    fine[np.isnan(image)] = 1.0
    drawn = fine.reshape(image.shape[0] // 2, 2, -1, 2, 3).mean(axis=(1, 3))
    axis.imshow(drawn, origin="lower", extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased")
    frame(axis, np.array([low, high]))
    return low, high


def _ramp(colour: str) -> Floats:
    """Return (256, 3) tones of a colour, from dark to bright."""
    middle = np.array(to_rgb(colour))
    return np.array([np.interp(np.linspace(0, 1, 256), (0, 0.5, 1), (0.2 * c, c, 0.97)) for c in middle]).T


def figure_7() -> None:
    """Draw three range images as the scanner sees them, and all of them in their places."""
    found = way_of("bust", LEVELS)
    figure, axes = new(1, 4, (9, 2.7))
    look = looking()
    nearest = np.argsort([-_seen(mesh, look) for mesh in found.meshes], kind="stable")[:3]
    for panel, letter, k in zip(axes[0], "abc", nearest, strict=False):
        draw_meshes(panel, (found.meshes[k],), look, (SCANS[int(k) % len(SCANS)],))
        heading(panel, letter, f"range image {k + 1}")
    draw_meshes(axes[0, 3], found.meshes, look, SCANS)
    heading(axes[0, 3], "d", f"all {len(found.meshes)} in their places")
    save(figure, "surface_scans.png", shaded=True)


def _seen(mesh: Mesh, look: Floats) -> float:
    """Return how large a mesh is as seen from there."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] @ look[:2].T for k in range(3))
    return float(np.sum((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def figure_8() -> None:
    """Draw the slices, their contours, and a level that was completed."""
    found = way_of("bust", LEVELS)
    figure, axes = new(1, 3, (9, 3.2))
    draw_stack(axes[0, 0], found.slices)
    heading(axes[0, 0], "a", f"slices at {LEVELS} levels")
    draw_stack(axes[0, 1], found.contours)
    completed = [k for k, level in enumerate(found.contours.slices) if level.completed]
    heading(axes[0, 1], "b", f"contours, {len(completed)} of them completed")
    k = completed[0] if completed else LEVELS // 2
    draw_level(axes[0, 2], found.slices.slices[k].points, found.contours.slices[k])
    heading(axes[0, 2], "c", f"samples and contour of level {k}" + (", completed" if completed else ""))
    save(figure, "surface_contours.png")


def draw_stack(axis: Any, stack: Slices | Contours) -> None:
    """Draw a stack as the service's pictures have it."""
    shown = stack_of(stack)
    for area in shown.areas:
        fill, line = (FILLED, RESULT) if area.name == "completed" else (FILL, TRUTH)
        axis.add_collection(PolyCollection(list(area.rings), facecolor=fill, edgecolor=line, linewidth=0.35))
    for group in shown.segments:
        axis.add_collection(LineCollection(list(group.ends), color=TRUTH, linewidth=0.15))
    frame(axis, np.array(shown.bounds()))


def draw_level(axis: Any, points: Floats, level: ContourLevel) -> None:
    """Draw one level from above."""
    draw_cloud(axis, points[:, :2], 4.0, "0.55")
    for curve in level.curves:
        axis.plot(*closed_line(curve.vertices, curve.closed)[:, :2].T, color=RESULT, linewidth=0.8)
    frame(axis, points[:, :2])


def figure_9() -> None:
    """Draw the surface from three sides."""
    made = way_of("bust", LEVELS).surface
    figure, axes = new(1, 3, (9, 3.4))
    sides = {"front": -30.0, "side": 60.0, "back": 150.0}
    for panel, letter, (words, turn) in zip(axes[0], "abc", sides.items(), strict=True):
        draw_meshes(panel, (made.mesh,), looking(turn), (STONE,))
        heading(panel, letter, words)
    save(figure, "surface_mesh.png", shaded=True)


def solids() -> None:
    """Draw the surfaces of other solids, reconstructed from as many scans."""
    figure, axes = new(1, len(OTHERS), (9, 2.7))
    for panel, letter, name in zip(axes[0], "abcd", OTHERS, strict=True):
        made = way_of(name, LEVELS // 2).surface
        report = made.report
        low, high = draw_meshes(panel, (made.mesh,), looking(), (STONE,))
        middle, half = (low + high) / 2.0, np.max(high - low) / 2.0
        frame(panel, np.array([middle - half, middle + half]))  # all as high, so that titles are in line
        parts = f", {report.components} parts" if report.components > 1 else ""
        heading(panel, letter, f"genus {report.genus}{parts}")
    save(figure, "surface_solids.png", shaded=True)


def way() -> None:
    """Draw the whole way in one picture: scans, slices, contours and surface."""
    found = way_of("bust", LEVELS)
    figure, axes = new(1, 4, (9, 2.6))
    draw_meshes(axes[0, 0], found.meshes, looking(), SCANS)
    draw_stack(axes[0, 1], found.slices)
    draw_stack(axes[0, 2], found.contours)
    draw_meshes(axes[0, 3], (found.surface.mesh,), looking(), (STONE,))
    names = (f"{len(found.meshes)} scans", f"{LEVELS} slices", "contours", "surface")
    for panel, words in zip(axes[0], names, strict=True):
        heading(panel, "", words)
    save(figure, "surface_way.png", shaded=True)
