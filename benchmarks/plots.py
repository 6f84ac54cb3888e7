"""How the pictures of the docs are drawn: one style, no dates, so that the same data give the same file."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from PIL import Image

__all__ = ["CLOUD", "FOLDER", "RESULT", "TAPE", "TRUTH", "closed_line", "new", "save"]

CLOUD, RESULT, TRUTH, TAPE = "0.72", "#c8102e", "#1f4e79", "#d3e2f0"
FOLDER = Path(__file__).parent.parent / "docs" / "figures"
DPI = 160  # twice what a README shows of a figure 9 inches wide
SHADES = 160  # of a picture of few colours; a palette takes a third of the bytes

mpl.rcParams.update(
    {
        "svg.hashsalt": "tapeline",
        "svg.fonttype": "none",
        "font.size": 9,
        "axes.titlesize": 9,
        "axes.spines.right": False,
        "axes.spines.top": False,
    }
)


def new(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Any, Any]:
    """Return a figure and its array of axes; ``size`` in inches, ``options`` those of ``plt.subplots``."""
    return plt.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained", **options)


def save(figure: Any, name: str, folder: Path = FOLDER, shaded: bool = False) -> Path:
    """Write a figure as PNG or SVG by its name, without anything that differs from run to run.

    Few colours are enough, unless surfaces are ``shaded``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if name.endswith(".svg"):
        figure.savefig(folder / name, metadata={"Date": None})
    else:
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png", dpi=DPI)
        picture = Image.open(drawn).convert("RGB")
        if not shaded:
            picture = picture.quantize(SHADES, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        picture.save(folder / name, optimize=True)
    plt.close(figure)
    return folder / name


def closed_line(vertices: NDArray[np.float64], closed: bool) -> NDArray[np.float64]:
    """Return the vertices with the first one repeated when the curve is closed."""
    return np.vstack((vertices, vertices[:1])) if closed else vertices
