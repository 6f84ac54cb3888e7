"""How the pictures of the docs are drawn: one style, no dates, so that the same data give the same file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

__all__ = ["CLOUD", "RESULT", "TRUTH", "closed_line", "new", "save"]

CLOUD, RESULT, TRUTH = "0.72", "#c8102e", "#1f4e79"
FOLDER = Path(__file__).parent.parent / "docs" / "figures"

mpl.rcParams.update(
    {"svg.hashsalt": "tapeline", "svg.fonttype": "none", "font.size": 9, "axes.spines.right": False}
)


def new(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """Return a figure and its array of axes; ``size`` in inches."""
    return plt.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained")


def save(figure: Any, name: str, folder: Path = FOLDER) -> Path:
    """Write a figure as PNG or SVG by its name, without anything that differs from run to run."""
    folder.mkdir(parents=True, exist_ok=True)
    metadata = {"Date": None} if name.endswith(".svg") else {"Software": None}
    options = {} if name.endswith(".svg") else {"pil_kwargs": {"optimize": True}}
    figure.savefig(folder / name, dpi=90, metadata=metadata, **options)
    plt.close(figure)
    return folder / name


def closed_line(vertices: NDArray[np.float64], closed: bool) -> NDArray[np.float64]:
    """Return the vertices with the first one repeated when the curve is closed."""
    return np.vstack((vertices, vertices[:1])) if closed else vertices
