"""Planar curves that cross, for the tests of their readings."""

import numpy as np
import shapely

from core.refine.polyline import Polyline
from tests.core.shapes import in_space


def flat(points, closed=False):
    return Polyline(in_space(np.asarray(points, float)), closed)


def segment(start, end, count=41):
    return flat(np.linspace(start, end, count))


def circle(x=0.0, y=0.0, radius=1.0, count=240):
    u = 2.0 * np.pi * np.arange(count) / count
    return flat(np.column_stack((x + radius * np.cos(u), y + radius * np.sin(u))), True)


def closed_curve(x, y, count=400):
    u = 2.0 * np.pi * (np.arange(count) + 0.3) / count
    return flat(np.column_stack((x(u), y(u))), True)


def eight():
    return closed_curve(np.sin, lambda u: 0.5 * np.sin(2.0 * u))


def double_eight():
    """Four lobes in a row, three crossings."""
    return closed_curve(lambda u: 2.0 * np.cos(u), lambda u: 0.6 * np.sin(4.0 * u))


def lissajous():
    return closed_curve(lambda u: 1.2 * np.sin(2.0 * u + 0.5), lambda u: np.sin(3.0 * u))


def limacon():
    return closed_curve(lambda u: (0.5 + np.cos(u)) * np.cos(u), lambda u: (0.5 + np.cos(u)) * np.sin(u))


def ribbon():
    """An open curve with one loop."""
    u = np.linspace(-1.25, 1.25, 200)
    return flat(np.column_stack((u**3 - u, -(u**2))))


def rose(petals=3):
    """Petals that all pass through the origin."""
    u = np.pi * (np.arange(401) + 0.25) / 401
    return flat(np.column_stack((np.cos(petals * u) * np.cos(u), np.cos(petals * u) * np.sin(u))), True)


def scribble(rng, closed=True, waves=6, count=300):
    """A random smooth curve, mostly with several crossings."""
    u = 2.0 * np.pi * np.arange(count) / count
    phases = np.arange(1, waves + 1)[:, None] * u
    weights = rng.normal(size=(2, 2, waves)) / np.arange(1, waves + 1) ** 0.7
    points = (weights[0] @ np.cos(phases) + weights[1] @ np.sin(phases)).T
    return flat(points if closed else points[: int(0.9 * count)], closed)


def extent(curves):
    return max(float(np.ptp(curve.vertices, axis=0).max()) for curve in curves)


def drawn(curve):
    return shapely.linestrings(curve.ring[:, :2])


def keep_clear(curves):
    """Tell whether no curve meets another or itself, by an independent judge."""
    lines = [drawn(curve) for curve in curves]
    i, j = shapely.STRtree(lines).query(lines, predicate="intersects")
    return bool(np.all(shapely.is_simple(lines)) and np.all(i == j))


def odd(curves, point):
    """Tell whether a ray from a point crosses closed curves an odd number of times."""
    inside = False
    for curve in curves:
        a, b = curve.ring[:-1, :2], curve.ring[1:, :2]
        straddles = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
        a, b = a[straddles], b[straddles]
        x = a[:, 0] + (point[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        inside ^= bool(np.count_nonzero(x > point[0]) % 2)
    return inside
