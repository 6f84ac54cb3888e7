"""Scenes as PNG with axes and ticks, by matplotlib's object interface: no global state, no display."""

from __future__ import annotations

import math
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from service.render.scenes import Scene, Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.path import Path

__all__ = ["draw_png"]

Floats = NDArray[np.float64]
_DPI = 120
_LONG_SIDE, _PANEL_SIDE, _HEAD = 8.0, 4.5, 0.6  # inches
_FINE = 0.6  # width of a panel's pen
_MANY = 20_000  # more dots than this are counted per pixel instead of drawn one by one
_MAX_LEGEND = 8
_OVER_AREAS = 1.5  # matplotlib would lay images below everything
_WITH_LINES = 2  # and patches below all dots and lines
_DASHES = ("-", "--", ":", "-.")


def draw_png(picture: Scene | Sheet) -> bytes:
    """Draw a scene, or a sheet of scenes, as a PNG file."""
    # a second of imports, and fonts to look for: only those who ask for a PNG wait for it
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    if isinstance(picture, Sheet):
        _draw_panels(figure, picture)
    else:
        low, high = _limits(picture)
        figure.set_size_inches(_size(high - low, _LONG_SIDE))
        axes = figure.add_subplot()
        _draw(axes, picture, low, high, 1.0)
        _draw_legend(axes)
    file = BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def _draw_panels(figure: Figure, sheet: Sheet) -> None:
    low, high = _limits(sheet)
    width, height = _size(high - low, _PANEL_SIDE)
    rows = math.ceil(len(sheet.panels) / sheet.columns)
    figure.set_size_inches(sheet.columns * width, rows * (height + _HEAD))
    places = figure.subplots(rows, sheet.columns, squeeze=False, sharex=True, sharey=True).ravel()
    for scene, axes in zip(sheet.panels.values(), places, strict=False):
        _draw(axes, scene, low, high, _FINE)
        _draw_key(axes, scene)


def _draw(axes: Axes, scene: Scene, low: Floats, high: Floats, pen: float) -> None:
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_title(scene.title if scene.unit == 1.0 else f"{scene.title}, in units of {scene.unit:.6g}")
    if scene.bare:
        axes.set_axis_off()
    _draw_pictures(axes, scene)
    _draw_areas(axes, scene, pen)
    _draw_segments(axes, scene, pen)
    _draw_dots(axes, scene, low, high, pen)
    _draw_circles(axes, scene, pen)
    _draw_bands(axes, scene)
    for path in scene.paths:
        vertices = np.vstack([path.vertices, path.vertices[:1]]) if path.closed else path.vertices
        style = _DASHES[path.turn % len(_DASHES)]
        width = (1.2 if path.fine else 1.8) * pen
        axes.plot(*vertices.T, style, color=path.colour, linewidth=width, label=path.name)
    for group in scene.marks:
        axes.plot(
            *group.points.T,
            "o",
            color=group.colour,
            markerfacecolor="white",
            markersize=6.0 * pen,
            label=group.name,
        )


def _limits(picture: Scene | Sheet) -> tuple[Floats, Floats]:
    """Corners of the axes: those of the picture, and a margin that the floats there can resolve."""
    low, high = picture.bounds()
    size = float((high - low).max())
    margin = max(0.04 * size, 1e-12 * float(np.abs([low, high]).max())) or 0.5
    return low - margin, high + margin


def _size(extent: Floats, long_side: float) -> tuple[float, float]:
    """Size of a picture in inches: the shape of the scene, within reason."""
    width, height = np.maximum(extent / extent.max(), 0.3) * long_side
    return float(width), float(height)


def _draw_pictures(axes: Axes, scene: Scene) -> None:
    for picture in scene.pictures:
        (left, bottom), (right, top) = picture.low, picture.high
        axes.imshow(picture.pixels, origin="lower", extent=(left, right, bottom, top), aspect="equal")


def _draw_areas(axes: Axes, scene: Scene, pen: float) -> None:
    from matplotlib.patches import PathPatch  # noqa: PLC0415 # see draw_png

    for area in scene.areas:
        axes.add_patch(
            PathPatch(
                _outline(area.rings),
                facecolor=area.colour,
                edgecolor=area.line,
                linewidth=0.7 * pen,
                label=area.name,
            )
        )


