"""How the tests of this folder call the march."""

import numpy as np

from core.cloud.grid import build_grid
from core.cloud.sampling import Sample, estimate_scale
from core.march.fragments import Pace
from core.march.strip import FIT_SIZE, fit_strip, gather_strip, own_strip
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


class Field:
    """Points in a grid, with the march's books about them; answers are in the points' order."""

    def __init__(self, points, cell=0.2):
        self.grid = build_grid(np.asarray(points, np.float64), cell)
        n = len(points)
        self.owner, self.node, self.uses = np.full(n, -1), np.zeros(n, np.int64), np.zeros(n, np.int64)
        self.way = np.zeros((n, 3), np.float32)
        self.buffers = np.empty(n, np.int64), np.empty((n, 4))

    @property
    def cells(self):
        return self.grid.points, self.grid.starts, self.grid.origin, self.grid.cell, self.grid.shape

    def gather(self, place, r, half):
        count = gather_strip(*self.cells, place, r, half, *self.buffers)
        return self.grid.order[self.buffers[0][:count]], self.buffers[1][:count].copy()

    def fit(self, place, r, half, most_uses=0, normals=1, me=0):
        out = np.full(FIT_SIZE, np.nan)
        limits = np.array([me, 0, most_uses, normals])
        books = self.owner, self.node, self.way, self.uses
        good = fit_strip(*self.cells, *books, limits, place, r, half, *self.buffers, out)
        return bool(good), out

    def own(self, place, reach, r, half, me=0, node=0):
        books = self.owner, self.node, self.way, self.uses
        return own_strip(*self.cells, *books, me, node, place, reach, r, half, *self.buffers)

    def in_order(self, book):
        """A book of the march in the order of the points."""
        out = np.empty_like(book)
        out[self.grid.order] = book
        return out
