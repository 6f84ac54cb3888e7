"""The same things by brute force, to compare with."""

import numpy as np
from scipy.sparse.csgraph import connected_components


def components(points, epsilon):
    """Components of the graph |p - q| <= epsilon from all pairs, numbered as they first appear."""
    near = np.sum((points[:, None] - points[None]) ** 2, axis=-1) <= epsilon * epsilon
    labels = connected_components(near, directed=False)[1]
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def rotation(generator, dimension):
    """A random proper rotation."""
    q, r = np.linalg.qr(generator.normal(size=(dimension, dimension)))
    q = q * np.sign(np.diag(r))
    q[:, 0] *= np.linalg.det(q)
    return q
