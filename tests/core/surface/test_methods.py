"""From scans to slices, contours and one closed surface, and the same in parts."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core import divisions
from core.errors import DegenerateInput, InvalidInput, InvalidParameter
from core.surface.methods import contours, slices, surface
from core.surface.parameters import ContourParameters, SliceParameters, SurfaceParameters
from core.surface.results import ContourLevel, Mesh, Pose, RangeImage, Scans, Slice
from core.truth.objects import distances, reference_mesh, solid
from core.truth.scanner import Scanner, scan
from tests.core.surface.contours import ring, stack
from tests.core.surface.meshes import TETRAHEDRON, box
from tests.core.test_division import assert_same

AXIS = (1.0, 2.0, 2.0)


@lru_cache(maxsize=4)
def torus() -> Scans:
    return Scans(range_images=scan(solid("torus"), Scanner(views=8, pixels=60)))


def circles(count: int = 6, samples: int = 80, sigma: float = 0.01, seed: int = 0) -> Scans:
    """Noisy slices of a cylinder of radius 1, in their planes."""
    rng = np.random.default_rng(seed)
    levels = []
    for height in range(count):
        angle = rng.uniform(0.0, 2.0 * np.pi, samples)
        points = np.column_stack((np.cos(angle), np.sin(angle))) + rng.normal(0.0, sigma, (samples, 2))
        levels.append(Slice(float(height), points))
    return Scans(slices=tuple(levels))


# ---------------------------------------------------------------- slices


def test_meshes_and_range_images_are_sliced_together() -> None:
    y, x = np.mgrid[0.0:1.01:0.25, 0.0:1.01:0.25]
    wall = RangeImage(np.dstack((x, 0 * x - 3.0, y)))
    found = slices(Scans(meshes=(box(),), range_images=(wall,)), SliceParameters(heights=(0.5,)))
    (one,) = found.slices
    assert sorted(one.closed) == [False, True]
    assert found.axis.tolist() == [0.0, 0.0, 1.0]
    assert np.allclose(one.points[:, 2], 0.5)


def test_the_axis_is_a_unit_vector() -> None:
    found = slices(Scans(meshes=(box(),)), SliceParameters(axis=AXIS, levels=5))
    assert np.allclose(found.axis, np.array(AXIS) / 3.0)
    assert all(np.allclose(one.points @ found.axis, one.height) for one in found.slices)
    assert len(found.slices) == 5


# ---------------------------------------------------------------- contours


def test_slices_become_closed_contours() -> None:
    found = contours(circles())
    assert [one.height for one in found.slices] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    for level in found.slices:
        (curve,) = level.curves
        assert curve.closed
        assert np.allclose(np.linalg.norm(curve.vertices[:, :2], axis=1), 1.0, atol=0.03)
        assert np.all(curve.vertices[:, 2] == level.height)


def test_slices_in_their_planes_and_in_place_are_the_same() -> None:
    flat = circles(3)
    back = Rotation.align_vectors([np.array(AXIS) / 3.0], [[0.0, 0.0, 1.0]])[0].as_matrix()
    placed = tuple(
        replace(one, points=np.column_stack((one.points, np.full(len(one.points), one.height))) @ back.T)
        for one in flat.slices
    )
    parameters = ContourParameters(axis=AXIS)
    one, other = contours(flat, parameters), contours(Scans(slices=placed), parameters)
    for here, there in zip(one.slices, other.slices, strict=True):
        assert np.allclose(here.curves[0].vertices, there.curves[0].vertices, atol=1e-6)


def test_the_order_of_slices_does_not_matter() -> None:
    given = circles(4)
    assert_same(contours(Scans(slices=given.slices[::-1])), contours(given))


def test_a_missing_level_is_completed_and_told() -> None:
    given = circles(5)
    holed = tuple(replace(one, points=one.points[:0]) if one.height == 2.0 else one for one in given.slices)
    found = contours(Scans(slices=holed))
    assert [one.completed for one in found.slices] == [False, False, True, False, False]
    assert [one.code for one in found.warnings] == ["completed-level"]
    radii = np.linalg.norm(found.slices[2].curves[0].vertices[:, :2], axis=1)
    assert np.allclose(radii, 1.0, atol=0.05)
    left = contours(Scans(slices=holed), ContourParameters(complete=False))
    assert [len(one.curves) for one in left.slices] == [1, 1, 0, 1, 1]


# ---------------------------------------------------------------- surfaces


def test_scans_of_a_torus_become_a_torus() -> None:
    told: list[tuple[float, str]] = []
    made = surface(torus(), SurfaceParameters(levels=40), progress=lambda *one: told.append(one))
    report = made.report
    assert (report.closed, report.manifold, report.self_intersections) == (True, True, 0)
    assert (report.components, report.genus, report.euler) == (1, 1, 0)
    assert report.volume == pytest.approx(2 * np.pi**2 * 34.0 * 15.0**2, rel=0.02)
    off = distances(solid("torus"), made.mesh.vertices)
    assert np.sqrt(np.mean(off**2)) < 0.3
    assert report.rms_residual is not None
    assert report.rms_residual < 0.3
    assert made.slices == ()
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    assert {"slicing", "slice 40 of 40", "spanning the surface"} <= {what for _, what in told}


def test_the_contours_come_when_asked_for() -> None:
    levels = stack([ring(2.0)], [ring(2.0), ring(1.0)], [ring(2.0)])
    made = surface(Scans(contours=tuple(levels)), slices=True)
    assert [len(one.curves) for one in made.slices] == [1, 2, 1]
    assert made.report.genus == 0
    assert made.report.rms_residual is None  # nothing was scanned
    assert made.report.components == 1 + 1  # a hole that is closed at both ends is a shell inside


def test_the_contours_of_a_mesh_lead_back_to_it() -> None:
    mesh = reference_mesh(solid("ellipsoid"), 40)
    made = surface(Scans(meshes=(mesh,)), SurfaceParameters(levels=40))
    assert made.report.volume == pytest.approx(4 / 3 * np.pi * 30 * 40 * 50, rel=0.01)
    assert made.report.genus == 0
    assert made.report.rms_residual < 1.0


def test_contours_in_planes_across_another_axis_are_lifted() -> None:
    levels = tuple(stack([ring(2.0)], [ring(2.0)], [ring(2.0)]))
    made = surface(Scans(contours=levels), SurfaceParameters(axis=AXIS), slices=True)
    heights = made.mesh.vertices @ np.array(AXIS) / 3.0
    straight = surface(Scans(contours=levels))
    assert np.allclose(np.sort(heights), np.sort(straight.mesh.vertices[:, 2]), atol=1e-9)
    assert made.report.volume == pytest.approx(straight.report.volume)
    assert np.allclose(made.axis, np.array(AXIS) / 3.0)
    assert all(one.curves[0].vertices.shape[1] == 3 for one in made.slices)


def test_a_surface_is_that_of_its_contours() -> None:
    given = circles(4)
    levels = contours(given)
    one, other = surface(given), surface(Scans(contours=levels.slices))
    assert_same(one.mesh, other.mesh)
    assert one.report.rms_residual == pytest.approx(0.01, abs=0.01)


# ---------------------------------------------------------------- what cannot be used

SQUARES = tuple(stack([ring(1.0)], [ring(1.0)]))
RING = np.column_stack((np.cos(np.arange(40) / 6.3), np.sin(np.arange(40) / 6.3)))
FLAT = Slice(0.0, RING)
PAIR = (FLAT, replace(FLAT, height=1.0))
HUGE = 1e150
IMAGE = RangeImage(np.dstack((*np.mgrid[0.0:3.0, 0.0:4.0], np.zeros((3, 4)))))


def levels_at(*heights: float) -> tuple[ContourLevel, ...]:
    return tuple(ContourLevel(height, (ring(1.0),)) for height in heights)


@pytest.mark.parametrize(
    ("method", "scans", "parameters", "kind", "loc"),
    [
        (slices, Scans(), {}, InvalidInput, ()),
        (surface, Scans(meshes=(box(),), contours=SQUARES), {}, InvalidInput, ("contours",)),
        (contours, Scans(slices=PAIR, contours=SQUARES), {}, InvalidInput, ("contours",)),
        (slices, Scans(slices=PAIR), {}, InvalidInput, ("slices",)),
        (slices, Scans(contours=SQUARES), {}, InvalidInput, ("contours",)),
        (contours, Scans(contours=SQUARES), {}, InvalidInput, ("contours",)),
        (contours, Scans(slices=PAIR), {"levels": 3}, InvalidParameter, ("parameters", "levels")),
        (surface, Scans(contours=SQUARES), {"heights": (1.0,)}, InvalidParameter, ("parameters", "heights")),
        (contours, Scans(slices=(*PAIR, FLAT)), {}, InvalidInput, ("slices", 2, "height")),
        (surface, Scans(contours=levels_at(0, 5, 9, 5)), {}, InvalidInput, ("contours", 3, "height")),
        (surface, Scans(contours=levels_at(0, HUGE)), {}, InvalidInput, ("contours", 1, "height")),
        (surface, Scans(slices=PAIR[:1]), {}, DegenerateInput, ("slices",)),
        (surface, Scans(contours=SQUARES[:1]), {}, DegenerateInput, ("contours",)),
        (surface, Scans(meshes=(box(),)), {"levels": 1}, DegenerateInput, ("parameters", "levels")),
        (slices, Scans(meshes=(box(),)), {"heights": (2.0,)}, DegenerateInput, ("parameters", "heights")),
        (contours, Scans(slices=(Slice(0.0, RING[:0]),)), {}, DegenerateInput, ("slices",)),
        (
            slices,
            Scans(range_images=(RangeImage(np.full((4, 4, 3), np.nan)),)),
            {},
            DegenerateInput,
            ("range_images",),
        ),
        (
            slices,
            Scans(meshes=(box(), Mesh(TETRAHEDRON.vertices * HUGE, TETRAHEDRON.faces))),
            {},
            InvalidInput,
            ("meshes", 1),
        ),
        (
            slices,
            Scans(range_images=(replace(IMAGE, pose=Pose(np.eye(3), np.full(3, HUGE))),)),
            {},
            InvalidInput,
            ("range_images", 0, "pose", "translation"),
        ),
        (
            surface,
            Scans(range_images=(replace(IMAGE, pose=Pose(np.eye(3), np.full(3, 1e12))),)),
            {},
            DegenerateInput,
            ("range_images",),
        ),
        (
            slices,
            Scans(meshes=(Mesh(TETRAHEDRON.vertices / HUGE, TETRAHEDRON.faces),)),
            {},
            DegenerateInput,
            ("meshes",),
        ),
        (
            contours,
            Scans(slices=(Slice(0.0, RING / 1e12), Slice(1.0, RING / 1e12))),
            {},
            DegenerateInput,
            ("slices",),
        ),
        (contours, Scans(slices=(FLAT, Slice(1.0, RING * HUGE))), {}, InvalidInput, ("slices", 1, "points")),
        (
            surface,
            Scans(contours=(*SQUARES, ContourLevel(5.0, (ring(1.0), ring(HUGE))))),
            {},
            InvalidInput,
            ("contours", 2, "curves", 1),
        ),
    ],
)
def test_what_cannot_be_used_is_refused_where_it_is(method, scans, parameters, kind, loc) -> None:
    model = {slices: SliceParameters, contours: ContourParameters, surface: SurfaceParameters}[method]
    with pytest.raises(kind) as caught:
        method(scans, model(**parameters))
    assert type(caught.value) is kind
    assert caught.value.loc == loc


# ---------------------------------------------------------------- in parts


@pytest.mark.parametrize(
    ("method", "division", "flags"),
    [(contours, divisions.CONTOURS, {}), (surface, divisions.SURFACE, {"slices": True})],
    ids=["contours", "surface"],
)
def test_parts_give_the_same_to_the_last_bit(method, division, flags) -> None:
    scans, parameters = circles(36, 40, seed=3), SurfaceParameters()
    parts = division.split(scans, parameters)
    assert len(parts) > 1
    assert sorted(one.first + k for part in parts for one in part.groups for k in range(len(one.slices))) == [
        *range(36)
    ]
    solved = [division.solve(pickle.loads(pickle.dumps(part)), None) for part in reversed(parts)]  # noqa: S301 # ours
    assert_same(division.join(scans, parameters, solved, **flags), method(scans, parameters, **flags))


def test_contours_and_a_few_levels_are_not_divided() -> None:
    assert divisions.SURFACE.split(Scans(contours=SQUARES), SurfaceParameters()) == ()
    assert divisions.CONTOURS.split(circles(3), ContourParameters()) == ()
    mesh = Scans(meshes=(reference_mesh(solid("torus"), 40),))  # its slices are contours already
    assert divisions.SURFACE.split(mesh, SurfaceParameters(levels=200)) == ()


def test_errors_are_those_of_the_undivided_computation() -> None:
    with pytest.raises(InvalidInput) as caught:
        divisions.CONTOURS.split(Scans(slices=(*PAIR, FLAT)), ContourParameters())
    assert caught.value.loc == ("slices", 2, "height")


def test_a_part_tells_which_slice_it_is_at() -> None:
    part = divisions.CONTOURS.split(circles(36, 40, seed=3), ContourParameters())[0]
    told: list[tuple[float, str]] = []
    divisions.CONTOURS.solve(part, lambda *one: told.append(one))
    assert [fraction for fraction, _ in told] == sorted(fraction for fraction, _ in told)
    assert told[-1] == (1.0, "done")
    first = part.groups[0].first
    assert told[0] == (0.0, f"slice {first + 1} of 36")
    assert part.name.startswith(f"slices {first + 1} to ")
