"""The benchmark of surfaces, without Open3D: our own side on tiny scans, the judge, and the page."""

from __future__ import annotations

import importlib.metadata
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.peers.page import Origin
from benchmarks.surface import page
from benchmarks.surface.__main__ import QUICK, measure
from benchmarks.surface.completion import Damage, completed_levels, damaged, error_of
from benchmarks.surface.environment import LOCK
from benchmarks.surface.judging import distances_between, residual, samples_on, topology_of
from benchmarks.surface.own import load_images, save_images, whole
from benchmarks.surface.programs import OPEN3D, TAPELINE, oriented_points
from benchmarks.surface.rows import CompletionRow, MeshRow, Rows, SlicingRow, StackRow, load, save
from benchmarks.surface.slicing import torus_mesh
from core.results import Curve
from core.surface.mesh_report import report_of
from core.surface.parameters import SliceParameters, SurfaceParameters
from core.surface.results import ContourLevel, Mesh
from core.surface.slicing import slices_of
from core.truth import Scanner, reference_mesh, scan, solid
from core.truth.objects import normals

SCANNER = Scanner(views=8, pixels=50)
ORIGIN = Origin("a machine, Linux", {}, {"numpy": "2"}, 1, 150.0)


def circle(radius: float, count: int = 400) -> np.ndarray:
    turn = 2 * np.pi * np.arange(count) / count
    return np.column_stack((radius * np.cos(turn), radius * np.sin(turn)))


def level(*loops: np.ndarray) -> ContourLevel:
    return ContourLevel(0.0, tuple(Curve(loop, True, 0, 1.0, len(loop), 0.0) for loop in loops))


def rows() -> Rows:
    """One row of everything, with figures that are all different."""
    own = MeshRow("torus", TAPELINE, 1000, 16, 1, 1, 1, 1, True, True, 0, 500, 0.02, 0.04, 0.1, 3.0, 4.0)
    other = replace(own, program=OPEN3D, rms=0.025, cpu=4.0, genus=2, self_intersections=7)
    return Rows(
        {"solids": 90.0},
        {"own Python": "3", "Open3D": "0.20"},
        [replace(own, stages=(0.1, 2.0, 0.5, 0.4)), other],
        [replace(own, name="bun", true_genus=0, together=12.5), replace(other, name="bun", true_genus=2)],
        [SlicingRow(TAPELINE, 10, 2, 0.1), SlicingRow("trimesh section_multiplane", 10, 2, 1.0)],
        [StackRow(10, 8, 1, 1, 1, 0.05, 0.2, (3,))],
        [
            CompletionRow("torus", 16, "missing, one level", 1.0, 0.03, 0.02, True, True),
            CompletionRow("torus", 16, "missing, one level", 2.0, 0.06, 0.02, True, False),
        ],
    )


# --- measuring ----------------------------------------------------------------------------------------


def test_a_tiny_scan_becomes_a_surface_whose_stages_add_up_to_its_time() -> None:
    made, (cpu, clock), stages = whole(scan(solid("ball"), SCANNER), SurfaceParameters(levels=12))
    topology, found = topology_of(made.mesh), distances_between(made.mesh, solid("ball"), 2000)
    assert (topology.components, topology.genus, topology.closed) == (1, 0, True)
    assert found.rms < found.high < found.largest < 5.0
    assert sum(stages) == pytest.approx(cpu)
    assert len(stages) == 4
    assert min(stages) > 0.0 < clock


def test_images_are_the_same_after_a_file(tmp_path: Path) -> None:
    images = scan(solid("ball"), Scanner(views=2, pixels=10))
    save_images(images, tmp_path / "images.npz")
    for one, other in zip(images, load_images(tmp_path / "images.npz"), strict=True):
        assert np.array_equal(one.points, other.points, equal_nan=True)
        assert one.pose is not None
        assert other.pose is not None
        assert np.array_equal(one.pose.rotation, other.pose.rotation)
        assert np.array_equal(one.pose.translation, other.pose.translation)


def test_the_normals_that_open3d_gets_are_nearly_those_of_the_truth() -> None:
    points, found = oriented_points(scan(solid("torus"), Scanner(views=10, pixels=100)))
    cosine = np.einsum("ij,ij->i", found, normals(solid("torus"), points))
    assert np.linalg.norm(found, axis=1) == pytest.approx(1.0)
    assert np.quantile(cosine, 0.01) > np.cos(np.radians(15.0))


def test_a_mesh_of_the_truth_is_at_no_distance_and_a_larger_one_at_the_difference() -> None:
    one, mesh = solid("ball"), reference_mesh(solid("ball"))
    assert distances_between(mesh, one, 2000).largest < 0.01
    larger = distances_between(Mesh(1.01 * mesh.vertices, mesh.faces), one, 2000)
    assert (larger.rms, larger.high, larger.largest) == pytest.approx((0.5, 0.5, 0.5), abs=0.01)
    assert residual(mesh, 1.02 * mesh.vertices, 500) == pytest.approx(1.0, abs=0.01)


