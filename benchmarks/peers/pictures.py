"""The pictures of docs/peers.md: error over N, success over noise, time over N."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import plots
from benchmarks.peers.rows import Row
from benchmarks.peers.sets import Plan
from benchmarks.peers.summary import Figures, by_n, by_sigma, present, where

__all__ = ["ERROR", "SUCCESS", "TIME", "draw"]

ERROR, SUCCESS, TIME = "peers-error.svg", "peers-success.svg", "peers-time.svg"
SIZE = (6.5, 3.8)


def draw(rows: Sequence[Row], plan: Plan, folder: Path) -> None:
    """Draw all three into a folder."""
    _draw_error(rows, plan, folder)
    _draw_success(rows, plan, folder)
    _draw_time(rows, plan, folder)


def _draw_error(rows: Sequence[Row], plan: Plan, folder: Path) -> None:
    figure, axes = _new("N", "median RMS error / oracle, all sets")
    for one in present(rows):
        medians = [Figures.of(where(rows, one, keep)).ratio_all for keep in by_n(plan).values()]
        _line(axes, one, plan.sizes, medians)
    axes.axhline(1.0, color="0.6", lw=0.8, ls=":")
    axes.set(xscale="log", yscale="log", xlim=(plan.sizes[0] / 1.3, plan.sizes[-1] * 1.3))
    _finish(figure, axes, ERROR, folder)


def _draw_success(rows: Sequence[Row], plan: Plan, folder: Path) -> None:
    figure, axes = _new("σ in % of the diagonal", "sets with the right topology, %")
    for one in present(rows):
        rates = [100 * Figures.of(where(rows, one, keep)).topology for keep in by_sigma(plan).values()]
        _line(axes, one, [100 * sigma for sigma in plan.sigmas], rates)
    axes.set(xscale="log", ylim=(-3, 103))
    axes.set_xticks([100 * s for s in plan.sigmas], [f"{100 * s:g}" for s in plan.sigmas])
    axes.minorticks_off()
    _finish(figure, axes, SUCCESS, folder)


def _draw_time(rows: Sequence[Row], plan: Plan, folder: Path) -> None:
    figure, axes = _new("N", "CPU seconds, one core")
    timed = [row for row in rows if row.timed]
    for one in present(timed):
        known = {row.n: row.seconds for row in timed if row.contestant == one.name and not row.problem}
        _line(axes, one, plan.timed, [known.get(n, np.nan) for n in plan.timed])
    axes.set(xscale="log", yscale="log", xlim=(plan.timed[0] / 1.3, plan.timed[-1] * 1.3))
    _finish(figure, axes, TIME, folder)


def _new(across: str, up: str) -> tuple[Any, Any]:
    figure, grid = plots.new(1, 1, SIZE)
    grid[0, 0].set(xlabel=across, ylabel=up)
    return figure, grid[0, 0]


def _line(axes: Any, one: Any, x: Sequence[float], y: Sequence[float]) -> None:
    shown = [value if np.isfinite(value) else np.nan for value in y]
    style: dict[str, Any] = {"lw": 1.6, "zorder": 3} if one.own else {"lw": 1.2, "ls": "--"}
    if one.name == "auto":  # above the methods that it chooses from
        style |= {"zorder": 4, "mfc": "white"}
    axes.plot(x, shown, color=one.color, marker=one.marker, ms=5, label=one.title, **style)


def _finish(figure: Any, axes: Any, name: str, folder: Path) -> None:
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside right upper", frameon=False, fontsize=8)
    axes.grid(visible=True, color="0.92", lw=0.6)
    axes.set_axisbelow(True)
    plots.save(figure, name, folder)
