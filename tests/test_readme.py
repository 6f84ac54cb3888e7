"""The README is true: what it shows is run as it stands there, and what it lists is complete."""

from __future__ import annotations

import io
import json
import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args
from xml.etree import ElementTree

import httpx
import numpy as np
import pytest
import shapely
import trimesh
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from core.parameters import (
    CommonParameters,
    PartitionParameters,
    PcaParameters,
    ReconstructParameters,
    SkeletonParameters,
)
from core.surface import ContourParameters, SliceParameters, SurfaceParameters
from service import problems
from service.answers import PartitionAnswer, ReconstructAnswer
from service.app import create_app
from service.cli import main
from service.intake import MEDIA_TYPES
from service.intake.errors import _KINDS
from service.intake.scans import KINDS
from service.processes import PROCESSES
from service.render import FORMS
from service.settings import Settings

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
ADDRESS = "http://127.0.0.1:8000"
CLIENTS = ["stand-in", *(["curl"] if shutil.which("curl") else [])]
Shell = Callable[[str], bytes]


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)


def block(language: str, word: str) -> str:
    """Return the one block in a language that has this word."""
    (only,) = [text for text in blocks(language) if word in text]
    return only


def section(title: str) -> str:
    """Return the text below a heading, up to the next heading."""
    return re.split(rf"^#+ {title}$", README, flags=re.MULTILINE)[1].split("\n#")[0]


def table(text: str) -> list[list[str]]:
    """Return the cells of the first table in a text, without its head."""
    return tables(text)[0]


def tables(text: str) -> list[list[list[str]]]:
    """Return the cells of all tables in a text, without their heads."""
    found = re.findall(r"^\|.*\n\|[-|]+\n((?:\|.*\n)+)", text, flags=re.MULTILINE)
    return [
        [[cell.strip() for cell in line.strip("|").split(" | ")] for line in rows.splitlines()]
        for rows in found
    ]


def code(text: str) -> list[str]:
    """Return what is set as code within the lines of a text."""
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"`([^`]+)`", prose)


# --- what is shown is run ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Serve as ``make run`` does, on a free port."""
    directory = tmp_path_factory.mktemp("readme")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    given = {
        "PORT": str(port),
        "WORKERS": "1",
        "JOB_WORKERS": "1",
        "DATA_DIR": str(directory / "data"),
        "LOG_LEVEL": "warning",
    }
    environment = {**os.environ, "PYTHONPATH": str(ROOT)} | {
        f"TAPELINE_{name}": value for name, value in given.items()
    }
    command = [sys.executable, "-m", "service"]
    process = subprocess.Popen(command, env=environment, cwd=directory)  # noqa: S603 # our own server
    try:
        url = f"http://127.0.0.1:{port}"
        _wait_until_ready(url, process)
        yield url
    finally:
        process.terminate()
        process.wait(20)


