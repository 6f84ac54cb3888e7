"""How the tests of this folder call the march."""

import numpy as np

from core.cloud.grid import build_grid
from core.cloud.sampling import Sample, estimate_scale
from core.march.fragments import Fragment, Pace
from core.march.strip import FIT_SIZE, SIGMA, Books, fit_strip, gather_strip, own_strip, passed_share
from core.march.walk import DENSITY, NODE_SIZE, RADIUS
from tests.core.shapes import in_space


def scene(points, flat=True, **fixed):
    """A sample centred in working coordinates, and the pace that follows from it."""
    work = in_space(points - points.mean(axis=0))
    sample = Sample.of(work)
    extent = float(np.linalg.norm(work, axis=1).max())
    return sample, Pace(estimate_scale(sample, extent, flat), extent, flat, **fixed)


def at(centre, direction, curvature=(0.0, 0.0, 0.0)):
    """A place on a course, as the strip kernels take it."""
    return np.concatenate((centre, direction, curvature)).astype(np.float64)


def fragment(points, closed=False, sigma=0.01, density=500.0, radius=0.2):
    """A march along given points: tangents and bends by differences, the rest as told."""
    nodes = np.zeros((len(points), NODE_SIZE))
    nodes[:, :3] = in_space(np.asarray(points, np.float64))
    tangent = np.gradient(nodes[:, :3], axis=0)
    if closed:
        ring = np.concatenate((nodes[-1:, :3], nodes[:, :3], nodes[:1, :3]))
        tangent = ring[2:] - ring[:-2]
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    nodes[:, 3:6] = tangent / length
    nodes[:, 6:9] = np.gradient(nodes[:, 3:6], axis=0) / length
    nodes[:, SIGMA], nodes[:, DENSITY], nodes[:, RADIUS] = sigma, density, radius
    return Fragment(nodes, closed)


class Field:
    """Points in a grid, with the march's books about them; answers are in the points' order."""

    def __init__(self, points, cell=0.2):
        self.grid = build_grid(np.asarray(points, np.float64), cell)
        self.books = Books.empty(len(points))

    def gather(self, place, r, half):
        found, local = self.books.found, self.books.local
        count = gather_strip(self.grid, place, r, half, found, local)
        return self.grid.order[found[:count]], local[:count].copy()

    def fit(self, place, r, half, most_uses=0, normals=1, me=0):
        out = np.full(FIT_SIZE, np.nan)
        limits = np.array([me, 0, most_uses, normals])
        return bool(fit_strip(self.grid, self.books, limits, place, r, half, out)), out

    def own(self, place, reach, r, half, me=0, node=0):
        return own_strip(self.grid, self.books, me, node, place, reach, r, half)

    def passed(self, place, r, half):
        return passed_share(self.grid, self.books, place, r, half)

    def read(self, book):
        """A book of the march, by name, in the order of the points."""
        kept = getattr(self.books, book)
        out = np.empty_like(kept)
        out[self.grid.order] = kept
        return out
