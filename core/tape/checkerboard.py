"""The faces of an arrangement of curves, coloured like a checkerboard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.tape.arrangement import Arrangement

__all__ = ["black_sectors"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def black_sectors(arrangement: Arrangement) -> NDArray[np.bool_]:
    """Colour the faces so that neighbours differ and the face outside each connected part is white.

    An arc with one face on both sides has no say. Where open curves are at odds with each other,
    closed curves go first, then longer arcs.

    Parameters
    ----------
    arrangement : Arrangement

    Returns
    -------
    (2 A,) array of bool
        Whether the sector counter-clockwise of each arm is black.
    """
    count = len(arrangement.arcs)
    face, area = _faces(arrangement)
    part = np.repeat(arrangement.connected, 2)
    # The face outside has the negative area of all the others together.
    order = np.lexsort([area[face], part])
    outside = dict(zip(part[order][::-1], face[order][::-1], strict=True))
    colours = DisjointSet([(k, colour) for k in range(len(area)) for colour in (False, True)])
    length = [arc.line.length for arc in arrangement.arcs]
    # Closed curves alone are never at odds with each other.
    for k in sorted(range(count), key=lambda k: (not arrangement.arcs[k].closed, -length[k])):
        left, right = int(face[2 * k]), int(face[2 * k + 1])
        if left != right and not colours.connected((left, False), (right, False)):
            colours.merge((left, False), (right, True))
            colours.merge((left, True), (right, False))
    return np.array(
        [
            colours.connected((int(f), False), (int(outside[p]), True))
            for f, p in zip(face, part, strict=True)
        ],
        np.bool_,
    )


def _faces(arrangement: Arrangement) -> tuple[Ints, Floats]:
    """(2 A,) the face to the left of each arm as it leaves, and (F,) the areas of the faces."""
    count = 2 * len(arrangement.arcs)
    follows = np.arange(count) ^ 1  # at a free end a face turns back
    for node in arrangement.nodes:
        arms = np.array(node.arms, np.int64)
        follows[arms ^ 1] = np.roll(arms, 1)
    links = coo_array((np.ones(count), (np.arange(count), follows)), shape=(count, count))
    number, face = connected_components(links, directed=False)
    centre = np.mean([arc.vertices[0] for arc in arrangement.arcs], axis=0)
    swept = np.repeat([_swept(arc.vertices - centre) for arc in arrangement.arcs], 2)
    swept[1::2] *= -1.0
    return face.astype(np.int64), np.asarray(np.bincount(face, swept, number), np.float64)


def _swept(v: Floats) -> float:
    """Twice the area that the ray from the origin to a point on a course sweeps."""
    return float(np.sum(v[:-1, 0] * v[1:, 1] - v[1:, 0] * v[:-1, 1]))
