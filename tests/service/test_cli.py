from __future__ import annotations

import gzip
import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import shapely
import trimesh

from core.parameters import ReconstructParameters, SkeletonParameters
from service.answers import (
    ContoursAnswer,
    DiagnosisAnswer,
    PartitionAnswer,
    PcaAnswer,
    ReconstructAnswer,
    SkeletonAnswer,
    SliceAnswer,
    SurfaceAnswer,
)
from service.cli import main
from service.settings import Settings

ROOT = Path(__file__).parents[2]
Run = Callable[..., tuple[int, bytes, str]]


@pytest.fixture
def run(capsysbinary: pytest.CaptureFixture[bytes]) -> Run:
    """Run a command here; return its exit status, output and complaints."""

    def run(*arguments: object) -> tuple[int, bytes, str]:
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as ended:  # argparse's own way
            status = int(ended.code or 0)
        output, complaints = capsysbinary.readouterr()
        return status, output, complaints.decode()

    return run


@pytest.fixture(scope="module")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Draw a noisy circle, in a file."""
    path = tmp_path_factory.mktemp("cloud") / "circle.csv"
    assert main(["examples", "circle", "-n", "800", "--sigma", "0.005", "-o", str(path)]) == 0
    return path


def child(*arguments: object, **options: Any) -> subprocess.CompletedProcess[bytes]:
    """Run a command in a process of its own."""
    command = [sys.executable, "-m", "service.cli", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.run(command, env=environment, check=False, **{**pipes, **options})  # noqa: S603 # ours


def one_line(complaint: str) -> str:
    assert complaint.startswith("tapeline: ")
    assert complaint.count("\n") == 1
    return complaint


# --- help -----------------------------------------------------------------------------------------


def test_the_commands_are_listed(run: Run) -> None:
    status, output, _ = run("--help")
    assert status == 0
    assert all(
        command in output.decode()
        for command in (
            "serve",
            "reconstruct",
            "diagnose",
            "partition",
            "slice",
            "contours",
            "surface",
            "examples",
        )
    )


def test_the_version_is_told(run: Run) -> None:
    status, output, _ = run("--version")
    assert status == 0
    assert re.fullmatch(rb"tapeline \d\S*\s+", output)


@pytest.mark.parametrize(
    ("command", "model"),
    [("reconstruct", ReconstructParameters), ("diagnose", ReconstructParameters), ("serve", Settings)],
)
def test_every_parameter_and_every_setting_is_an_option(run: Run, command: str, model: Any) -> None:
    _, output, _ = run(command, "--help")
    options = set(re.findall(r"--[a-z][a-z-]*", output.decode()))
    assert {f"--{name.replace('_', '-')}" for name in model.model_fields} <= options


def test_a_command_with_several_methods_says_what_each_does(run: Run) -> None:
    assert "by the method that the data call for" in " ".join(run("--help")[1].decode().split())
    text = run("reconstruct", "--help")[1].decode()
    groups = re.split(r"^parameters.*:$", text, flags=re.MULTILINE)[1:]
    assert len(groups) == 3
    own = [set(re.findall(r"^  (--[a-z-]+)", group, flags=re.MULTILINE)) for group in groups]
    assert "--vertex-spacing" in own[0]
    assert {"--crossings", "--max-uses"} <= own[1] | own[2]
    assert not own[1] & own[2]
    assert all(f"--method {method}: " in text for method in ("auto", "pca", "skeleton"))
    assert "{auto,pca,skeleton}" in text


def test_defaults_are_told(run: Run) -> None:
    text = " ".join(run("reconstruct", "--help")[1].decode().split())
    for field in SkeletonParameters.model_fields.values():
        if field.default is not None:
            assert f"Default: {str(field.default).lower()}." in text


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom service.cli import main\n"
        "try: main(['--help'])\nexcept SystemExit: pass\n"
        "print(*{name.partition('.')[0] for name in sys.modules})"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, cwd=ROOT, check=True)  # noqa: S603 # ours
    assert not {"numba", "scipy", "matplotlib", "fastapi", "shapely"} & set(answer.stdout.decode().split())


@pytest.mark.parametrize(
    "arguments", [[], ["paint"], ["partition"], ["reconstruct", "a.csv", "--epsilom", "1"]]
)
def test_wrong_usage_is_explained(run: Run, arguments: list[str]) -> None:
    status, output, complaint = run(*arguments)
    assert (status, output) == (2, b"")
    assert "usage: tapeline" in complaint


# --- examples -------------------------------------------------------------------------------------


def test_the_point_sets_are_listed(run: Run) -> None:
    status, output, _ = run("examples")
    assert status == 0
    assert {"circle", "spiral", "trefoil"} <= {line.split()[0] for line in output.decode().splitlines()}


def test_a_point_set_is_drawn_in_every_form(run: Run, tmp_path: Path) -> None:
    for form in ("csv", "json", "npy"):
        assert run("examples", "helix", "-n", 50, "--seed", 3, "-o", tmp_path / f"a.{form}")[0] == 0
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
    assert table.shape == (50, 3)
    assert np.array_equal(table, np.load(tmp_path / "a.npy"))
    assert np.array_equal(table, json.loads((tmp_path / "a.json").read_text())["points"])


def test_the_same_seed_draws_the_same_points(run: Run) -> None:
    drawn = [run("examples", "circle", "-n", 20, "--seed", seed)[1] for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]


@pytest.mark.parametrize(
    ("arguments", "names"),
    [(["heptagon"], "heptagon"), (["circle", "-n", "-5"], "-n"), (["circle", "--sigma", "7"], "--sigma")],
)
def test_what_cannot_be_drawn_is_refused(run: Run, arguments: list[str], names: str) -> None:
    status, output, complaint = run("examples", *arguments)
    assert (status, output) == (2, b"")
    assert names in one_line(complaint)


# --- processes ------------------------------------------------------------------------------------


def test_a_circle_is_reconstructed(run: Run, circle: Path) -> None:
    status, output, _ = run("reconstruct", circle)
    assert status == 0
    answer = ReconstructAnswer.model_validate_json(output)
    (curve,) = answer.curves
    assert curve.closed
    radii = np.linalg.norm(np.array(curve.vertices) - np.mean(curve.vertices, axis=0), axis=1)
    assert np.ptp(radii) < 0.05 * radii.mean()


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        ("a.json", b'{"method":"'),
        ("a.geojson", b'{"type":"FeatureCollection"'),
        ("a.csv", b"curve,x,y\n0,"),
        ("a.svg", b"<svg "),
        ("A.PNG", b"\x89PNG"),
    ],
)
def test_the_name_of_the_output_chooses_the_form(
    run: Run, circle: Path, tmp_path: Path, name: str, begins: bytes
) -> None:
    status, output, _ = run("reconstruct", circle, "-o", tmp_path / name)
    assert (status, output) == (0, b"")
    assert (tmp_path / name).read_bytes().startswith(begins)


def test_the_form_can_be_asked_for(run: Run, circle: Path, tmp_path: Path) -> None:
    status, output, _ = run("reconstruct", circle, "--format", "geojson")
    assert status == 0
    assert shapely.is_ring(shapely.get_parts(shapely.from_geojson(output)))[0]
    assert run("reconstruct", circle, "--format", "geojson", "-o", tmp_path / "curve.txt")[0] == 0
    assert (tmp_path / "curve.txt").read_bytes() == output


def test_every_way_of_giving_the_same_points_gives_the_same_answer(
    run: Run, circle: Path, tmp_path: Path
) -> None:
    points = np.loadtxt(circle, delimiter=",", skiprows=1)
    np.savetxt(tmp_path / "a.xyz", points, fmt="%.17g")
    np.save(tmp_path / "a.npy", points)
    (tmp_path / "a.json").write_text(json.dumps({"points": points.tolist()}))
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(circle.read_bytes()))
    (tmp_path / "plain").write_bytes((tmp_path / "a.npy").read_bytes())
    (tmp_path / "packed").write_bytes(gzip.compress((tmp_path / "a.json").read_bytes()))
    wanted = run("partition", circle)[1]
    assert len(PartitionAnswer.model_validate_json(wanted).labels) == 800
    for name in ("a.xyz", "a.npy", "a.json", "a.csv.gz", "plain", "packed"):
        assert run("partition", tmp_path / name)[:2] == (0, wanted)


def test_points_come_from_standard_input_too(run: Run, circle: Path) -> None:
    piped = child("partition", "-", input=circle.read_bytes())
    assert piped.returncode == 0
    assert piped.stdout == run("partition", circle)[1]


def test_options_are_the_parameters(run: Run, circle: Path) -> None:
    far = PartitionAnswer.model_validate_json(run("partition", circle, "--epsilon", "100")[1])
    assert (far.epsilon, far.epsilon_source, far.count) == (100.0, "given", 1)
    near = run("partition", circle, "--epsilon", "1e-9", "--min-component-size", "2")[1]
    assert set(PartitionAnswer.model_validate_json(near).labels) == {-1}


def test_switches_are_parameters_too(run: Run, circle: Path) -> None:
    refined, raw = (
        PcaAnswer.model_validate_json(
            run("reconstruct", circle, "--method", "pca", switch, "--include", "stages")[1]
        )
        for switch in ("--refine", "--no-refine")
    )
    assert refined.stages is not None
    assert refined.stages.balls
    assert refined.curves[0].vertices != raw.curves[0].vertices


def test_the_method_can_be_chosen(run: Run, tmp_path: Path) -> None:
    points = tmp_path / "eight.csv"
    assert run("examples", "figure_8", "-o", points)[0] == 0
    counts = {}
    for mode in ("through", "split"):
        status, output, _ = run("reconstruct", points, "--method", "skeleton", "--crossings", mode)
        assert status == 0
        counts[mode] = len(SkeletonAnswer.model_validate_json(output).curves)
    assert counts == {"through": 1, "split": 2}


def test_without_a_method_the_data_choose_and_parameters_of_both_are_taken(run: Run, circle: Path) -> None:
    status, output, _ = run("reconstruct", circle)
    assert status == 0
    answer = ReconstructAnswer.model_validate_json(output)
    assert {one.method for one in (*answer.decisions, *answer.alternatives)} == {"pca", "skeleton"}
    assert run("reconstruct", circle, "--method", "auto")[1] == output
    both = run("reconstruct", circle, "--crossings", "waist", "--no-planar", "--f-d", "1.5")
    assert both[0] == 0
    assert ReconstructAnswer.model_validate_json(both[1]).curves[0].closed


# --- diagnosis ------------------------------------------------------------------------------------


def test_a_diagnosis_is_a_report_to_read(run: Run, circle: Path, tmp_path: Path) -> None:
    status, output, _ = run("diagnose", circle)
    assert status == 0
    told = DiagnosisAnswer.model_validate_json(run("diagnose", circle, "--json")[1])
    text = output.decode()
    assert text.split(".")[0] == told.verdict.split(".")[0]
    assert f"sigma {told.sampling.sigma:.4g}" in text
    assert "1 closed, 0 open, 0 crossings" in text
    assert run("diagnose", circle, "-o", tmp_path / "a.txt")[0] == 0
    assert (tmp_path / "a.txt").read_bytes() == output
    assert run("diagnose", circle, "--format", "svg")[1].startswith(b"<svg ")


def test_a_diagnosis_can_be_of_one_method(run: Run, circle: Path) -> None:
    for method in ("pca", "skeleton"):
        told = DiagnosisAnswer.model_validate_json(run("diagnose", circle, "--json", "--method", method)[1])
        assert told.method == method
        assert {one.method for one in told.decisions} == {method}


def test_points_that_determine_no_curve_have_no_diagnosis(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1,2\n1,2\n")
    status, output, complaint = run("diagnose", path)
    assert (status, output) == (2, b"")
    assert one_line(complaint).startswith(f"tapeline: {path}: points")


# --- methods --------------------------------------------------------------------------------------


def test_the_stages_are_drawn(run: Run, circle: Path, tmp_path: Path) -> None:
    options = ["--method", "skeleton", "--include", "stages"]
    assert run("reconstruct", circle, *options, "-o", tmp_path / "a.svg")[0] == 0
    assert (tmp_path / "a.svg").read_text().count('class="panel"') == 8


@pytest.mark.parametrize(
    ("options", "method"),
    [
        (["--method", "pca", "--crossings", "split"], "auto or skeleton"),
        (["--method", "skeleton", "--no-planar"], "auto or pca"),
    ],
)
def test_a_parameter_of_another_method_is_refused(
    run: Run, circle: Path, options: list[str], method: str
) -> None:
    status, output, complaint = run("reconstruct", circle, *options)
    assert (status, output) == (2, b"")
    assert f"--method {method}" in one_line(complaint)


@pytest.mark.parametrize(
    ("options", "names"),
    [
        (["--epsilon", "-1"], "--epsilon: "),
        (["--epsilon", "wide"], "--epsilon: "),
        (["--min-component-size", "1.5"], "--min-component-size: "),
        (["-o", "curve.bmp"], "curve.bmp: "),
        (["-o", "curve"], "curve: "),
        (["-o", "no/such/folder/curve.svg"], "no/such/folder/curve.svg: "),
    ],
)
def test_wrong_options_are_named(
    run: Run, circle: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, options: list[str], names: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, output, complaint = run("partition", circle, *options)
    assert (status, output) == (2, b"")
    assert one_line(complaint).startswith(f"tapeline: {names}")


@pytest.mark.parametrize(
    ("name", "content", "place"),
    [
        ("a.csv", b"x,y\n1,2\n3,abc\n", "points[1][1]: line 3, column 2"),
        ("a.csv", b"1,2\n3,nan\n5,nan\n", "points[1][1]: line 2"),
        ("a.csv", b"", "points: there must be at least 1 point"),
        ("a.json", b'{"points": [[1, 2], [3, true]]}', "points[1][1]: "),
        ("a.json", b'{"points": [[1, 2], [3, 4, 5]]}', "points[1]: row 1 has 3 numbers, row 0 has 2"),
        ("a.json", b'{"points": [[1, 2]', "not valid JSON"),
        ("a.npy", b"PK\x03\x04", ".npy"),
        ("a.csv.gz", b"\x1f\x8bnot so", "gzip"),
        ("a.csv", b"1,2\n1,2\n1,2\n", ""),
    ],
)
def test_wrong_input_is_refused_where_it_is(
    run: Run, tmp_path: Path, name: str, content: bytes, place: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    status, output, complaint = run("reconstruct", path)
    assert (status, output) == (2, b"")
    assert one_line(complaint).startswith(f"tapeline: {path}: ")
    assert place in complaint


def test_files_that_cannot_be_read_are_named(run: Run, tmp_path: Path) -> None:
    for path in (tmp_path / "missing.csv", tmp_path):
        status, _, complaint = run("partition", path)
        assert status == 2
        assert str(path) in one_line(complaint)


def test_a_reader_that_had_enough_is_no_error_to_talk_about() -> None:
    command = f"{sys.executable} -m service.cli examples circle -n 200000 | head -n 1"
    answer = subprocess.run(["/bin/sh", "-c", command], capture_output=True, cwd=ROOT, check=False)  # noqa: S603 # ours
    assert answer.stdout == b"x,y\n"
    assert answer.stderr == b""


# --- serve ----------------------------------------------------------------------------------------


def test_it_serves(tmp_path: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    options = ["--port", str(port), "--workers", "1", "--data-dir", str(tmp_path), "--log-level", "warning"]
    process = subprocess.Popen([sys.executable, "-m", "service.cli", "serve", *options], cwd=ROOT)  # noqa: S603 # ours
    try:
        end = time.monotonic() + 60
        status = None
        while status is None and time.monotonic() < end and process.poll() is None:
            try:
                status = httpx.get(f"http://127.0.0.1:{port}/healthz").status_code
            except httpx.TransportError:
                time.sleep(0.05)
        assert status == 200
    finally:
        process.terminate()
        process.wait(30)


@pytest.mark.parametrize("options", [["--port", "http"], ["--workers", "0"], ["--port", "70000"]])
def test_settings_that_cannot_be_are_named(run: Run, options: list[str]) -> None:
    status, _, complaint = run("serve", *options)
    assert status == 2
    assert one_line(complaint).startswith(f"tapeline: {options[0]}: ")


# --- scans ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Scan a torus, into a folder."""
    folder = tmp_path_factory.mktemp("scans") / "torus"
    assert main(["examples", "torus", "--views", "8", "--pixels", "44", "-o", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a tetrahedron."""
    path = tmp_path_factory.mktemp("mesh") / "tetrahedron.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    return path


def test_solids_are_listed_and_scanned(run: Run, scans: Path) -> None:
    listed = {line.split()[0] for line in run("examples")[1].decode().splitlines()}
    assert {"torus", "bust", "circle"} <= listed
    assert sorted(path.name for path in scans.iterdir()) == [
        "torus.conf",
        *(f"torus{k}.ply" for k in range(8)),
    ]


def test_scans_become_one_closed_mesh(run: Run, scans: Path, tmp_path: Path) -> None:
    target = tmp_path / "torus.json"
    files = sorted(scans.glob("*.ply"))
    status, output, complaint = run(
        "surface", *files, "--conf", scans / "torus.conf", "--levels", 17, "--include", "slices", "-o", target
    )
    assert (status, output) == (0, b""), complaint
    answer = SurfaceAnswer.model_validate_json(target.read_bytes())
    assert (answer.report.closed, answer.report.genus) == (True, 1)
    assert answer.slices is not None
    assert len(answer.slices) == 17


def test_a_folder_stands_for_its_scans(run: Run, scans: Path) -> None:
    _, files, _ = run("slice", *sorted(scans.glob("*.ply")), "--conf", scans / "torus.conf", "--levels", 3)
    _, folder, _ = run("slice", scans, "--levels", 3)
    assert folder == files
    assert len(SliceAnswer.model_validate_json(folder).slices) == 3


def test_contours_are_those_of_slices(run: Run, tmp_path: Path, mesh: Path) -> None:
    sliced = json.loads(run("slice", mesh, "--levels", 4)[1])
    path = tmp_path / "slices.json"
    slices = [{"height": one["height"], "points": one["points"]} for one in sliced["slices"]]
    path.write_text(json.dumps({"slices": slices}))
    status, output, complaint = run("contours", path, "--no-complete")
    assert status == 0, complaint
    answer = ContoursAnswer.model_validate_json(output)
    assert [one.height for one in answer.slices] == [0.125, 0.375, 0.625, 0.875]


@pytest.mark.parametrize("form", ["stl", "obj", "ply", "glb"])
def test_the_ending_chooses_the_form_of_a_mesh(run: Run, tmp_path: Path, mesh: Path, form: str) -> None:
    target = tmp_path / f"mesh.{form}"
    assert run("surface", mesh, "--levels", 40, "--axis", "1,2,2", "-o", target)[0] == 0
    made = trimesh.load(target, force="mesh")
    made.merge_vertices()
    assert made.is_watertight
    assert made.volume == pytest.approx(1 / 6, rel=0.03)


def test_scans_come_from_standard_input_too() -> None:
    document = {"meshes": [{"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 1]], "faces": [[0, 1, 2]]}]}
    done = child("slice", "-", "--levels", 2, input=json.dumps(document).encode())
    assert done.returncode == 0, done.stderr
    assert len(SliceAnswer.model_validate_json(done.stdout).slices) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["slice", "nothing.ply"], "nothing.ply: No such file"),
        (["slice", "{mesh}", "{empty}"], "empty.ply: the body is not a sound PLY file"),
        (["slice", "{mesh}", "--levels", "0"], "--levels: "),
        (["slice", "{mesh}", "--heights", "5,6"], "--heights: No plane cuts anything"),
        (["slice", "{mesh}", "--axis", "0,0"], "--axis: "),
        (["slice", "{scan}", "--conf", "{conf}"], "names no scan of this name"),
        (["slice", "{folder}"], "there is no scan in this folder"),
        (["examples", "torus"], "name a folder"),
        (["examples", "torus", "-n", "5", "-o", "x"], "-n: torus is not drawn with this"),
        (["examples", "circle", "--views", "5"], "--views: circle is not drawn with this"),
        (["examples", "torus", "--pixels", "1", "-o", "x"], "--pixels: "),
        (["examples", "torus", "--sigma", "-1", "-o", "x"], "--sigma: "),
    ],
)
def test_what_is_wrong_with_scans_is_told_in_a_line(
    run: Run, tmp_path: Path, scans: Path, mesh: Path, arguments: list[str], words: str
) -> None:
    places = {"mesh": mesh, "scan": scans / "torus0.ply"}
    for name in ("empty.ply", "other.conf"):
        places[name.partition(".")[0].replace("other", "conf")] = tmp_path / name
        (tmp_path / name).write_bytes(b"")
    places["folder"] = tmp_path / "folder"
    places["folder"].mkdir()
    status, output, complaint = run(*(argument.format(**places) for argument in arguments))
    assert (status, output) == (2, b"")
    assert words in one_line(complaint)


def test_a_terminal_is_told_how_far_it_has_come(circle: Path) -> None:
    reader, terminal = os.openpty()
    done = child("partition", circle, "-o", os.devnull, "--format", "json", stderr=terminal)
    os.close(terminal)
    told = os.read(reader, 10_000).decode()
    os.close(reader)
    assert done.returncode == 0
    assert "  0% partitioning" in told
    assert "100% done" in told
    assert told.endswith("\r\x1b[K")  # nothing is left of it
