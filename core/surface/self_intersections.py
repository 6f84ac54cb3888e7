"""Pairs of faces that cut or touch each other without sharing a vertex.

Candidates come from a tree of boxes over the faces in Morton order; orientation predicates decide,
in floating point with an error bound (after Shewchuk 1997), and in rational numbers where it is
not met.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from core.surface.boxes import DEEP, order_of, tree_of
from core.surface.results import Mesh

__all__ = ["self_intersections"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Point = tuple[Fraction, Fraction, Fraction]

ERROR = 8e-16  # of the sum of absolute products: bounds the rounding of an orientation determinant
MOST_EXACT = 2000  # pairs decided in rational numbers, a millisecond each
MOST_PAIRS = 10_000_000  # beyond, counting is stopped: the mesh is hopeless


def self_intersections(mesh: Mesh) -> int:
    """Number of pairs of faces that have a point in common, but no vertex.

    Where thousands of pairs are too close to tell apart by rounded numbers, the rest count as cutting.
    """
    if len(mesh.faces) < 2:
        return 0
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    order = order_of((a + b + c) / 3.0)
    corners, faces = np.stack((a, b, c), axis=1)[order], mesh.faces[order]
    a, b, c = (corners[:, k] for k in range(3))
    tree = tree_of(np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c))
    sure, doubtful = _count(corners, faces, tree)
    decided = sum(_meet_exactly(corners[i], corners[j]) for i, j in doubtful[:MOST_EXACT])
    return int(sure) + decided + max(0, len(doubtful) - MOST_EXACT)


@njit(cache=True)
def _count(corners: Floats, faces: Ints, tree: Floats) -> tuple[int, list[tuple[int, int]]]:
    """How many pairs meet for sure, and those that are too close to say."""
    leaves = len(tree) // 2
    sure, looked = 0, 0
    doubtful = [(0, 0)]
    doubtful.pop()
    stack = np.empty(DEEP, np.int64)
    for i in range(len(faces)):
        # Branches to the right of the way from the leaf to the root hold the later leaves: each pair once.
        here = leaves + i
        while here > 1:
            stack[0], size = here + 1, 1 - here % 2
            here //= 2
            while size > 0:
                size -= 1
                node = stack[size]
                if _apart(tree, leaves + i, node):
                    continue
                if node < leaves:
                    stack[size], stack[size + 1] = 2 * node, 2 * node + 1
                    size += 2
                    continue
                j = node - leaves
                if _share(faces, i, j):
                    continue
                looked += 1
                answer = _meet(corners[i], corners[j])
                if answer > 0:
                    sure += 1
                elif answer == 0 and not _parted_for_sure(corners[i], corners[j]):
                    doubtful.append((i, j))
        if looked > MOST_PAIRS:
            break
    return sure, doubtful


@njit(cache=True)
def _apart(tree: Floats, a: int, b: int) -> bool:
    """Whether the boxes of two nodes have no point in common."""
    return bool(
        tree[a, 0, 0] > tree[b, 1, 0]
        or tree[b, 0, 0] > tree[a, 1, 0]
        or tree[a, 0, 1] > tree[b, 1, 1]
        or tree[b, 0, 1] > tree[a, 1, 1]
        or tree[a, 0, 2] > tree[b, 1, 2]
        or tree[b, 0, 2] > tree[a, 1, 2]
    )


@njit(cache=True)
def _share(faces: Ints, i: int, j: int) -> bool:
    for k in range(3):
        for n in range(3):
            if faces[i, k] == faces[j, n]:
                return True
    return False


@njit(cache=True)
def _side(a: Floats, b: Floats, c: Floats, d: Floats) -> int:
    """Side of the plane a b c on which d is: 1, -1, or 0 in doubt."""
    ux, uy, uz = a[0] - d[0], a[1] - d[1], a[2] - d[2]
    vx, vy, vz = b[0] - d[0], b[1] - d[1], b[2] - d[2]
    wx, wy, wz = c[0] - d[0], c[1] - d[1], c[2] - d[2]
    p, q = vx * wy, vy * wx
    r, s = wx * uy, wy * ux
    t, o = ux * vy, uy * vx
    value = uz * (p - q) + vz * (r - s) + wz * (t - o)
    bound = abs(uz) * (abs(p) + abs(q)) + abs(vz) * (abs(r) + abs(s)) + abs(wz) * (abs(t) + abs(o))
    if value > ERROR * bound:
        return 1
    if value < -ERROR * bound:
        return -1
    return 0


@njit(cache=True)
def _meet(t: Floats, s: Floats) -> int:
    """Whether two triangles meet: 1, -1 when not, 0 in doubt."""
    s0, s1, s2 = _side(t[0], t[1], t[2], s[0]), _side(t[0], t[1], t[2], s[1]), _side(t[0], t[1], t[2], s[2])
    if s0 == s1 == s2 != 0:
        return -1
    t0, t1, t2 = _side(s[0], s[1], s[2], t[0]), _side(s[0], s[1], s[2], t[1]), _side(s[0], s[1], s[2], t[2])
    if t0 == t1 == t2 != 0:
        return -1
    if s0 == 0 or s1 == 0 or s2 == 0 or t0 == 0 or t1 == 0 or t2 == 0:
        return 0
    doubt = False
    for k in range(3):
        n = (k + 1) % 3
        answer = _pierces(s[k], s[n], t)
        other = _pierces(t[k], t[n], s)
        if answer > 0 or other > 0:
            return 1
        doubt = doubt or answer == 0 or other == 0
    return 0 if doubt else -1


@njit(cache=True)
def _pierces(p: Floats, q: Floats, t: Floats) -> int:
    """Whether the segment p q cuts a triangle whose plane goes through neither end: 1, -1, 0 in doubt."""
    if _side(t[0], t[1], t[2], p) == _side(t[0], t[1], t[2], q):
        return -1
    a, b, c = _side(p, q, t[0], t[1]), _side(p, q, t[1], t[2]), _side(p, q, t[2], t[0])
    if a == b == c and a != 0:
        return 1
    if (a > 0 or b > 0 or c > 0) and (a < 0 or b < 0 or c < 0):
        return -1
    return 0


@njit(cache=True)
def _parted_for_sure(t: Floats, s: Floats) -> bool:
    """Whether an axis shows a gap between two triangles: any axis will do, however it is rounded."""
    u, v = np.empty((9, 3)), np.empty((9, 3))
    for k in range(3):
        n = (k + 1) % 3
        for j in range(3):
            u[k, j], v[k, j] = t[n, j] - t[k, j], s[n, j] - s[k, j]
    _cross_into(u, 0, u, 1, u, 3)
    _cross_into(v, 0, v, 1, v, 3)
    for k in range(3):
        # In the planes, across the edges.
        _cross_into(u, 3, u, k, u, 4 + k)
        _cross_into(v, 3, v, k, v, 4 + k)
    for k in range(3, 7):
        if _gap(u[k], t, s) or _gap(v[k], t, s):
            return True
    for k in range(3):
        for n in range(3):
            _cross_into(u, k, v, n, u, 8)
            if _gap(u[8], t, s):
                return True
    return False


@njit(cache=True)
def _cross_into(u: Floats, i: int, v: Floats, j: int, out: Floats, k: int) -> None:
    x = u[i, 1] * v[j, 2] - u[i, 2] * v[j, 1]
    y = u[i, 2] * v[j, 0] - u[i, 0] * v[j, 2]
    out[k, 2] = u[i, 0] * v[j, 1] - u[i, 1] * v[j, 0]
    out[k, 0], out[k, 1] = x, y


@njit(cache=True)
def _gap(axis: Floats, t: Floats, s: Floats) -> bool:
    """Whether the triangles' shadows on an axis are apart, rounding allowed for."""
    t_low, t_high, s_low, s_high, size = np.inf, -np.inf, np.inf, -np.inf, 0.0
    for k in range(3):
        a, b, m = 0.0, 0.0, 0.0
        for j in range(3):
            p, q = axis[j] * (t[k, j] - t[0, j]), axis[j] * (s[k, j] - t[0, j])
            a, b, m = a + p, b + q, m + abs(p) + abs(q)
        t_low, t_high, s_low, s_high = min(t_low, a), max(t_high, a), min(s_low, b), max(s_high, b)
        size = max(size, m)
    return max(s_low - t_high, t_low - s_high) > ERROR * size


