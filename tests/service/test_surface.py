"""From scans to surfaces, through HTTP."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
import trimesh
from conftest import Serve
from expect import is_problem
from jobs.client import ASYNC, changes

from core.surface.results import RangeImage
from core.truth.objects import distances, reference_mesh, solid
from core.truth.scanner import Scanner, scan
from service.answers import ContoursAnswer, SliceAnswer, SurfaceAnswer
from service.render.range_grids import write_conf, write_range_ply

SLICE, CONTOURS, SURFACE = "/slice", "/reconstruct/contours", "/reconstruct/surface"
LEVELS = {"levels": 17}


@pytest.fixture(scope="module")
def images() -> tuple[RangeImage, ...]:
    return scan(solid("torus"), Scanner(views=8, pixels=44))


@pytest.fixture(scope="module")
def scans(images: tuple[RangeImage, ...]) -> dict[str, Any]:
    """Return the body of range images, with null for holes."""
    return {"range_images": [document(image) for image in images], "parameters": LEVELS}


def document(image: RangeImage) -> dict[str, Any]:
    rows = [[None if pixel[0] != pixel[0] else pixel for pixel in row] for row in image.points.tolist()]
    pose = {"rotation": image.pose.rotation.tolist(), "translation": image.pose.translation.tolist()}
    return {"points": rows, "pose": pose}


def circles(count: int, samples: int = 60) -> list[dict[str, Any]]:
    """Slices of a cylinder of radius 1."""
    rng = np.random.default_rng(0)
    slices = []
    for height in range(count):
        angle = rng.uniform(0.0, 2.0 * np.pi, samples)
        points = np.column_stack((np.cos(angle), np.sin(angle))) + rng.normal(0.0, 0.01, (samples, 2))
        slices.append({"height": height, "points": points.tolist()})
    return slices


def sent(client: httpx.Client, path: str, body: dict[str, Any], **options: Any) -> httpx.Response:
    response = client.post(path, json=body, **options)
    assert response.status_code == 200, response.text
    return response


# ---------------------------------------------------------------- the whole way


def test_range_images_are_sliced(client: httpx.Client, scans: dict[str, Any]) -> None:
    answer = SliceAnswer.model_validate(sent(client, SLICE, scans).json())
    assert answer.axis == [0.0, 0.0, 1.0]
    assert len(answer.slices) == 17
    for one in answer.slices:
        points = np.array(one.points)
        assert np.allclose(points[:, 2], one.height)
        assert len(one.closed) == len(one.polylines)
        assert distances(solid("torus"), points).max() < 4.0


def test_the_steps_one_by_one_make_much_the_same(client: httpx.Client, scans: dict[str, Any]) -> None:
    """Slices alone know no inside, which the scans tell: their contours are found otherwise."""
    sliced = sent(client, SLICE, scans).json()["slices"]
    slices = [{"height": one["height"], "points": one["points"]} for one in sliced]
    contours = ContoursAnswer.model_validate(sent(client, CONTOURS, {"slices": slices}).json())
    assert sum(len(one.curves) == 2 for one in contours.slices) > 4  # the hole is seen
    levels = [
        {"height": one.height, "curves": [curve.vertices for curve in one.curves]} for one in contours.slices
    ]
    one = sent(client, SURFACE, {"contours": levels}).json()["report"]
    whole = sent(client, SURFACE, scans).json()["report"]
    assert (one["components"], one["genus"]) == (whole["components"], whole["genus"]) == (1, 1)
    assert one["volume"] == pytest.approx(whole["volume"], rel=0.01)
    assert one["rms_residual"] is None
    assert whole["rms_residual"] < 2.0


def test_a_scanned_torus_comes_back_whole(client: httpx.Client, scans: dict[str, Any]) -> None:
    plain = sent(client, SURFACE, scans)
    answer = SurfaceAnswer.model_validate(plain.json())
    report = answer.report
    assert (report.closed, report.manifold, report.self_intersections) == (True, True, 0)
    assert (report.components, report.genus, report.euler) == (1, 1, 0)
    assert report.volume == pytest.approx(2 * np.pi**2 * 34 * 15**2, rel=0.05)
    assert "slices" not in plain.json()
    asked = sent(client, SURFACE, {**scans, "include": ["slices"]}).json()
    assert len(asked.pop("slices")) == 17
    assert asked == plain.json()


def test_files_with_poses_give_the_same_surface(
    client: httpx.Client, scans: dict[str, Any], images: tuple[RangeImage, ...]
) -> None:
    names = [f"torus{k}.ply" for k in range(len(images))]
    poses = {name: image.pose for name, image in zip(names, images, strict=True)}
    files = [("file", (name, write_range_ply(image))) for name, image in zip(names, images, strict=True)]
    files.append(("file", ("torus.conf", write_conf(poses))))  # type: ignore[arg-type] # each scan has one
    response = client.post(SURFACE, files=files, data={"parameters": '{"levels": 17}'})
    assert response.status_code == 200, response.text
    answer = SurfaceAnswer.model_validate(response.json())
    assert answer.report.genus == 1
    whole = sent(client, SURFACE, scans).json()["report"]
    assert answer.report.volume == pytest.approx(whole["volume"], rel=1e-3)  # files have single precision


@pytest.mark.parametrize("form", ["stl", "obj", "ply", "glb"])
def test_the_mesh_is_closed_in_every_form(client: httpx.Client, form: str) -> None:
    body = {"slices": circles(3)}
    response = sent(client, f"{SURFACE}?format={form}", body)
    mesh = trimesh.load(io.BytesIO(response.content), file_type=form, force="mesh")
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(
        SurfaceAnswer.model_validate(sent(client, SURFACE, body).json()).report.volume, rel=1e-3
    )


@pytest.mark.parametrize(
    ("kind", "media_type"), [("stl", "model/stl"), ("ply", "application/x-ply"), ("obj", "model/obj")]
)
def test_a_mesh_may_be_the_body_itself(client: httpx.Client, kind: str, media_type: str) -> None:
    made = reference_mesh(solid("ellipsoid"), 24)
    content = trimesh.Trimesh(made.vertices, made.faces, process=False).export(file_type=kind)
    response = client.post(
        f"{SURFACE}?axis=0,1,0&levels=30", content=content, headers={"Content-Type": media_type}
    )
    assert response.status_code == 200, response.text
    answer = SurfaceAnswer.model_validate(response.json())
    assert answer.report.volume == pytest.approx(4 / 3 * np.pi * 30 * 40 * 50, rel=0.02)


def test_a_missing_level_is_completed_and_named(client: httpx.Client) -> None:
    slices = circles(5)
    slices[2]["points"] = []
    answer = ContoursAnswer.model_validate(sent(client, CONTOURS, {"slices": slices}).json())
    assert [one.completed for one in answer.slices] == [False, False, True, False, False]
    assert [one.code for one in answer.warnings] == ["completed-level"]
    report = sent(client, SURFACE, {"slices": slices}).json()["report"]
    assert report["completed_levels"] == [2.0]


def test_nested_contours_are_holes_and_islands(client: httpx.Client) -> None:
    squares = [[[-k, -k], [k, -k], [k, k], [-k, k]] for k in (3, 2, 1)]
    levels = [{"height": height, "curves": squares} for height in (0, 1, 2)]
    report = sent(client, SURFACE, {"contours": levels}).json()["report"]
    assert (report["components"], report["genus"], report["closed"]) == (2, 1, True)


def test_an_execute_request_gives_the_same(client: httpx.Client) -> None:
    body = {"slices": circles(3), "parameters": {"similarity": 0.5}}
    plain = sent(client, SURFACE, body).json()
    executed = sent(client, "/processes/reconstruct-surface/execution", {"inputs": body})
    assert executed.json() == plain


# ---------------------------------------------------------------- jobs


@pytest.fixture(scope="module")
def worker(serve: Serve) -> Iterator[httpx.Client]:
    with (
        serve("scans", workers=1, job_workers=2) as (url, _),
        httpx.Client(base_url=url, timeout=60) as client,
    ):
        yield client


def test_a_job_falls_into_parts_and_gives_the_same(worker: httpx.Client) -> None:
    body = {"slices": circles(36, 40)}
    ordered = worker.post(SURFACE, json=body, headers=ASYNC)
    assert ordered.status_code == 201
    job = ordered.headers["location"]
    told = [change for _, change in changes(worker, job)]
    assert told[-1]["status"] == "successful", told[-1]
    words = " ".join(one["message"] for one in told)
    assert "part 1 of" in words
    assert told[-1]["message"] == "done"
    at_once = sent(worker, SURFACE, body, headers={"Prefer": "wait=60"})
    assert worker.get(f"{job}/results").content == at_once.content
    mesh = trimesh.load(io.BytesIO(worker.get(f"{job}/results?format=stl").content), file_type="stl")
    mesh.merge_vertices()
    assert mesh.is_watertight


# ---------------------------------------------------------------- what is refused

RING = [[np.cos(k), np.sin(k)] for k in np.arange(0, 6.28, 0.2)]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
TRIANGLE = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 1]], "faces": [[0, 1, 2]]}


@pytest.mark.parametrize(
    ("path", "body", "loc"),
    [
        (SLICE, {}, []),
        (SLICE, {"points": [[0, 0]]}, ["points"]),
        (SLICE, {"slices": [{"height": 0, "points": RING}]}, ["slices"]),
        (CONTOURS, {"contours": [{"height": 0, "curves": [SQUARE]}]}, ["contours"]),
        (SURFACE, {"contours": [{"height": 0, "curves": [SQUARE]}]}, ["contours"]),
        (SURFACE, {"contours": [{"height": k, "curves": []} for k in range(3)]}, ["contours"]),
        (SURFACE, {"contours": [{"height": 1, "curves": [SQUARE]}] * 2}, ["contours", 1, "height"]),
        (SURFACE, {"slices": [{"height": 1, "points": []}] * 2}, ["slices", 1, "height"]),
        (SLICE, {"meshes": [TRIANGLE], "parameters": {"heights": [7]}}, ["parameters", "heights"]),
        (SLICE, {"meshes": [TRIANGLE], "parameters": {"spacing": 1e-9}}, ["parameters", "spacing"]),
        (SLICE, {"meshes": [TRIANGLE], "parameters": {"axis": [0, 0, 0]}}, ["parameters"]),
        (SLICE, {"meshes": [TRIANGLE], "parameters": {"levels": 3, "spacing": 1}}, ["parameters"]),
        (SURFACE, {"meshes": [TRIANGLE], "include": ["stages"]}, ["include", 0]),
        (SLICE, {"meshes": [TRIANGLE], "include": ["slices"]}, ["include"]),
    ],
)
def test_what_cannot_be_used_is_refused_where_it_is(
    client: httpx.Client, path: str, body: dict[str, Any], loc: list[Any]
) -> None:
    problem = is_problem(client.post(path, json=body), 422)
    assert problem["errors"][0]["loc"] == ["body", *loc]


NUMBERS = [0.0, 1e-320, 1e-65, 1e-30, 1e15, 1e50, 1e90, -1.7e308]


@pytest.mark.parametrize("path", [SLICE, CONTOURS, SURFACE])
@pytest.mark.parametrize("scale", NUMBERS)
def test_extreme_coordinates_have_a_sound_answer_or_are_refused(
    client: httpx.Client, path: str, scale: float
) -> None:
    model = {SLICE: SliceAnswer, CONTOURS: ContoursAnswer, SURFACE: SurfaceAnswer}[path]
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    small = scale / 8  # so that no number below leaves the range of JSON
    scaled = [[small * x for x in row] for row in corners]
    moved = [[scale + x for x in row] for row in corners]
    grid = [[[small * x, small * y, small * (x + y)] for x in range(4)] for y in range(3)]
    flat = [[small * x, small * y] for x, y in RING]
    bodies = [
        {"meshes": [{"vertices": scaled, "faces": faces}]},
        {"meshes": [{"vertices": moved, "faces": faces}]},
        {"meshes": [{"vertices": scaled, "faces": faces}, {"vertices": corners, "faces": faces}]},
        {"range_images": [{"points": grid}]},
        {"slices": [{"height": small * k, "points": flat} for k in range(3)]},
        {"slices": [{"height": k, "points": flat} for k in range(3)]},
        {"contours": [{"height": small * k, "curves": [flat]} for k in range(3)]},
        {"contours": [{"height": k, "curves": [flat, RING]} for k in range(3)]},
    ]
    for body in bodies:
        levels = {"levels": 4} if {"meshes", "range_images"} & body.keys() else {}
        response = client.post(path, json={**body, "parameters": {"axis": [0.1, 0.2, 1.0]} | levels})
        if response.status_code == 200:
            model.model_validate(response.json())
        else:
            assert is_problem(response, 422)["errors"]


def test_repeated_and_crossing_contours_have_a_sound_answer(client: httpx.Client) -> None:
    eight = [[0, 0], [1, 1], [1, 0], [0, 1]]
    line = [[0, 0], [1, 0], [2, 0]]
    levels = [
        {"height": 0, "curves": [SQUARE, SQUARE]},
        {"height": 1, "curves": [eight, line, [[5, 5]]]},
        {"height": 2, "curves": [SQUARE, {"vertices": SQUARE, "closed": False}]},
    ]
    answer = SurfaceAnswer.model_validate(sent(client, SURFACE, {"contours": levels}).json())
    assert answer.report.closed
