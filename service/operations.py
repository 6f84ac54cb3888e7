"""What the OpenAPI document says of each operation, derived from the table of processes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema
from starlette.responses import Response

from service.answers import ProblemDocument, ResultDocument, StatusInfo
from service.intake import MEDIA_TYPES, Takes, execute_model, submission_model
from service.problems import MEDIA_TYPE
from service.processes import Process
from service.render import FORMS

__all__ = ["document", "execution_operation", "problems", "process_operation"]

_REFERENCE = "#/components/schemas/{model}"
_BINARY = {"type": "string", "format": "binary"}
_WITH_RETRY = {429, 503}
_MEANINGS = {
    400: "The body cannot be read.",
    404: "There is nothing of this name.",
    406: "No form of the answer that is offered is acceptable.",
    413: "Too many points or bytes, as sent or after decompression.",
    415: "The media type or the content encoding is not supported.",
    422: "A value is out of range, or the points determine no curve; `errors` says where.",
    429: "Too many requests are waiting.",
    503: "The workers are not ready, the work took too long, or it was interrupted.",
}
_EXAMPLES: dict[Takes, str] = {"points": "ellipse", "scans": "cylinder"}
_EXECUTION = "{}-execution"

ACCEPTED: dict[str, Any] = {
    "description": "The answer takes longer than the client waits: it comes as a job.",
    "model": StatusInfo,
    "headers": {
        "Location": {"description": "Where the job is.", "schema": {"type": "string"}},
        "Preference-Applied": {
            "description": "Which preferences were heeded.",
            "schema": {"type": "string"},
        },
    },
}
"""What is answered when a job is taken."""

HEADERS: list[dict[str, Any]] = [
    {
        "name": "Prefer",
        "in": "header",
        "required": False,
        "description": "`respond-async`: answer at once with a job; `wait=N`: wait N seconds for the answer "
        "before that (RFC 7240).",
        "schema": {"type": "string"},
    },
    {
        "name": "Idempotency-Key",
        "in": "header",
        "required": False,
        "description": "The same key and body give the same job, however often they are sent.",
        "schema": {"type": "string", "maxLength": 255},
    },
]
"""How a client says when it wants its answer."""


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Describe the problem documents of an operation, by status."""
    return {status: _problem(status) for status in statuses}


def _problem(status: int) -> dict[str, Any]:
    described: dict[str, Any] = {
        "description": _MEANINGS[status],
        "content": {MEDIA_TYPE: {"schema": _reference(ProblemDocument)}},
    }
    if status in _WITH_RETRY:
        header = {"description": "Seconds after which to try again.", "schema": {"type": "integer"}}
        described["headers"] = {"Retry-After": header}
    return described


def process_operation(process: Process) -> dict[str, Any]:
    """Give the keyword arguments of ``add_api_route`` that document a process."""
    return {
        "operation_id": process.id.replace("-", "_"),
        "summary": process.title,
        "description": process.description,
        "response_class": Response,
        "responses": {
            200: _answers(process),
            201: ACCEPTED,
            **problems(400, 406, 413, 415, 422, 429, 503),
        },
        "openapi_extra": {
            "requestBody": _body(
                process, submission_model(process.parameters, process.include, process.takes)
            ),
            "parameters": [*_query(process), *HEADERS],
        },
    }


def execution_operation(process: Process) -> dict[str, Any]:
    """Give the keyword arguments of ``add_api_route`` that document the execution of a process."""
    operation = process_operation(process)
    answers = {**_answers(process), "model": process.answer | ResultDocument}
    body = _body(process, execute_model(process.parameters, process.include, process.takes))
    return {
        **operation,
        "operation_id": f"execute_{operation['operation_id']}",
        "summary": f"Execute: {process.title}",
        "responses": {**operation["responses"], 200: answers},
        "openapi_extra": {**operation["openapi_extra"], "requestBody": body},
    }


def _answers(process: Process) -> dict[str, Any]:
    others = {FORMS[form]: {"schema": _form_schema(FORMS[form])} for form in process.forms if form != "json"}
    return {"description": process.title, "model": process.answer, "content": others}


def _form_schema(media_type: str) -> dict[str, Any]:
    if media_type.endswith("json"):
        return {"type": "object"}
    return {"type": "string"} if media_type.startswith("text/") or "xml" in media_type else _BINARY


def _body(process: Process, model: type[BaseModel]) -> dict[str, Any]:
    example = _EXAMPLES[process.takes]
    if "inputs" in model.model_fields:
        example = _EXECUTION.format(example)
    special = {
        "application/json": {
            "schema": _reference(model),
            "examples": {example: {"$ref": f"#/components/examples/{example}"}},
        },
        "multipart/form-data": {"schema": _form(process)},
    }
    content = {name: special.get(name, {"schema": _form_schema(name)}) for name in MEDIA_TYPES[process.takes]}
    return {"required": True, "content": content, "description": _BODIES[process.takes]}


