import numpy as np

from core.surface.linework import linework_of
from core.surface.results import ContourLevel
from core.truth.stacks import closed_curve


def ring(radius, centre=(0.0, 0.0), count=60):
    turn = 2.0 * np.pi * np.arange(count) / count
    return closed_curve(np.asarray(centre) + radius * np.column_stack((np.cos(turn), np.sin(turn))))


def square(x, y, width):
    return closed_curve(np.array([(x, y), (x + width, y), (x + width, y + width), (x, y + width)], float))


def stack(*levels, heights=None):
    """Levels one unit apart, or at given heights."""
    heights = range(len(levels)) if heights is None else heights
    return [ContourLevel(float(z), tuple(curves)) for z, curves in zip(heights, levels, strict=True)]


def lines_of(*loops, levels=None):
    """Borders through grid points; all of one level unless said otherwise."""
    return linework_of([np.array(loop, np.int64) for loop in loops], levels or [0] * len(loops))


def inside(lines, points, level=0):
    """Even-odd rule at points off the borders, none at the height of a vertex."""
    a, b = lines.ends[lines.level == level].astype(float).swapaxes(0, 1)
    x, y = np.asarray(points, float).T[:, :, None]
    up = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0]) > x
    return (up & right).sum(axis=1) % 2 == 1
