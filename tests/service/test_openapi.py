from __future__ import annotations

from pathlib import Path
from typing import Any

import httpx
import pytest

from service.app import create_app
from service.intake import MEDIA_TYPES
from service.openapi import main, write
from service.processes import PROCESSES, Process
from service.render import FORMS
from service.settings import Settings

SNAPSHOT = Path(__file__).parents[2] / "openapi" / "openapi.json"


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return create_app(Settings()).openapi()


def references(node: object) -> set[str]:
    """All references in a document."""
    if isinstance(node, dict):
        own = {node["$ref"]} if isinstance(node.get("$ref"), str) else set()
        return own.union(*map(references, node.values()))
    return set().union(*map(references, node)) if isinstance(node, list) else set()


def test_the_document_is_the_one_in_the_repository() -> None:
    assert write() == SNAPSHOT.read_bytes(), "run make openapi, and look at what has changed"


def test_the_document_is_written_where_it_is_wanted(tmp_path: Path) -> None:
    main([str(tmp_path / "openapi.json")])
    assert (tmp_path / "openapi.json").read_bytes() == write()


def test_the_server_shows_its_document(client: httpx.Client) -> None:
    shown = client.get("/openapi.json").json()
    assert shown["openapi"].startswith("3.1")
    assert "/trial" in shown["paths"]


def test_every_reference_leads_somewhere(document: dict[str, Any]) -> None:
    parts = document["components"]
    known = {f"#/components/{part}/{name}" for part in parts for name in parts[part]}
    assert references(document) <= known
    assert not references(document).isdisjoint(known)


@pytest.mark.parametrize("row", PROCESSES, ids=lambda row: row.id)
def test_a_process_is_described_as_the_table_says(document: dict[str, Any], row: Process) -> None:
    operation = document["paths"][row.path]["post"]
    assert set(operation["requestBody"]["content"]) == set(MEDIA_TYPES[row.takes])
    assert set(operation["responses"]["200"]["content"]) == {FORMS[form] for form in row.forms}
    named = {one["name"] for one in operation["parameters"] if one["in"] == "query"}
    assert named == set(row.parameters.model_fields) | {"format"} | ({"include"} if row.include else set())


def described(document: dict[str, Any], row: Process) -> dict[str, Any]:
    """Return the schema of a process's JSON body."""
    content = document["paths"][row.path]["post"]["requestBody"]["content"]
    name = content["application/json"]["schema"]["$ref"].rpartition("/")[2]
    schema: dict[str, Any] = document["components"]["schemas"][name]
    return schema


@pytest.mark.parametrize("row", [row for row in PROCESSES if row.takes == "points"], ids=lambda row: row.id)
def test_a_cloud_is_described_exactly(document: dict[str, Any], row: Process) -> None:
    schema = described(document, row)
    assert schema["required"] == ["points"]
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == {"points", "parameters", "include"}
    rows = schema["properties"]["points"]
    assert rows["items"]["items"] == {"type": "number"}
    assert (rows["items"]["minItems"], rows["items"]["maxItems"]) == (2, 3)


@pytest.mark.parametrize("row", [row for row in PROCESSES if row.takes == "scans"], ids=lambda row: row.id)
def test_scans_are_described_exactly(document: dict[str, Any], row: Process) -> None:
    schema = described(document, row)
    assert "required" not in schema
    assert schema["additionalProperties"] is False
    kinds = {"meshes", "range_images", "slices", "contours"}
    assert set(schema["properties"]) == kinds | {"parameters", "include"}
    image = document["components"]["schemas"]["RangeImageInput"]["properties"]["points"]
    pixel = image["items"]["items"]["anyOf"]
    assert [one["type"] for one in pixel] == ["array", "null"]
    assert (pixel[0]["minItems"], pixel[0]["maxItems"]) == (3, 3)


def test_every_error_is_described_as_a_problem(document: dict[str, Any]) -> None:
    for operations in document["paths"].values():
        for operation in operations.values():
            for status, response in operation["responses"].items():
                if not status.startswith("2"):
                    assert list(response["content"]) == ["application/problem+json"]