def test_samples_are_spread_by_area() -> None:
    corners = np.array([[0.0, 0, 0], [3, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
    mesh = Mesh(corners, np.array([[0, 1, 2], [3, 4, 5]]))
    low = np.mean(samples_on(mesh, 4000, np.random.default_rng(1))[:, 2] < 0.5)
    assert low == pytest.approx(0.75, abs=0.03)


def test_the_mesh_to_be_cut_is_a_closed_torus_of_that_many_triangles() -> None:
    mesh = torus_mesh(2000)
    report = report_of(mesh)
    assert (report.closed, report.genus, report.self_intersections) == (True, 1, 0)
    assert report.volume > 0.0
    assert len(mesh.faces) == pytest.approx(2000, rel=0.05)


def test_parts_are_measured_and_kept_one_by_one(tmp_path: Path) -> None:
    plan, file = replace(QUICK, triangles=2000, planes=5, stacks=3), tmp_path / "kept" / "rows.json"
    save(rows(), file)
    measure(plan, None, None, ["slicing", "stacks"], file)
    kept = load(file)
    assert [one.planes for one in kept.slicing] == [5, 5, 5]
    assert kept.stacks[0].sound == 3
    assert kept.seconds.keys() == {"solids", "slicing", "stacks"}
    assert (kept.solids, kept.completion) == (rows().solids, rows().completion)
    assert kept.versions["Open3D"] == "0.20"


# --- completed levels ---------------------------------------------------------------------------------


def test_errors_of_contours_are_distances_both_ways() -> None:
    truth = [circle(10.0), circle(4.0)]
    assert error_of(level(*truth), truth) == pytest.approx(0.0, abs=1e-9)
    assert error_of(level(1.1 * truth[0], 1.25 * truth[1]), truth) == pytest.approx(1.0, rel=1e-3)
    assert error_of(level(truth[0]), truth) > 1.0
    assert error_of(level(), truth) == np.inf


def test_damage_is_done_where_it_is_planned_and_nowhere_else() -> None:
    heights = tuple(np.linspace(-20.0, 20.0, 9).tolist())
    stack = slices_of([reference_mesh(solid("ball"))], SliceParameters(heights=heights))
    plan = {2: Damage("gap", 2, missing=False), 6: Damage("missing", 1, missing=True)}
    worse = damaged(stack, plan, [one.polylines for one in stack], np.random.default_rng(0))
    left = [len(new.points) / len(old.points) for new, old in zip(worse, stack, strict=True)]
    assert [share == 1.0 for share in left] == [True, True, False, False, True, True, False, True, True]
    assert 0.6 < min(left[2:4]) <= max(left[2:4]) < 0.95
    assert left[6] == 0.0


def test_damaged_levels_are_measured_beside_the_truth() -> None:
    found = list(completed_levels(solid("ball"), replace(SCANNER, noise=0.01), 16, 2, 60))
    assert [one.kind for one in found] == ["gap of 10 to 30 %, one level", "missing, one level"]
    assert found[1].told
    assert all(one.right and 0.0 < one.neighbours < 1.0 for one in found)
    assert all(0.0 < one.rms < 1.0 for one in found)


# --- the page -----------------------------------------------------------------------------------------


def test_rows_are_the_same_after_a_file(tmp_path: Path) -> None:
    save(rows(), tmp_path / "rows.json")
    assert load(tmp_path / "rows.json") == rows()
    assert load(tmp_path / "none.json") == Rows()


def test_the_page_has_every_figure_beside_its_goal(tmp_path: Path) -> None:
    text = page.write(rows(), ORIGIN, tmp_path).read_text(encoding="utf-8")
    assert all(head in text for head in page.HEADS.values())
    assert "| torus (1, 1) | Tapeline | 1 | 1 | yes | 0 | 0.020 | 0.040 | 0.100 | 3.0 |" in text
    assert "| torus (1, 1) | Open3D Poisson | 1 | 2 | yes | 7 |" in text
    assert "the seeds 3." in text
    assert "in 2 minutes" in text
    assert "Open3D 0.20" in text


def test_every_row_of_a_table_has_as_many_cells_as_its_head() -> None:
    counts: list[int] = []
    for line in page.tables(rows()):
        if line.startswith("|"):
            counts.append(line.count("|"))
            assert counts[-1] == counts[0], line
        else:
            counts.clear()


def test_figures_are_reached_or_not_by_what_was_measured() -> None:
    told = {one.what: (one.measured, one.reached) for one in page.reached(rows())}
    assert told["virtual scans: right genus and parts"] == (1.0, True)
    assert told["virtual scans: RMS over Open3D's, the worst"] == (pytest.approx(0.8), True)
    assert told["virtual scans: CPU time over Open3D's, the worst"] == (pytest.approx(0.75), True)
    assert told["bun: one part of genus 0"] == (0.0, False)
    assert told["bun: seconds by the clock, two processes"] == (12.5, True)
    assert told["10 random stacks: closed manifolds"] == (pytest.approx(8 / 9), False)
    assert told["slicing: time over trimesh's"] == (pytest.approx(0.1), True)
    whole = told["completed levels: RMS over their neighbours', of all"]
    assert whole == (pytest.approx(np.sqrt(45 / 8)), False)
    assert told["completed levels: the same, median"] == (pytest.approx(2.25), False)


def test_parts_that_were_not_measured_are_left_out() -> None:
    assert page.tables(Rows()) == []
    alone = Rows(solids=[one for one in rows().solids if one.program == TAPELINE])
    assert OPEN3D not in "\n".join(line for line in page.tables(alone) if line.startswith("|"))
    assert len(page.reached(alone)) == 2


def test_a_program_without_a_mesh_has_its_problem_in_the_table() -> None:
    late = MeshRow("torus", OPEN3D, problem="TimeoutExpired")
    lines = page.tables(Rows(solids=[rows().solids[0], late]))
    assert any("TimeoutExpired" in line and "| inf |" in line for line in lines)


def test_the_lock_has_open3d_and_the_project_does_not_need_it() -> None:
    assert "\nopen3d==" in LOCK.read_text(encoding="utf-8")
    needed = importlib.metadata.requires("tapeline") or []
    assert not any(one.lower().startswith("open3d") for one in needed)
