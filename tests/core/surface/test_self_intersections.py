from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.surface.results import Mesh
from core.surface.self_intersections import self_intersections
from tests.core.surface.meshes import box


def soup(*triangles):
    corners = np.array(triangles, float).reshape(-1, 3)
    return Mesh(corners, np.arange(len(corners)).reshape(-1, 3))


FLAT = ((0, 0, 0), (4, 0, 0), (0, 4, 0))


@pytest.mark.parametrize(
    ("other", "meet"),
    [
        (((1, 1, -1), (1, 1, 1), (5, 5, 1)), True),  # pierced
        (((1, 1, 1), (2, 1, 1), (1, 2, 1)), False),  # above
        (((1, 1, 0), (2, 1, 3), (1, 2, 3)), True),  # touched by a corner
        (((-1, 1, 0), (5, 1, 0), (2, 1, 3)), True),  # touched by an edge
        (((1, 1, 0), (2, 1, 0), (1, 2, 0)), True),  # in the plane, within
        (((3, 3, 0), (4, 3, 0), (3, 4, 0)), False),  # in the plane, beside
        (((4, 0, 0), (5, 0, 1), (5, 1, 0)), True),  # a corner in the same place
        (((0, -1, 1), (0, -1, -1), (-1, -1, 0)), False),
        (((5, -1, 1), (5, 5, 1), (5, 0, -1)), False),  # cuts the plane, beside the triangle
    ],
)
def test_two_triangles(other, meet):
    assert self_intersections(soup(FLAT, other)) == meet
    assert self_intersections(soup(other, FLAT)) == meet


def test_faces_that_share_a_vertex_do_not_count():
    assert self_intersections(box()) == 0


def test_two_boxes_through_each_other():
    a, b = box(), box((0.5, 0.4, 0.3), (1.5, 1.4, 1.3))
    both = Mesh(np.concatenate((a.vertices, b.vertices)), np.concatenate((a.faces, b.faces + 8)))
    assert self_intersections(both) > 0
    apart = Mesh(np.concatenate((a.vertices, b.vertices + 2.0)), both.faces)
    assert self_intersections(apart) == 0
    nested = Mesh(np.concatenate((a.vertices, 0.5 + 0.5 * (a.vertices - 0.5))), both.faces)
    assert self_intersections(nested) == 0


def meet(t, s):
    """Distance of two triangles below rounding, by quadratic programming over a fine set of edges."""
    for p, q, other in [(x, y, s) for x, y in combinations(t, 2)] + [
        (x, y, t) for x, y in combinations(s, 2)
    ]:
        a, b, c = other
        matrix = np.column_stack((q - p, a - b, a - c))
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        along, u, v = np.linalg.solve(matrix, a - p)
        if 0 <= along <= 1 and u >= 0 and v >= 0 and u + v <= 1:
            return True
    return False


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 40))
def test_as_many_as_by_trying_all_pairs(seed, count):
    rng = np.random.default_rng(seed)
    triangles = rng.normal(size=(count, 1, 3)) + rng.uniform(0.1, 1.0) * rng.normal(size=(count, 3, 3))
    expected = sum(meet(t, s) for t, s in combinations(triangles, 2))
    assert self_intersections(soup(*triangles)) == expected


def test_thousands_of_undecided_pairs_are_counted_quickly():
    shifted = box((1e15, 1e15, 1e15), (1e15 + 1.0, 1e15 + 1.0, 1e15 + 1.0))
    many = Mesh(
        np.concatenate([shifted.vertices] * 20), np.concatenate([shifted.faces + 8 * k for k in range(20)])
    )
    assert self_intersections(many) > 2000
