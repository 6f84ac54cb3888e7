"""JSON schemas that stand alone, and mean the same in JSON Schema 2020-12 and in OpenAPI 3.0.

The standard's descriptions of processes admit the schemas of OpenAPI 3.0 only
(18-062r2, schema.yaml), which know neither references into ``$defs`` nor
``null`` nor bounds that are excluded by a number. What pydantic says with
those can be said without.
"""

from __future__ import annotations

from typing import Any

__all__ = ["KEYWORDS", "portable"]

Schema = dict[str, Any]

KEYWORDS = frozenset(
    {"title", "description", "default", "deprecated", "readOnly", "writeOnly"}
    | {"type", "enum", "not", "allOf", "oneOf", "anyOf"}
    | {"properties", "additionalProperties", "required", "maxProperties", "minProperties"}
    | {"items", "maxItems", "minItems", "uniqueItems"}
    | {"multipleOf", "maximum", "minimum", "maxLength", "minLength", "pattern", "format"}
    | {"contentMediaType", "contentEncoding"}
)
"""The keywords that both know and take for the same."""

_BOUNDS = {"exclusiveMinimum": "minimum", "exclusiveMaximum": "maximum"}


def portable(schema: Schema, definitions: Schema | None = None) -> Schema:
    """Rewrite a schema with `KEYWORDS` alone; what they cannot say is left out.

    Parameters
    ----------
    schema : dict
        A schema of pydantic's, without references that run in circles.
    definitions : dict, optional
        What its references lead to; its own ``$defs`` by default.

    >>> portable({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "null"}]})["anyOf"]
    [{'type': 'number', 'minimum': 0, 'not': {'enum': [0]}}, {'enum': [None]}]
    """
    definitions = schema.get("$defs", {}) if definitions is None else definitions
    schema = _resolved(schema, definitions)
    written: Schema = {}
    excluded = []
    for keyword, value in schema.items():
        if keyword in _BOUNDS:
            written[_BOUNDS[keyword]] = value
            excluded.append(value)
        elif keyword == "const":
            written["enum"] = [value]
        elif keyword == "type" and value == "null":
            written["enum"] = [None]
        elif keyword == "prefixItems" and all(one == value[0] for one in value):
            written["items"] = portable(value[0], definitions)
        elif keyword in KEYWORDS:
            written[keyword] = _within(keyword, value, definitions)
    if excluded:
        written["not"] = {"enum": excluded}
    return written


def _resolved(schema: Schema, definitions: Schema) -> Schema:
    """Put what a reference leads to in its place; what stands beside the reference counts more."""
    while "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        schema = definitions[name] | {key: value for key, value in schema.items() if key != "$ref"}
    return schema


def _within(keyword: str, value: Any, definitions: Schema) -> Any:
    """Rewrite the schemas inside of a schema."""
    if keyword in {"allOf", "oneOf", "anyOf"}:
        return [portable(one, definitions) for one in value]
    if keyword == "properties":
        return {name: portable(one, definitions) for name, one in value.items()}
    if keyword in {"items", "not", "additionalProperties"} and isinstance(value, dict):
        return portable(value, definitions)
    return value
