from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import BaseModel, ValidationError
from rows import ALL

from service.intake import submission_model
from service.processes import Process
from service.schemas import KEYWORDS, portable

SAMPLES: list[Any] = [
    *(None, True, False, -1, 0, 1, 2, 3, 100, 101, 2**32 - 1, 2**32, -0.5, 0.5, 1.3, 1e-9, 1e9),
    *("", "x", "auto", "keep", "through", "split", "pca", "least_squares", "slabs", {}, {"a": 1}),
    *([], [1], [0, 1.5, 2], [0, "x", 1], [1, 2, 3, 4]),
]
_TYPES: dict[str, Any] = {
    "array": list,
    "boolean": bool,
    "integer": int,
    "number": int | float,
    "object": dict,
    "string": str,
}


def admits(schema: dict[str, Any], value: Any) -> bool:
    """Tell whether a schema admits a value, by what JSON Schema says of the keywords that decide it here."""
    kind = schema.get("type")
    if kind and (not isinstance(value, _TYPES[kind]) or (isinstance(value, bool) and kind != "boolean")):
        return False
    if "enum" in schema and not any(one == value and type(one) is type(value) for one in schema["enum"]):
        return False
    if "anyOf" in schema and not any(admits(one, value) for one in schema["anyOf"]):
        return False
    if "not" in schema and any(one == value for one in schema["not"]["enum"]):
        return False
    if isinstance(value, list):
        few, many = schema.get("minItems", 0), schema.get("maxItems", math.inf)
        return few <= len(value) <= many and all(admits(schema.get("items", {}), one) for one in value)
    number = not isinstance(value, bool) and isinstance(value, int | float)
    return not number or schema.get("minimum", -math.inf) <= value <= schema.get("maximum", math.inf)


def keywords(schema: Any) -> set[str]:
    """All keywords in a schema, those of the schemas inside of it too."""
    if not isinstance(schema, dict):
        return set()
    inside = [*schema.get("properties", {}).values(), schema.get("items"), schema.get("not")]
    inside += [schema.get("additionalProperties")]
    inside += [one for key in ("allOf", "anyOf", "oneOf") for one in schema.get(key, [])]
    return set(schema).union(*map(keywords, inside))


@pytest.mark.parametrize("row", ALL, ids=lambda row: row.id)
def test_schemas_of_processes_can_be_said_in_both_dialects(row: Process) -> None:
    for model in (submission_model(row.parameters, row.include, row.takes), row.answer):
        schema = portable(model.model_json_schema())
        assert keywords(schema) <= KEYWORDS
        assert schema["properties"].keys() == model.model_fields.keys()


def accepted(model: type[BaseModel], name: str, value: Any) -> bool:
    try:
        model.model_validate({name: value})
    except ValidationError:
        return False
    return True


@pytest.mark.parametrize("row", ALL, ids=lambda row: row.id)
def test_a_schema_admits_what_the_model_does(row: Process) -> None:
    described = portable(row.parameters.model_json_schema())["properties"]
    decided = set()
    for name, schema in described.items():
        for value in SAMPLES:
            expected = accepted(row.parameters, name, value)
            assert admits(schema, value) is expected, (name, value)
            decided.add(expected)
    assert decided == {True, False}


def test_bounds_that_are_excluded_are_excluded() -> None:
    schema = portable({"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 2})
    assert [value for value in (-1, 0, 1, 2, 3) if admits(schema, value)] == [1]


def test_what_stands_beside_a_reference_counts_more() -> None:
    definitions = {"A": {"type": "integer", "title": "A", "description": "of A"}}
    schema = {"$defs": definitions, "properties": {"a": {"$ref": "#/$defs/A", "title": "own"}}}
    assert portable(schema) == {
        "properties": {"a": {"type": "integer", "title": "own", "description": "of A"}}
    }
