"""Scenes as SVG, written directly: small, crisp at any size, and without anything to fetch."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterator
from html import escape
from io import BytesIO
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from service.render.scenes import Area, Band, Circle, Dots, Marks, Path, Picture, Scene, Segments, Sheet

__all__ = ["MAX_DOTS", "draw_svg"]

MAX_DOTS = 20_000
"""More dots than this are thinned out: a picture of a million weighs 15 MB and shows no more."""

Floats = NDArray[np.float64]
_LONG_SIDE, _PANEL_SIDE = 800.0, 400.0
_FINE = 0.6  # width of a panel's pen
_MARGIN = 16.0
_HEAD, _LEAST_WIDTH = 44.0, 360.0  # room for a panel's title and key
_DASHES = ("", "8 3", "2 3", "8 3 2 3")
_FONT = 'font-family="system-ui, sans-serif"'


class _Paper:
    """Maps the scene's coordinates, y up, to those of the paper, y down, with equal scales.

    ``pen`` is what widths are multiplied by.
    """

    def __init__(self, bounds: tuple[Floats, Floats], long_side: float, pen: float) -> None:
        self.pen = pen
        self.low, high = bounds
        extent = high - self.low
        longest = float(extent.max())
        self.scale = (long_side - 2 * _MARGIN) / longest if longest > 0 else 1.0
        self.width, self.height = (np.maximum(extent * self.scale, 1.0) + 2 * _MARGIN).tolist()
        self.box = (*self.low.tolist(), *high.tolist())

    def place(self, points: Floats) -> Floats:
        at = (points - self.low) * self.scale + _MARGIN
        at[:, 1] = self.height - at[:, 1]
        return at


def draw_svg(picture: Scene | Sheet) -> bytes:
    """Draw a scene, or a sheet of scenes, as an SVG document (UTF-8)."""
    if isinstance(picture, Sheet):
        return _document(*_sheet(picture))
    paper = _Paper(picture.bounds(), _LONG_SIDE, 1.0)
    about = _description(picture, paper)
    return _document(picture.title, about, paper.width, paper.height, _shapes(picture, paper, MAX_DOTS))


def _document(title: str, about: str, width: float, height: float, lines: Iterator[str]) -> bytes:
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.2f} {height:.2f}"'
        f' width="{width:.0f}" height="{height:.0f}" role="img">',
        f"<title>{escape(title)}</title>",
        f"<desc>{escape(about)}</desc>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    return "\n".join([*head, *lines, "</svg>", ""]).encode()


def _description(scene: Scene, paper: _Paper) -> str:
    if scene.bare:
        return _extent(scene, paper) + "."
    total = _count(scene)
    text = f"{_extent(scene, paper)}; {len(scene.paths)} curves, {total} points"
    if total > MAX_DOTS:
        text += f", of which about {MAX_DOTS} are drawn, chosen at random with a fixed seed"
    return text + "."


def _extent(scene: Scene, paper: _Paper) -> str:
    x0, y0, x1, y1 = paper.box
    text = (
        f"{x1 - x0:.6g} wide, {y1 - y0:.6g} high"
        if scene.bare
        else f"x from {x0:.6g} to {x1:.6g}, y from {y0:.6g} to {y1:.6g}"
    )
    return text if scene.unit == 1.0 else f"{text}, in units of {scene.unit:.6g}"


def _count(scene: Scene) -> int:
    return sum(len(group.points) for group in scene.dots)


# --- sheets -----------------------------------------------------------------------------------------


def _sheet(sheet: Sheet) -> tuple[str, str, float, float, Iterator[str]]:
    """Lay the panels out in rows, read like a text."""
    paper = _Paper(sheet.bounds(), _PANEL_SIDE, _FINE)
    columns = sheet.columns
    rows = math.ceil(len(sheet.panels) / columns)
    width, height = max(paper.width, _LEAST_WIDTH), paper.height + _HEAD
    corners = [(width * (k % columns), height * (k // columns)) for k in range(len(sheet.panels))]
    about = _extent(next(iter(sheet.panels.values())), paper) + " in each of the pictures."
    return sheet.title, about, width * columns, height * rows, _panels(sheet, paper, width, corners)


def _panels(sheet: Sheet, paper: _Paper, width: float, corners: list[tuple[float, float]]) -> Iterator[str]:
    """Draw each panel under its title, with a view of its own: ``sheet.svg#name`` shows it alone."""
    for (name, scene), (x, y) in zip(sheet.panels.items(), corners, strict=True):
        box = f"{x:.2f} {y:.2f} {width:.2f} {paper.height + _HEAD:.2f}"
        yield f'<view id="{name}" viewBox="{box}"/>'
        yield f'<g class="panel" transform="translate({x:.2f} {y:.2f})">'
        yield f'<text x="{_MARGIN}" y="20" {_FONT} font-size="14">{escape(scene.title)}</text>'
        yield _key(scene)
        yield f'<svg y="{_HEAD}" width="{paper.width:.2f}" height="{paper.height:.2f}">'
        yield from _shapes(scene, paper, MAX_DOTS // 2)
        yield "</svg></g>"


def _key(scene: Scene) -> str:
    words = "".join(
        f'<tspan fill="{colour}">■</tspan> {escape(name)} ' for name, colour in scene.key().items()
    )
    return f'<text x="{_MARGIN}" y="38" {_FONT} font-size="11">{words}</text>' if words else ""


# --- shapes -----------------------------------------------------------------------------------------


def _shapes(scene: Scene, paper: _Paper, most_dots: int) -> Iterator[str]:
    """Draw the shapes of a scene, the lowest first."""
    total = _count(scene)
    share = min(1.0, most_dots / total) if total else 1.0
    yield from (_picture(picture, paper) for picture in scene.pictures)
    yield from (_area(area, paper) for area in scene.areas)
    yield from (_segments(group, paper) for group in scene.segments)
    yield from (_dots(group, paper, share) for group in scene.dots)
    if scene.circles:
        yield from _circles(scene.circles, paper)
    yield from (_band(band, paper) for band in scene.bands)
    yield from (_path(path, paper) for path in scene.paths)
    yield from (_marks(group, paper) for group in scene.marks)


def _picture(picture: Picture, paper: _Paper) -> str:
    """Put pixels in as a PNG of their own."""
    from PIL import Image  # noqa: PLC0415 # only such pictures need it

    file = BytesIO()
    Image.fromarray(picture.pixels[::-1]).save(file, format="png")
    (left, bottom), (right, top) = paper.place(np.array([picture.low, picture.high])).tolist()
    return (
        f'<image x="{left:.2f}" y="{top:.2f}" width="{right - left:.2f}" height="{bottom - top:.2f}"'
        f' preserveAspectRatio="none" href="data:image/png;base64,{b64encode(file.getvalue()).decode()}"/>'
    )


def _area(area: Area, paper: _Paper) -> str:
    return (
        f'<path class="area" d="{_outline(area.rings, paper, 1)}" fill="{area.colour}"'
        f' fill-rule="evenodd" stroke="{area.line}" stroke-width="{0.8 * paper.pen:g}"'
        ' stroke-linejoin="round">'
        f"<title>{escape(area.name)}</title></path>"
    )


def _band(band: Band, paper: _Paper) -> str:
    """Draw all that the rings go around (the rule ``nonzero``): bands may cross themselves."""
    return (
        f'<path class="band" d="{_outline(band.rings, paper, 2)}" fill="{band.colour}" fill-opacity="0.35">'
        f"<title>{escape(band.name)}</title></path>"
    )


def _outline(rings: tuple[Floats, ...], paper: _Paper, digits: int) -> str:
    places = paper.place(np.concatenate(rings)).tolist()
    written = [f"{x:.{digits}f} {y:.{digits}f}" for x, y in places]
    starts = np.cumsum([0, *map(len, rings)])
    return "".join(f"M{' '.join(written[start:end])}Z" for start, end in pairwise(starts))


def _segments(group: Segments, paper: _Paper) -> str:
    ends = paper.place(group.ends.reshape(-1, 2)).reshape(-1, 4).tolist()
    lines = "".join(f"M{x:.1f} {y:.1f} {u:.1f} {v:.1f}" for x, y, u, v in ends)
    return (
        f'<path class="segments" d="{lines}" stroke="{group.colour}" stroke-width="{paper.pen:g}"'
        ' fill="none"/>'
    )


def _dots(group: Dots, paper: _Paper, share: float) -> str:
    """Draw dots as the round caps of lines without length: a third of the bytes of circles."""
    points = group.points
    if share < 1.0:
        count = max(1, round(share * len(points)))
        kept = np.random.default_rng(0).choice(len(points), count, replace=False, shuffle=False)
        points = points[np.sort(kept)]
    marks = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in paper.place(points).tolist())
    size = (3.0 if len(points) <= 2000 else 1.8) * paper.pen
    return (
        f'<path class="dots" d="{marks}" stroke="{group.colour}" stroke-width="{size:g}"'
        ' stroke-linecap="round" fill="none"/>'
    )


