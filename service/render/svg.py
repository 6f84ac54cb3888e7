"""Scenes as SVG, written directly: small, crisp at any size, and without anything to fetch."""

from __future__ import annotations

from html import escape

import numpy as np
from numpy.typing import NDArray

from service.render.scenes import Circle, Dots, Path, Scene

__all__ = ["MAX_DOTS", "draw_svg"]

MAX_DOTS = 20_000
"""More dots than this are thinned out: a picture of a million weighs 15 MB and shows no more."""

Floats = NDArray[np.float64]
_LONG_SIDE = 800.0
_MARGIN = 16.0
_DASHES = ("", "8 3", "2 3", "8 3 2 3")


class _Sheet:
    """Maps the scene's coordinates, y up, to those of the sheet, y down, with equal scales."""

    def __init__(self, scene: Scene) -> None:
        self.low, high = scene.bounds()
        extent = high - self.low
        longest = float(extent.max())
        self.scale = (_LONG_SIDE - 2 * _MARGIN) / longest if longest > 0 else 1.0
        self.width, self.height = (np.maximum(extent * self.scale, 1.0) + 2 * _MARGIN).tolist()
        self.box = (*self.low.tolist(), *high.tolist())

    def place(self, points: Floats) -> Floats:
        at = (points - self.low) * self.scale + _MARGIN
        at[:, 1] = self.height - at[:, 1]
        return at


def draw_svg(scene: Scene) -> bytes:
    """Draw a scene as an SVG document (UTF-8)."""
    sheet = _Sheet(scene)
    total = sum(len(group.points) for group in scene.dots)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {sheet.width:.2f} {sheet.height:.2f}"'
        f' width="{sheet.width:.0f}" height="{sheet.height:.0f}" role="img">',
        f"<title>{escape(scene.title)}</title>",
        f"<desc>{escape(_description(scene, sheet, total))}</desc>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    share = min(1.0, MAX_DOTS / total) if total else 1.0
    lines += [_dots(group, sheet, share) for group in scene.dots]
    if scene.circles:
        lines += _circles(scene.circles, sheet)
    lines += [_path(path, sheet) for path in scene.paths]
    return "\n".join([*lines, "</svg>", ""]).encode()


def _description(scene: Scene, sheet: _Sheet, total: int) -> str:
    x0, y0, x1, y1 = sheet.box
    text = f"x from {x0:.6g} to {x1:.6g}, y from {y0:.6g} to {y1:.6g}"
    if scene.unit != 1.0:
        text += f", in units of {scene.unit:.6g}"
    text += f"; {len(scene.paths)} curves, {total} points"
    if total > MAX_DOTS:
        text += f", of which about {MAX_DOTS} are drawn, chosen at random with a fixed seed"
    return text + "."


def _dots(group: Dots, sheet: _Sheet, share: float) -> str:
    """Draw dots as the round caps of lines without length: a third of the bytes of circles."""
    points = group.points
    if share < 1.0:
        count = max(1, round(share * len(points)))
        kept = np.random.default_rng(0).choice(len(points), count, replace=False, shuffle=False)
        points = points[np.sort(kept)]
    marks = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in sheet.place(points).tolist())
    size = 3.0 if len(points) <= 2000 else 1.8
    return (
        f'<path class="dots" d="{marks}" stroke="{group.colour}" stroke-width="{size}"'
        ' stroke-linecap="round" fill="none"/>'
    )


def _circles(circles: tuple[Circle, ...], sheet: _Sheet) -> list[str]:
    centres = sheet.place(np.array([[circle.x, circle.y] for circle in circles])).tolist()
    shapes = [
        f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{circle.radius * sheet.scale:.2f}"/>'
        for circle, (x, y) in zip(circles, centres, strict=True)
    ]
    return [
        '<g class="balls" fill="none" stroke="#6F6F6F" stroke-width="0.8" opacity="0.7">',
        *shapes,
        "</g>",
    ]


def _path(path: Path, sheet: _Sheet) -> str:
    places = " ".join(f"{x:.2f} {y:.2f}" for x, y in sheet.place(path.vertices).tolist())
    steps = f"M{places}{'Z' if path.closed else ''}" if places else ""
    dashes = _DASHES[path.turn % len(_DASHES)]
    dashing = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<path class="curve" d="{steps}" fill="none" stroke="{path.colour}" stroke-width="2"'
        f' stroke-linejoin="round" stroke-linecap="round"{dashing}>'
        f"<title>{escape(path.name)}</title></path>"
    )