def _draw_bands(axes: Axes, scene: Scene) -> None:
    """Fill all that the rings go around."""
    from matplotlib.patches import PathPatch  # noqa: PLC0415 # see draw_png

    for band in scene.bands:
        axes.add_patch(
            PathPatch(
                _outline(band.rings),
                facecolor=band.colour,
                linewidth=0,
                alpha=0.35,
                label=band.name,
                zorder=_WITH_LINES,
            )
        )


def _outline(rings: tuple[Floats, ...]) -> Path:
    from matplotlib.path import Path  # noqa: PLC0415 # see draw_png

    closed = [Path(np.concatenate([ring, ring[:1]]), closed=True) for ring in rings]
    return Path.make_compound_path(*closed)


def _draw_segments(axes: Axes, scene: Scene, pen: float) -> None:
    from matplotlib.collections import LineCollection  # noqa: PLC0415 # see draw_png

    for group in scene.segments:
        axes.add_collection(
            LineCollection(list(group.ends), colors=group.colour, linewidths=0.8 * pen, label=group.name)
        )


def _draw_dots(axes: Axes, scene: Scene, low: Floats, high: Floats, pen: float) -> None:
    if sum(len(group.points) for group in scene.dots) > _MANY:
        _draw_density(axes, scene, low, high, _LONG_SIDE * _DPI * pen)
        return
    for group in scene.dots:
        size = (3.0 if len(group.points) <= 2000 else 1.5) * pen
        axes.plot(
            *group.points.T, "o", color=group.colour, markersize=size, markeredgewidth=0, label=group.name
        )


def _draw_density(axes: Axes, scene: Scene, low: Floats, high: Floats, pixels: float) -> None:
    """Draw each group as an image: its colour, the darker the more points a pixel has."""
    from matplotlib.colors import to_rgb  # noqa: PLC0415 # see draw_png

    bins = np.maximum((high - low) / (high - low).max() * pixels, 1).astype(int)
    for group in scene.dots:
        counts = np.zeros(bins[::-1])
        column, row = np.minimum(((group.points - low) / (high - low) * bins).astype(int), bins - 1).T
        np.add.at(counts, (row, column), 1.0)
        usual = np.quantile(counts[counts > 0], 0.9)
        image = np.empty((*counts.shape, 4))
        image[..., :3] = to_rgb(group.colour)
        image[..., 3] = np.where(counts > 0, np.clip(0.3 + 0.7 * counts / usual, 0, 1), 0)
        box = (low[0], high[0], low[1], high[1])
        axes.imshow(
            image, origin="lower", extent=box, interpolation="nearest", aspect="equal", zorder=_OVER_AREAS
        )


def _draw_circles(axes: Axes, scene: Scene, pen: float) -> None:
    from matplotlib.collections import PatchCollection  # noqa: PLC0415 # see draw_png
    from matplotlib.patches import Circle  # noqa: PLC0415

    looks = sorted({(circle.colour, circle.name) for circle in scene.circles})
    for colour, name in looks:
        mine = [circle for circle in scene.circles if (circle.colour, circle.name) == (colour, name)]
        width = 1.2 if name else 0.6
        shapes: list[Any] = [Circle((circle.x, circle.y), circle.radius) for circle in mine]
        axes.add_collection(
            PatchCollection(shapes, facecolor="none", edgecolor=colour, linewidth=width * pen, alpha=0.7)
        )
        if name:  # a legend knows no collections
            axes.plot([], [], "o", markerfacecolor="none", markeredgecolor=colour, label=name)


def _draw_legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    told = dict(zip(labels, handles, strict=True))  # once, where several shapes share a name
    if 0 < len(told) <= _MAX_LEGEND:
        axes.legend(told.values(), told.keys(), loc="best", fontsize="small")


def _draw_key(axes: Axes, scene: Scene) -> None:
    """Say below a panel what its colours mean."""
    from matplotlib.patches import Patch  # noqa: PLC0415 # see draw_png

    handles = [Patch(color=colour, label=name) for name, colour in scene.key().items()]
    if handles:
        axes.legend(
            handles=handles,
            loc="upper center",
            bbox_to_anchor=(0.5, -0.14),
            ncols=2,
            fontsize="x-small",
            frameon=False,
        )
