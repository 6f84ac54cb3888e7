"""Point sets and exact measures that several tests share."""

import numpy as np


def in_space(points):
    """Working coordinates, (N, 3), of points in a plane."""
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def arc(n, sigma, radius=1.0, turn=2 * np.pi, seed=0):
    """Noisy samples, (N, 2), of an arc about the origin that begins on the x axis."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, turn, n)
    return radius * np.column_stack((np.cos(angle), np.sin(angle))) + sigma * rng.normal(size=(n, 2))


def line(n, sigma, length=1.0, seed=0, dimension=2):
    """Noisy samples, (N, d), of a segment of the x axis about the origin."""
    rng = np.random.default_rng(seed)
    points = sigma * rng.normal(size=(n, dimension))
    points[:, 0] += rng.uniform(-length / 2, length / 2, n)
    return points


def rotation(rng, dimension):
    """A uniformly random proper rotation."""
    q, r = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    q *= np.sign(np.diag(r))
    q[:, 0] *= np.linalg.det(q)
    return q


def in_a_tilted_plane(points, seed, thickness=0.0):
    """Points, (N, 3), in a random plane of space, and the turn that took them there."""
    rng = np.random.default_rng(seed)
    turn = rotation(rng, 3)
    lifted = np.column_stack((points, thickness * rng.normal(size=len(points))))
    return lifted @ turn.T + rng.normal(size=3), turn


def distances(points, vertices, closed):
    """Distances, (N,), of points from a polyline in any dimension, by trying every segment."""
    ring = np.concatenate((vertices, vertices[:1])) if closed else vertices
    start, edge = ring[:-1], np.diff(ring, axis=0)
    square = np.maximum(np.einsum("sd,sd->s", edge, edge), 1e-300)
    out = np.empty(len(points))
    for k, offset in enumerate(points[:, None] - start):
        along = np.clip(np.einsum("sd,sd->s", offset, edge) / square, 0.0, 1.0)
        out[k] = np.linalg.norm(offset - along[:, None] * edge, axis=1).min()
    return out


def deviation(a, b):
    """Largest distance of the vertices of one curve from the other, both ways.

    Curves are anything with ``vertices`` and ``closed``.
    """
    there = distances(a.vertices, b.vertices, b.closed).max()
    back = distances(b.vertices, a.vertices, a.closed).max()
    return max(there, back)


def diagonal(points):
    """Length of the diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))
