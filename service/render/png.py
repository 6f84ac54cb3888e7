"""Scenes as PNG with axes and ticks, by matplotlib's object interface: no global state, no display."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from service.render.scenes import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_png"]

Floats = NDArray[np.float64]
_DPI = 120
_LONG_SIDE = 8.0  # inches
_MANY = 20_000  # more dots than this are counted per pixel instead of drawn one by one
_MAX_LEGEND = 8
_DASHES = ("-", "--", ":", "-.")


def draw_png(scene: Scene) -> bytes:
    """Draw a scene as a PNG file."""
    # a second of imports, and fonts to look for: only those who ask for a PNG wait for it
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    low, high = _limits(scene)
    figure = Figure(figsize=_size(high - low), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_title(scene.title if scene.unit == 1.0 else f"{scene.title}, in units of {scene.unit:.6g}")
    _draw_dots(axes, scene, low, high)
    _draw_circles(axes, scene)
    for path in scene.paths:
        vertices = np.vstack([path.vertices, path.vertices[:1]]) if path.closed else path.vertices
        style = _DASHES[path.turn % len(_DASHES)]
        axes.plot(*vertices.T, style, color=path.colour, linewidth=1.8, label=path.name)
    _draw_legend(axes)
    file = BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def _limits(scene: Scene) -> tuple[Floats, Floats]:
    """Corners of the axes: those of the scene, and a margin that the floats there can resolve."""
    low, high = scene.bounds()
    size = float((high - low).max())
    margin = max(0.04 * size, 1e-12 * float(np.abs([low, high]).max())) or 0.5
    return low - margin, high + margin


def _size(extent: Floats) -> tuple[float, float]:
    """Size of the figure in inches: the shape of the scene, within reason."""
    width, height = np.maximum(extent / extent.max(), 0.3) * _LONG_SIDE
    return float(width), float(height)


def _draw_dots(axes: Axes, scene: Scene, low: Floats, high: Floats) -> None:
    if sum(len(group.points) for group in scene.dots) > _MANY:
        _draw_density(axes, scene, low, high)
        return
    for group in scene.dots:
        size = 3.0 if len(group.points) <= 2000 else 1.5
        axes.plot(
            *group.points.T, "o", color=group.colour, markersize=size, markeredgewidth=0, label=group.name
        )


def _draw_density(axes: Axes, scene: Scene, low: Floats, high: Floats) -> None:
    """Draw each group as an image: its colour, the darker the more points a pixel has."""
    from matplotlib.colors import to_rgb  # noqa: PLC0415 # see draw_png

    bins = np.maximum((high - low) / (high - low).max() * _LONG_SIDE * _DPI, 1).astype(int)
    for group in scene.dots:
        counts = np.zeros(bins[::-1])
        column, row = np.minimum(((group.points - low) / (high - low) * bins).astype(int), bins - 1).T
        np.add.at(counts, (row, column), 1.0)
        usual = np.quantile(counts[counts > 0], 0.9)
        image = np.empty((*counts.shape, 4))
        image[..., :3] = to_rgb(group.colour)
        image[..., 3] = np.where(counts > 0, np.clip(0.3 + 0.7 * counts / usual, 0, 1), 0)
        box = (low[0], high[0], low[1], high[1])
        axes.imshow(image, origin="lower", extent=box, interpolation="nearest", aspect="equal")


def _draw_circles(axes: Axes, scene: Scene) -> None:
    from matplotlib.collections import PatchCollection  # noqa: PLC0415 # see draw_png
    from matplotlib.patches import Circle  # noqa: PLC0415

    shapes: list[Any] = [Circle((circle.x, circle.y), circle.radius) for circle in scene.circles]
    if shapes:
        axes.add_collection(
            PatchCollection(shapes, facecolor="none", edgecolor="#6F6F6F", linewidth=0.6, alpha=0.7)
        )


def _draw_legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if 0 < len(handles) <= _MAX_LEGEND:
        axes.legend(handles, labels, loc="best", fontsize="small")