def _wait_until_ready(url: str, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + 300  # compiling every kernel on a slow machine
    while time.monotonic() < end and process.poll() is None:
        try:
            if httpx.get(f"{url}/readyz").status_code == 200:
                return
        except httpx.TransportError:
            pass
        time.sleep(0.05)
    pytest.fail("the server did not become ready")


@pytest.fixture(scope="module", params=CLIENTS)
def shell(request: pytest.FixtureRequest, address: str, tmp_path_factory: pytest.TempPathFactory) -> Shell:
    """Return what runs a block of commands in bash, against our server, and returns its output."""
    directory = tmp_path_factory.mktemp("shell")
    programs = {"python3": []} | ({} if request.param == "curl" else {"curl": [ROOT / "tests" / "curl.py"]})
    for name, script in programs.items():
        words = shlex.join(map(str, [sys.executable, *script]))
        (directory / name).write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        (directory / name).chmod(0o755)

    _, *words = shlex.split(block("sh", "tapeline surface").splitlines()[0])
    assert main([*words[:-1], str(directory / words[-1])]) == 0  # the scans that are spoken of

    def run(text: str) -> bytes:
        assert ADDRESS in text
        for path in written(directory):
            path.unlink()
        environment = {**os.environ, "PATH": f"{directory}{os.pathsep}{os.environ['PATH']}"}
        command = ["bash", "-euo", "pipefail", "-c", text.replace(ADDRESS, address)]
        done = subprocess.run(command, env=environment, cwd=directory, capture_output=True, check=True)  # noqa: S603 # the README's
        return done.stdout or next(written(directory)).read_bytes()

    return run


def written(directory: Path) -> Iterator[Path]:
    """Yield what commands have written."""
    return (path for ending in ("svg", "glb") for path in directory.glob(f"*.{ending}"))


def picture(text: bytes) -> tuple[str, list[str]]:
    """Return the title of an SVG, and the names of the pictures in it."""
    root = ElementTree.fromstring(text)  # noqa: S314 # our own
    title = root.findtext("{http://www.w3.org/2000/svg}title")
    assert title is not None
    return title, [view.get("id", "") for view in root.iter("{http://www.w3.org/2000/svg}view")]


def test_the_picture_shows_one_curve_and_its_cloud(shell: Shell) -> None:
    title, views = picture(shell(block("sh", "spiral.svg")))
    assert re.fullmatch(r"1 curve \((pca|skeleton)\)", title)
    assert views == []


def test_the_report_is_the_one_shown(shell: Shell) -> None:
    real = shell(block("sh", "/diagnose")).decode()
    (shown,) = blocks("text")
    assert [re.sub(r"\d+(?:\.\d+)?", "#", line) for line in shown.splitlines()] == [
        re.sub(r"\d+(?:\.\d+)?", "#", line) for line in real.splitlines()
    ]
    numbers = [np.array(re.findall(r"\d+(?:\.\d+)?", text), float) for text in (shown, real)]
    assert np.allclose(*numbers, rtol=0.05, atol=0.5)


def test_the_double_8_falls_into_its_loops(shell: Shell) -> None:
    assert picture(shell(block("sh", "double_8.svg"))) == ("4 curves (skeleton)", [])


def test_the_sheet_shows_every_stage_that_is_listed(shell: Shell) -> None:
    title, names = picture(shell(block("sh", "sheet.svg")))
    assert title == "1 curve (skeleton)"
    assert names == [code(row[0])[0] for row in table(section("Stages"))]


def test_the_readings_of_crossings_are_those_of_the_core() -> None:
    choices = SkeletonParameters.model_json_schema()["properties"]["crossings"]["enum"]
    assert [code(row[0])[0] for row in table(section("Crossings"))] == choices


def test_the_answer_is_the_one_shown(shell: Shell) -> None:
    real = shell(block("sh", "--data-binary @- http"))
    ReconstructAnswer.model_validate_json(real)
    (shown,) = blocks("json")
    assert_alike(json.loads(shown), json.loads(real))


def assert_alike(shown: Any, real: Any) -> None:
    """Check that what is shown is the real answer, rounded and shortened."""
    if isinstance(shown, dict):
        assert shown.keys() == real.keys()
        for name in shown.keys() - {"vertices", "standard_errors"}:
            assert_alike(shown[name], real[name])
        if "vertices" in shown:  # which comes first is arbitrary on a closed curve
            gaps = np.array(shown["vertices"])[:, None] - np.array(real["vertices"])
            nearest = np.linalg.norm(gaps, axis=2).argmin(axis=1)
            assert np.linalg.norm(gaps, axis=2).min(axis=1).max() < 0.01 * real["length"]
            if "standard_errors" in shown:
                errors = np.array(real["standard_errors"])[nearest]
                assert shown["standard_errors"] == pytest.approx(errors, rel=0.2)
    elif isinstance(shown, list):
        assert bool(shown) == bool(real)  # the first few are shown
        for a, b in zip(shown, real, strict=False):
            assert_alike(a, b)
    elif isinstance(shown, bool | str | None):
        assert shown == real
    else:
        assert shown == pytest.approx(real, rel=0.05, abs=0.01)


def test_the_partition_is_as_drawn(shell: Shell) -> None:
    answer = PartitionAnswer.model_validate_json(shell(block("sh", "/partition")))
    assert answer.labels == [0, 0, 0, -1]


def test_a_job_is_ordered_followed_and_fetched_as_shown(shell: Shell) -> None:
    title, _ = picture(shell(block("sh", "trefoil.svg")))
    assert title.startswith("1 curve (")


def test_a_process_is_executed_as_shown(shell: Shell) -> None:
    answer = ReconstructAnswer.model_validate_json(shell(block("sh", "/execution")))
    assert [curve.closed for curve in answer.curves] == [True]


def test_a_block_that_branches_is_drawn(shell: Shell) -> None:
    title, _ = picture(shell(block("sh", "block.svg")))
    assert "1 component" in title


def test_scans_become_a_mesh_for_viewers(shell: Shell) -> None:
    assert_whole(trimesh.load_mesh(io.BytesIO(shell(block("sh", "bust.glb"))), file_type="glb"))


def assert_whole(mesh: trimesh.Trimesh) -> None:
    """Check that a mesh is closed, in one piece and without handles."""
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh.euler_number == 2


@pytest.fixture
def commanded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Return what runs a block of commands in this process, and returns the folder that they write to."""
    monkeypatch.chdir(tmp_path)

    def run(text: str) -> Path:
        commands = [shlex.split(line) for line in text.splitlines()]
        for program, *words in commands:
            assert program == "tapeline"
            assert main(words) == 0
        for words in commands:
            assert (tmp_path / words[words.index("-o") + 1]).stat().st_size > 0
        return tmp_path

    return run


def test_scans_become_a_surface_on_the_command_line(commanded: Callable[[str], Path]) -> None:
    assert_whole(trimesh.load_mesh(commanded(block("sh", "tapeline surface")) / "bust.ply"))


def test_the_command_line_does_what_is_shown(commanded: Callable[[str], Path]) -> None:
    tmp_path = commanded(block("sh", "tapeline reconstruct"))
    assert not shapely.is_closed(
        shapely.get_parts(shapely.from_geojson((tmp_path / "spiral.geojson").read_text()))[0]
    )


def test_every_command_block_is_tested() -> None:
    tested = (
        "spiral.svg",
        "/diagnose",
        "double_8.svg",
        "sheet.svg",
        "--data-binary @- http",
        "/partition",
        "trefoil.svg",
        "/execution",
        "block.svg",
        "bust.glb",
        "tapeline surface",
        "tapeline reconstruct",
    )
    assert sorted(block("sh", word) for word in tested) == sorted(blocks("sh"))


def test_the_library_makes_a_surface_as_shown(capsys: pytest.CaptureFixture[str]) -> None:
    exec(block("python", "solid("), {})  # noqa: S102 # the README's
    closed, components, genus = capsys.readouterr().out.split()[:3]
    assert (closed, components, genus) == ("True", "1", "0")


def test_the_library_is_used_as_shown(capsys: pytest.CaptureFixture[str]) -> None:
    exec(block("python", "point_set("), {})  # noqa: S102 # the README's
    verdict, *curves = capsys.readouterr().out.splitlines()
    assert "good enough" in verdict
    assert [line.split()[0] for line in curves] == ["closed"] * 3


# --- commands ---------------------------------------------------------------------------------------


def test_every_make_command_named_exists_and_every_one_is_named() -> None:
    named = set(
        re.findall(r"^(?:\$ )?make ([a-z-]+)", "\n".join([*blocks("console"), *code(README)]), re.MULTILINE)
    )
    assert named == set(re.findall(r"^([a-z-]+):.*##", MAKEFILE, flags=re.MULTILINE)) - {"help"}


def test_the_port_and_the_python_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"Python {project['requires-python'].removeprefix('>=')} or newer" in README
    assert project["scripts"] == {"tapeline": "service.cli:main"}
    assert ADDRESS.endswith(str(Settings.model_fields["port"].default))


# --- what is listed is complete -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def openapi() -> dict[str, Any]:
    return create_app(Settings(_env_file=None)).openapi()


def test_the_endpoints_are_those_of_the_service(openapi: dict[str, Any]) -> None:
    listed = [path for row in table(section("Endpoints")) for path in code(row[0])]
    served = {
        f"{method.upper()} {_listed(path)}"
        for path, operations in openapi["paths"].items()
        for method in operations
    }
    assert sorted(listed) == sorted([*served, "GET /docs", "GET /openapi.json"])


def _listed(path: str) -> str:
    """Return a path as it is listed: once for all processes."""
    return re.sub(r"^/processes/[\w-]+/execution$", "/processes/{processID}/execution", path)


def test_the_bodies_are_those_that_are_read() -> None:
    assert {code(row[0])[0] for row in table(section("Bodies"))} == set(MEDIA_TYPES["points"])
    _, members, files, _ = tables(section("Surfaces"))
    assert [code(row[0])[0] for row in members] == list(KINDS)
    assert {code(row[0])[0] for row in files} == set(MEDIA_TYPES["scans"])


def test_the_forms_are_those_that_are_written() -> None:
    rows = table(section("Answers"))
    assert {code(row[0])[0]: code(row[1])[0] for row in rows} == FORMS
    columns = {
        "/reconstruct": 2,
        "/reconstruct/pca": 2,
        "/reconstruct/skeleton": 2,
        "/diagnose": 3,
        "/partition": 4,
        "/slice": 5,
        "/reconstruct/contours": 5,
        "/reconstruct/surface": 6,
    }
    for process in PROCESSES:
        listed = {code(row[0])[0] for row in rows if row[columns[process.path]] != "–"}
        assert set(process.forms) == listed


def fields(model: type[BaseModel]) -> set[str]:
    """Names of all fields of a model and of the models in it."""
    names = set(model.model_fields)
    for field in model.model_fields.values():
        for inner in models(field.annotation):
            names |= fields(inner)
    return names


def models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from models(part)


@pytest.mark.parametrize("answer", [row.answer for row in PROCESSES])
def test_every_field_of_an_answer_is_explained(answer: type[BaseModel]) -> None:
    text = section("Answers") + section("Stages") + section("Surfaces")
    explained = {name for part in code(text) for name in re.findall(r"[a-z_]+", part)}
    assert fields(answer) <= explained


def test_every_warning_is_named() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "core").rglob("*.py"))
    given = set(re.findall(r'\b(?:Warn|_warned)\(\s*"([a-z-]+)"', text))
    rows = [row for title in ("Answers", "Surfaces") for rows in tables(section(title)) for row in rows]
    named = [row[1].partition("codes: ")[2] for row in rows if row[0] == "`warnings[]`"]
    assert set(code(" ".join(named))) == given


def test_the_errors_are_those_of_the_service() -> None:
    listed = {code(row[0])[0]: int(row[1]) for row in table(section("Errors"))}
    known = {kind: status for status, kind, _ in problems.TABLE.values()}
    known |= {kind: status for kind, (status, _) in _KINDS.items()}
    known |= {kind: status for status, (kind, _, _) in problems._HTTP.items() if kind != "not-found"}
    assert listed == known


def parameter_row(model: type[BaseModel], name: str) -> str:
    """Return the row of a parameter as the README must have it."""
    field, schema = model.model_fields[name], model.model_json_schema()["properties"][name]
    kind = next(one for one in schema.get("anyOf", [schema]) if one.get("type") != "null")
    if "enum" in kind:
        values = ", ".join(f"`{value}`" for value in kind["enum"])
    elif kind["type"] == "boolean":
        values = "`true`, `false`"
    elif kind["type"] == "array":
        least, most = kind["minItems"], kind["maxItems"]
        values = f"{least} numbers" if least == most else f"{least} to {most} numbers"
    elif {"minimum", "maximum"} <= kind.keys():
        values = f"{kind['type']} {kind['minimum']:g} to {kind['maximum']:.10g}"
    else:
        values = f"{kind['type']} " + ("> 0" if kind.get("exclusiveMinimum") == 0 else f"≥ {kind['minimum']}")
        values += f", ≤ {kind['maximum']:g}" if "maximum" in kind else ""
    return f"| `{name}` | {values} | `{json.dumps(field.default)}` | {field.description} |".replace(
        '`"', "`"
    ).replace('"`', "`")


def setting_row(name: str, field: FieldInfo) -> str:
    """Return the row of a setting as the README must have it."""
    default = "" if field.default_factory or field.default in {(), None} else f"`{field.default}`"
    return f"| `TAPELINE_{name.upper()}` | {default} | {field.description} |"


@pytest.mark.parametrize(
    ("place", "models"),
    [
        (0, (CommonParameters, PcaParameters, SkeletonParameters, ReconstructParameters)),
        (1, (SliceParameters, ContourParameters, SurfaceParameters)),
    ],
    ids=["curves", "surfaces"],
)
def test_the_parameters_are_those_of_the_core(place: int, models: tuple[type[BaseModel], ...]) -> None:
    parts = re.split(r"also takes:|all of these, and:", section("Parameters").split("`/slice` takes:")[place])
    told: set[str] = set()
    for text, model in zip(parts, models, strict=True):
        own = [name for name in model.model_fields if name not in told]
        told |= set(own)
        rows = [parameter_row(model, name) for name in own]
        assert re.findall(r"^\| `.*$", text, flags=re.MULTILINE) == rows


def test_the_partition_takes_the_first_two() -> None:
    assert list(PartitionParameters.model_fields) == list(CommonParameters.model_fields)[:2]


def test_the_settings_are_those_of_the_service() -> None:
    rows = [setting_row(name, field) for name, field in Settings.model_fields.items()]
    assert re.findall(r"^\| `.*$", section("Settings"), flags=re.MULTILINE) == rows
