"""What is deployed is what there is: settings by their names, commands that parse, paths that are served."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from service.app import create_app
from service.cli import _parser
from service.settings import Settings

DEPLOY = Path(__file__).parents[1] / "deploy"
DOCKERFILE = DEPLOY.parent / "Dockerfile"
SETTINGS = {f"TAPELINE_{name.upper()}" for name in Settings.model_fields}


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    document: dict[str, Any] = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
    return document


@pytest.fixture(scope="module")
def kubernetes() -> list[dict[str, Any]]:
    return list(yaml.safe_load_all((DEPLOY / "kubernetes.yaml").read_text()))


def containers(documents: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [
        container
        for document in documents
        if document["kind"] == "Deployment"
        for container in document["spec"]["template"]["spec"]["containers"]
    ]


@pytest.mark.parametrize("path", [*DEPLOY.iterdir(), DOCKERFILE], ids=lambda path: path.name)
def test_every_variable_is_a_setting(path: Path) -> None:
    assert set(re.findall(r"\bTAPELINE_[A-Z_]+", path.read_text())) <= SETTINGS


def test_settings_in_containers_are_sound(compose: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    for service in compose["services"].values():
        for name, value in service.get("environment", {}).items():
            if name in SETTINGS:
                monkeypatch.setenv(name, value)
    assert Settings(_env_file=None).job_workers == 0


def test_two_servers_leave_jobs_to_workers_on_one_database_and_one_store(compose: dict[str, Any]) -> None:
    services = compose["services"]
    servers = [one for name, one in services.items() if name.startswith("api")]
    worker = services["worker"]
    assert len(servers) == 2
    assert {one["environment"]["TAPELINE_JOB_WORKERS"] for one in servers} == {"0"}
    for name in ("TAPELINE_DATABASE_URL", "TAPELINE_STORE_URL"):
        assert len({one["environment"][name] for one in [*servers, worker]}) == 1
    assert all("store:/store" in one["volumes"] for one in [*servers, worker])


def test_workers_are_started_by_a_command_that_there_is(
    compose: dict[str, Any], kubernetes: list[dict[str, Any]]
) -> None:
    commands = [compose["services"]["worker"]["command"]]
    commands += [container["command"] for container in containers(kubernetes) if "command" in container]
    assert len(commands) == 2
    for program, *arguments in commands:
        assert program == "tapeline"
        assert _parser().parse_args(arguments).run.__name__ == "_work"


def test_probes_ask_for_paths_that_are_served(kubernetes: list[dict[str, Any]]) -> None:
    served = create_app(Settings(_env_file=None)).openapi()["paths"]
    probes = [
        container[probe]["httpGet"]["path"]
        for container in containers(kubernetes)
        for probe in ("startupProbe", "readinessProbe", "livenessProbe")
        if "httpGet" in container.get(probe, {})
    ]
    assert set(probes) == {"/healthz", "/readyz"} <= set(served)


def test_the_beat_is_looked_for_where_the_image_keeps_its_data(
    compose: dict[str, Any], kubernetes: list[dict[str, Any]]
) -> None:
    (directory,) = re.findall(r"TAPELINE_DATA_DIR=(\S+)", DOCKERFILE.read_text())
    looked = [compose["services"]["worker"]["healthcheck"]["test"][1:]]
    looked += [
        container["livenessProbe"]["exec"]["command"]
        for container in containers(kubernetes)
        if "exec" in container.get("livenessProbe", {})
    ]
    assert {command[1] for command in looked} == {f"{directory}/beat"}
    assert len(looked) == 2
