import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.surface.mesh_report import is_sound, report_of
from core.surface.noding import noded
from core.surface.overlay import overlay_of, slab_ends
from core.surface.regions import regions_of
from core.surface.slabs import mesh_of_slabs
from core.truth.stacks import random_stack
from tests.core.surface.contours import inside, ring, square, stack


def slabs(levels):
    regions = regions_of(levels, np.eye(3))
    lines = noded(regions.lines)
    return regions, lines, slab_ends(lines, regions.heights)


def surface(levels):
    regions, lines, ends = slabs(levels)
    mesh = mesh_of_slabs(lines, ends, regions.grid)
    report = report_of(mesh)
    assert is_sound(report)
    return mesh, report


def shape(levels):
    report = surface(levels)[1]
    return report.components, report.genus


LEFT, RIGHT, WIDE = ring(0.8, (-1.0, 0.0)), ring(0.8, (1.0, 0.0)), ring(2.0)


@pytest.mark.parametrize(
    ("levels", "components", "genus"),
    [
        ([[WIDE], [WIDE]], 1, 0),
        ([[WIDE], [LEFT, RIGHT]], 1, 0),  # a branch
        ([[LEFT, RIGHT], [WIDE], [LEFT, RIGHT]], 1, 0),
        ([[WIDE], [LEFT, RIGHT], [WIDE]], 1, 1),  # branches merge
        ([[WIDE, ring(1.0)], [WIDE, ring(1.0)]], 1, 1),  # a tube
        ([[WIDE], [WIDE, ring(1.0)], [WIDE]], 2, 0),  # a cavity
        ([[WIDE, ring(1.5), ring(1.0)]] * 2, 2, 1),  # a rod in a tube
        ([[WIDE, ring(1.5), ring(1.0)], [WIDE]], 1, 0),
        ([[WIDE], [], [WIDE]], 2, 0),
        ([[], [WIDE], []], 1, 0),
        ([[LEFT], [RIGHT]], 2, 0),
        ([[square(0, 0, 1), square(1, 0, 1)]] * 2, 1, 0),  # side by side: one region
        ([[square(0, 0, 1), square(1, 1, 1)]] * 2, 2, 0),  # they touch at a corner
        ([[square(0, 0, 1)], [square(1, 0, 1)]], 2, 0),  # they share an edge, seen from above
        ([[square(0, 0, 2)], [square(0, 0, 1)], [square(0, 0, 2)]], 1, 0),  # walls in part
        ([[square(0, 0, 2)], [square(0, 0, 1), square(1, 1, 1)], [square(0, 0, 2)]], 1, 1),
    ],
)
def test_topology_follows_the_contours(levels, components, genus):
    assert shape(stack(*levels)) == (components, genus)


def test_a_prism_has_its_volume_and_caps_of_half_a_level_at_most():
    mesh, report = surface(stack(*[[square(0, 0, 10)]] * 3))
    assert 200.0 < report.volume < 300.0
    assert mesh.vertices[:, 2].min() > -1.0
    assert mesh.vertices[:, 2].max() < 3.0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_stack_gives_a_closed_manifold(seed):
    surface(random_stack(seed))


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_each_plane_cuts_the_mesh_in_its_contours_only(seed):
    regions, lines, ends = slabs(random_stack(seed))
    mesh = mesh_of_slabs(lines, ends, regions.grid)
    for level in np.unique(lines.level):
        sides = np.sign(mesh.vertices[mesh.faces, 2] - regions.heights[level])
        assert not np.any(np.all(sides == 0, axis=1))
        low, high = sides.min(axis=1), sides.max(axis=1)
        assert not np.any((low < 0) & (high > 0))
        # Below the plane and above it, the same edges lie in it.
        for side in (-1, 1):
            edges = [
                np.sort(face[sign == 0])
                for face, sign in zip(mesh.faces, sides, strict=True)
                if (sign == 0).sum() == 2 and sign.sum() == side
            ]
            assert len(np.unique(edges, axis=0)) == np.count_nonzero(lines.level == level)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_triangles_are_labelled_by_the_even_odd_rule(seed):
    _, lines, ends = slabs(random_stack(seed))
    overlay = overlay_of(lines, ends)
    real = np.all(overlay.node[overlay.triangles] >= 0, axis=1)
    corners = overlay.points[overlay.node[overlay.triangles]].astype(float)
    places = np.einsum("tkd,k->td", corners, (0.5, 0.31, 0.19))
    slab = overlay.slab[overlay.triangles[:, 0]]
    for k, each in enumerate(ends):
        mine = real & (slab == k)
        for end in range(2):
            expected = inside(lines, places[mine], each.levels[end])
            assert np.array_equal(overlay.inside[mine, end], expected)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_parts_end_at_borders_and_nowhere_else(seed):
    _, lines, ends = slabs(random_stack(seed))
    overlay = overlay_of(lines, ends)
    triangle, side = np.nonzero(overlay.neighbours >= 0)
    other = overlay.neighbours[triangle, side]
    parted = overlay.border[triangle, side].any(axis=1)
    assert np.array_equal(overlay.part[triangle[~parted]], overlay.part[other[~parted]])
    crossed = overlay.inside[triangle] != overlay.inside[other]
    assert np.array_equal(crossed, overlay.border[triangle, side])
    links = coo_array((np.ones(np.count_nonzero(~parted)), (triangle[~parted], other[~parted])))
    links.resize((len(overlay.part),) * 2)
    assert connected_components(links, directed=False)[0] == overlay.part.max() + 1


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(-40, 40))
def test_powers_of_two_scale_the_mesh_exactly(seed, power):
    levels = random_stack(seed)
    regions, lines, ends = slabs(levels)
    one = mesh_of_slabs(lines, ends, regions.grid)
    factor = 2.0**power
    scaled = stack(
        *(
            [type(c)(factor * c.vertices, True, 0, factor * c.length, 0, 0.0) for c in each.curves]
            for each in levels
        ),
        heights=[factor * each.height for each in levels],
    )
    regions, lines, ends = slabs(scaled)
    other = mesh_of_slabs(lines, ends, regions.grid)
    assert np.array_equal(one.faces, other.faces)
    assert np.array_equal(factor * one.vertices, other.vertices)
