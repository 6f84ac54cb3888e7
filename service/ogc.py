"""The table of processes in the words of OGC API – Processes 1.0 (18-062r2).

docs/decisions/ogc-processes.md says how far the standard is met.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from service import __version__
from service.answers import (
    InputDescription,
    Link,
    OutputDescription,
    ProcessDescription,
    ProcessSummary,
)
from service.intake import submission_model
from service.processes import Process
from service.render import FORMS
from service.schemas import portable

__all__ = ["CONFORMS_TO", "ENVELOPE", "LINKS", "describe", "summarise"]

ENVELOPE = "inputs"
"""The member of an execute request that holds what plain requests consist of."""

_SPECIFICATION = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf"
_RELATION = "http://www.opengis.net/def/rel/ogc/1.0"

CONFORMS_TO = [
    f"{_SPECIFICATION}/{name}" for name in ("core", "ogc-process-description", "json", "job-list", "dismiss")
]
"""The conformance classes that are met."""

LINKS = (
    Link(
        href="/conformance",
        rel=f"{_RELATION}/conformance",
        type="application/json",
        title="What of OGC API – Processes is met",
    ),
    Link(
        href="/processes",
        rel=f"{_RELATION}/processes",
        type="application/json",
        title="All processes, as OGC API – Processes describes them",
    ),
    Link(href="/jobs", rel=f"{_RELATION}/job-list", type="application/json", title="All jobs"),
)
"""From the landing document to the resources of the standard."""

_TITLES = {
    "points": "Points",
    "meshes": "Meshes",
    "range_images": "Range images",
    "slices": "Slices",
    "contours": "Contours",
    "parameters": "Parameters",
    "include": "Parts to include",
}


def summarise(process: Process) -> ProcessSummary:
    """Describe a process in a list."""
    own = Link(href=f"/processes/{process.id}", rel="self", type="application/json", title=process.title)
    return ProcessSummary(**_common(process), links=[own])


@lru_cache(maxsize=64)
def describe(process: Process) -> ProcessDescription:
    """Describe a process with its inputs and its output."""
    path = f"/processes/{process.id}"
    links = [
        Link(href=path, rel="self", type="application/json", title=process.title),
        Link(
            href=f"{path}/execution",
            rel=f"{_RELATION}/execute",
            type="application/json",
            title="Where to post execute requests",
        ),
    ]
    return ProcessDescription(
        **_common(process), links=links, inputs=_inputs(process), outputs={"result": _output(process)}
    )


def _common(process: Process) -> dict[str, Any]:
    return {
        "id": process.id,
        "title": process.title,
        "description": process.description,
        "version": __version__,
        "jobControlOptions": ["sync-execute", "async-execute", "dismiss"],
        "outputTransmission": ["value"],
    }


def _inputs(process: Process) -> dict[str, InputDescription]:
    """Describe each member of a plain request as an input."""
    schema = portable(
        submission_model(process.parameters, process.include, process.takes).model_json_schema()
    )
    members = schema["properties"] if process.include else _without(schema["properties"], "include")
    return {
        name: InputDescription.model_validate(
            {
                "title": _TITLES[name],
                "description": described.get("description", ""),
                "minOccurs": int(name in schema.get("required", ())),
                "schema": described,
            }
        )
        for name, described in members.items()
    }


def _without(members: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in members.items() if key != name}


def _output(process: Process) -> OutputDescription:
    schemas = [_form(process, form) for form in process.forms]
    return OutputDescription.model_validate(
        {
            "title": "Result",
            "description": "In the form that Accept or the request's outputs ask for; the first by default.",
            "schema": schemas[0] if len(schemas) == 1 else {"oneOf": schemas},
        }
    )


def _form(process: Process, form: str) -> dict[str, Any]:
    media_type = FORMS[form]
    kind = {"contentMediaType": media_type}
    if form == "json":
        return portable(process.answer.model_json_schema(mode="serialization")) | kind
    if form == "geojson":
        named = {"type": {"type": "string", "enum": ["FeatureCollection"]}}
        return {"type": "object", "properties": named, "required": ["type"]} | kind
    text = media_type.startswith("text/") or media_type.endswith("+xml")
    return {"type": "string"} | kind | ({} if text else {"contentEncoding": "binary"})
