"""Planar curves that cross and graphs that fork, for the tests of their readings."""

import numpy as np
import shapely

from core.refine.polyline import Polyline
from core.tape.delaunay import triangulate
from core.tape.graph import Graph, GraphEdge
from tests.core.shapes import in_space

ARM = 20.0  # length of the arms of a graph


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


def unit(degrees):
    return np.array((np.cos(np.radians(degrees)), np.sin(np.radians(degrees))))


def graph_of(places, ends, radius=1.0):
    """Straight edges between nodes."""
    places = np.asarray(places, float)
    radii = np.broadcast_to(np.asarray(radius, float), len(places)).copy()
    share = np.linspace(0.0, 1.0, 41)[:, None]
    edges = [
        GraphEdge(
            (a, b),
            np.where(share == 1.0, places[b], places[a] + share * (places[b] - places[a])),
            radii[a] + share[:, 0] * (radii[b] - radii[a]),
        )
        for a, b in ends
    ]
    return Graph(places, radii, tuple(edges))


def star(*degrees):
    """Arms that leave one node."""
    tips = [ARM * unit(angle) for angle in degrees]
    return graph_of([(0.0, 0.0), *tips], [(0, k + 1) for k in range(len(tips))])


def crossed(degrees, bar):
    """Two lines that cross: edge 0 is the bar, 1 and 2 leave it to the right, 3 and 4 to the left."""
    ends = np.array([(0.5 * bar, 0.0), (-0.5 * bar, 0.0)])
    half = 0.5 * degrees
    tips = [
        ends[0] + ARM * unit(half),
        ends[0] + ARM * unit(-half),
        ends[1] + ARM * unit(180.0 + half),
        ends[1] + ARM * unit(180.0 - half),
    ]
    return graph_of([*ends, *tips], [(0, 1), (0, 2), (0, 3), (1, 4), (1, 5)])


def net(seed):
    """A planar graph with forks of all degrees, some of its nodes as near as their discs."""
    rng = np.random.default_rng(seed)
    mesh = triangulate(rng.normal(size=(int(rng.integers(6, 30)), 2)))
    pairs = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends = [(int(a), int(b)) for a, b in np.unique(np.sort(pairs, axis=1), axis=0)]
    graph = graph_of(mesh.points, ends, rng.uniform(0.01, 0.4, len(mesh.points)))
    return graph, rng.poisson(100.0 * lengths(graph)).astype(float)


def lengths(graph):
    return np.array([edge.length for edge in graph.edges])