_POINTS = (
    "A point cloud. JSON and forms bring their parameters along; with the other media types they are query "
    "parameters. `Content-Encoding: gzip` is understood. Text has a point a line, its coordinates separated "
    "by commas or blanks; `.npy` is an array of shape (N, 2) or (N, 3)."
)
_SCANS = (
    "Meshes and range images, or slices, or contours. JSON and forms bring their parameters along; with the "
    "other media types they are query parameters. A form may have several files, all in the field `file`: "
    "PLY range grids with the `.conf` file that holds their poses, and meshes as PLY, STL or OBJ. "
    "`Content-Encoding: gzip` is understood."
)
_BODIES: dict[Takes, str] = {"points": _POINTS, "scans": _SCANS}


def _form(process: Process) -> dict[str, Any]:
    parameters = {
        "type": "string",
        "contentMediaType": "application/json",
        "contentSchema": _reference(process.parameters),
    }
    files = {"type": "array", "items": _BINARY, "minItems": 1}
    return {
        "type": "object",
        "required": ["file"],
        "properties": {"file": _BINARY if process.takes == "points" else files, "parameters": parameters},
        "additionalProperties": False,
    }


def _query(process: Process) -> list[dict[str, Any]]:
    schema = process.parameters.model_json_schema(ref_template=_REFERENCE)
    listed = [_parameter(name, dict(described)) for name, described in schema["properties"].items()]
    if process.include:
        names = {"type": "array", "items": {"enum": sorted(process.include), "type": "string"}}
        listed.append(
            _parameter("include", names | {"description": "Extra parts that the answer shall contain."})
        )
    forms = {
        "type": "string",
        "enum": list(process.forms),
        "description": "Form of the answer, instead of Accept.",
    }
    return [*listed, _parameter("format", forms)]


def _parameter(name: str, schema: dict[str, Any]) -> dict[str, Any]:
    described = {"name": name, "in": "query", "required": False, "description": schema.pop("description", "")}
    if "array" in {one.get("type") for one in schema.get("anyOf", [schema])}:
        described |= {"style": "form", "explode": False}
    return described | {"schema": schema}


def _reference(model: type[BaseModel]) -> dict[str, str]:
    return {"$ref": _REFERENCE.format(model=model.__name__)}


def _ellipse() -> dict[str, Any]:
    """Make a body to try: samples of an ellipse, out of place by what looks like noise."""
    points = []
    for k in range(80):
        angle, out = 2 * math.pi * k / 80, 1 + 0.02 * math.sin(5.3 * k * k)
        points.append([round(2 * out * math.cos(angle), 3), round(out * math.sin(angle), 3)])
    return {"summary": "A noisy ellipse", "value": {"points": points}}


def _cylinder() -> dict[str, Any]:
    """Make scans to try: half of a cylinder's side from each of two places, as range images."""
    images = []
    for view in (0.0, math.pi):
        angles = [view + 0.2 * k for k in range(-9, 10)]
        ring = [(round(10 * math.cos(angle), 3), round(10 * math.sin(angle), 3)) for angle in angles]
        images.append({"points": [[[x, y, z] for x, y in ring] for z in range(0, 21, 2)]})
    value = {"range_images": images, "parameters": {"levels": 5}}
    return {"summary": "Two range images of a cylinder", "value": value}


def _execution(example: dict[str, Any]) -> dict[str, Any]:
    return example | {"value": {"inputs": example["value"], "response": "raw"}}


def _examples() -> dict[str, Any]:
    plain = {"ellipse": _ellipse(), "cylinder": _cylinder()}
    return plain | {_EXECUTION.format(name): _execution(example) for name, example in plain.items()}


def document(app: FastAPI, table: Iterable[Process]) -> dict[str, Any]:
    """Make the OpenAPI document of the application, once.

    The bodies of the processes are read by the workers and not by the
    framework, which therefore does not know their schemas: they are added here.
    """
    if app.openapi_schema is None:
        described = get_openapi(
            title=app.title,
            version=app.version,
            summary=app.summary,
            description=app.description,
            license_info=app.license_info,
            tags=app.openapi_tags,
            routes=app.routes,
        )
        models = [execute_model(row.parameters, row.include, row.takes) for row in table] + [ProblemDocument]
        _, added = models_json_schema([(model, "validation") for model in models], ref_template=_REFERENCE)
        schemas = described.setdefault("components", {}).setdefault("schemas", {})
        schemas.update(added["$defs"])
        described["components"]["schemas"] = dict(sorted(schemas.items()))
        described["components"]["examples"] = _examples()
        app.openapi_schema = described
    return app.openapi_schema