def _meet_exactly(t: Floats, s: Floats) -> bool:
    """Whether two triangles have a point in common, in rational numbers.

    They have unless some plane parts them: for convex polytopes a face's plane, or one along an
    edge of each (separating axes).
    """
    one = [tuple(Fraction(float(x)) for x in p) for p in t]
    other = [tuple(Fraction(float(x)) for x in p) for p in s]
    sides = [_edges(one), _edges(other)]
    normals = [_cross(edges[0], edges[1]) for edges in sides]
    axes = [*normals, *(_cross(u, v) for u in sides[0] for v in sides[1])]
    axes += [_cross(normal, u) for normal, edges in zip(normals, sides, strict=True) for u in edges]
    return not any(_parted(axis, one, other) for axis in axes)


def _edges(corners: list[tuple[Fraction, ...]]) -> list[tuple[Fraction, ...]]:
    return [tuple(y - x for x, y in zip(a, b, strict=True)) for a, b in combinations(corners, 2)]


def _cross(u: tuple[Fraction, ...], v: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def _parted(
    axis: tuple[Fraction, ...], one: list[tuple[Fraction, ...]], other: list[tuple[Fraction, ...]]
) -> bool:
    """Whether the triangles' shadows on an axis are apart."""
    a = [sum(x * y for x, y in zip(axis, p, strict=True)) for p in one]
    b = [sum(x * y for x, y in zip(axis, p, strict=True)) for p in other]
    return max(a) < min(b) or max(b) < min(a)
