"""How the tests of this folder call the march."""

import numpy as np

from core.cloud.grid import build_grid
from core.cloud.sampling import Sample, estimate_scale
from core.march.fragments import Pace
from core.march.strip import FIT_SIZE, Books, fit_strip, gather_strip, own_strip, passed_share
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
