"""Parameters in the query string, for bodies that have no room for them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from service.intake.errors import ErrorItem, refuse

__all__ = ["Query", "read_query"]

Query = Mapping[str, str] | Iterable[tuple[str, str]]
"""A mapping, or pairs: only pairs can tell that a name came twice."""

_OF_THE_ROUTE = {"format"}  # says how to answer, not what to compute
_NULLS = {"", "null"}


def read_query(query: Query, model: type[BaseModel]) -> tuple[dict[str, Any], list[str]]:
    """Convert the parameters of a query string to the types of a model.

    Parameters
    ----------
    query : mapping or pairs of str
        Values as text; an empty one and ``null`` mean null.
    model : type of BaseModel
        The parameters; what they may be is checked later, together with those of the body.

    Returns
    -------
    parameters : dict
        Values by name, converted from text.
    include : list of str
        All values of ``include``, which may be repeated or separated by commas.

    Raises
    ------
    IntakeError
        422 for names that are unknown or come twice, and for text that is no value of its type.
    """
    parameters: dict[str, str] = {}
    include: list[str] = []
    for name, value in query.items() if isinstance(query, Mapping) else query:
        if name == "include":
            include += [part.strip() for part in value.split(",") if part.strip()]
        elif name in parameters:
            raise refuse("invalid-parameter", "a parameter came twice", ("query", name), "repeated")
        elif name not in _OF_THE_ROUTE:
            parameters[name] = value
    return _converted(parameters, model), include


def _converted(parameters: Mapping[str, str], model: type[BaseModel]) -> dict[str, Any]:
    known: dict[str, Any] = {
        name: None for name, value in parameters.items() if value.strip().lower() in _NULLS
    }
    texts = {name: value for name, value in parameters.items() if name not in known}
    for name in texts.keys() & _sequences(model):
        known[name] = _numbers(texts.pop(name), name)
    try:
        values = model.model_validate_strings(texts)
    except ValidationError as error:
        items: list[ErrorItem] = [
            {"loc": ["query", *item["loc"]], "msg": item["msg"], "type": item["type"]}
            for item in error.errors(include_url=False, include_input=False, include_context=False)
        ]
        where = ".".join(map(str, items[0]["loc"][1:]))
        raise refuse("invalid-parameter", f"{where}: {items[0]['msg']}"[:300], errors=items) from None
    return known | {name: getattr(values, name) for name in values.model_fields_set}


def _sequences(model: type[BaseModel]) -> set[str]:
    """Name the parameters that are several numbers."""
    return {
        name
        for name, field in model.model_fields.items()
        if tuple in {get_origin(one) for one in (field.annotation, *get_args(field.annotation))}
    }


def _numbers(text: str, name: str) -> list[float]:
    """Read numbers separated by commas or blanks, in brackets or not."""
    words = text.strip().removeprefix("[").removesuffix("]").replace(",", " ").split()
    try:
        return [float(word) for word in words]
    except ValueError:
        detail = f"{name}: this is no list of numbers, such as 0,0,1"
        raise refuse("invalid-parameter", detail, ("query", name), "float_parsing") from None