def _circles(circles: tuple[Circle, ...], paper: _Paper) -> Iterator[str]:
    """Draw circles, those of one look in one group."""
    for (colour, name), group in groupby(circles, key=lambda circle: (circle.colour, circle.name)):
        width = (1.5 if name else 0.8) * paper.pen
        yield f'<g class="balls" fill="none" stroke="{colour}" stroke-width="{width:g}" opacity="0.7">'
        yield from (_circle(circle, paper) for circle in group)
        yield f"<title>{escape(name)}</title></g>" if name else "</g>"


def _circle(circle: Circle, paper: _Paper) -> str:
    ((x, y),) = paper.place(np.array([[circle.x, circle.y]])).tolist()
    return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{circle.radius * paper.scale:.2f}"/>'


def _path(path: Path, paper: _Paper) -> str:
    places = " ".join(f"{x:.2f} {y:.2f}" for x, y in paper.place(path.vertices).tolist())
    steps = f"M{places}{'Z' if path.closed else ''}" if places else ""
    dashes = _DASHES[path.turn % len(_DASHES)]
    dashing = f' stroke-dasharray="{dashes}"' if dashes else ""
    width = (1.2 if path.fine else 2) * paper.pen
    return (
        f'<path class="curve" d="{steps}" fill="none" stroke="{path.colour}"'
        f' stroke-width="{width:g}" stroke-linejoin="round" stroke-linecap="round"{dashing}>'
        f"<title>{escape(path.name)}</title></path>"
    )


def _marks(group: Marks, paper: _Paper) -> str:
    """Draw rings: a larger dot, and a white one on it."""
    places = "".join(f"M{x:.2f} {y:.2f}h0" for x, y in paper.place(group.points).tolist())
    return "".join(
        f'<path class="mark" d="{places}" stroke="{colour}" stroke-width="{size * paper.pen:g}"'
        f' stroke-linecap="round" fill="none"><title>{escape(group.name)}</title></path>'
        for colour, size in ((group.colour, 8.0), ("#FFFFFF", 5.0))
    )
