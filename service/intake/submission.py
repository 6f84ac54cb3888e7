"""From a document — points or scans, parameters, what to include — to checked arrays and models."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from core.surface.results import Scans
from service.intake.envelope import Reply
from service.intake.errors import MAX_LISTED, ErrorItem, IntakeError, refuse
from service.intake.query import Query, read_query
from service.intake.scans import KINDS, size_of
from service.intake.schema import Takes, submission_model

__all__ = ["Limits", "Submission", "check_document"]

Place = tuple[str | int, ...]
_KINDS = dict.fromkeys(("points", *KINDS), "invalid-points") | {"parameters": "invalid-parameter"}


@dataclass(frozen=True, slots=True)
class Limits:
    """How much one body may bring: number of points, and bytes before and after decompression."""

    max_points: int
    max_bytes: int


@dataclass(frozen=True, slots=True, eq=False)
class Submission:
    """What a client sent, checked.

    Attributes
    ----------
    data : (N, 2) or (N, 3) array, or Scans
        Points are C-contiguous float64, finite, N at least 1.
    parameters : BaseModel
        An instance of the model that was asked for.
    include : frozenset of str
        Extra parts that the answer shall contain.
    reply : Reply
        What an execute request says of the answer.
    """

    data: NDArray[np.float64] | Scans
    parameters: BaseModel
    include: frozenset[str]
    reply: Reply = field(default_factory=Reply)

    @property
    def points(self) -> NDArray[np.float64] | None:
        """The points, which pictures show; None for scans."""
        return None if isinstance(self.data, Scans) else self.data


def check_document(
    document: object,
    query: Query,
    parameters_model: type[BaseModel],
    include_allowed: frozenset[str],
    limits: Limits,
    loc: Place = ("body",),
    takes: Takes = "points",
) -> Submission:
    """Check ``{"points": …, "parameters": …, "include": …}``, with what the query string adds.

    Where a process takes scans, they come in place of ``points``.

    Parameters
    ----------
    document : object
        A parsed JSON value; ``points`` may be an array instead of rows.
    query : mapping or pairs of str
        Parameters may come from here and from the document, but each only once.
    parameters_model : type of BaseModel
    include_allowed : frozenset of str
    limits : Limits
    loc : tuple
        Where the document lies in the body, for the places of errors.
    takes : {"points", "scans"}

    Raises
    ------
    IntakeError
        413 for too many points, 422 for anything that is not as declared.
    """
    asked, include = read_query(query, parameters_model)
    queried: set[Place] = {("parameters", name) for name in asked}
    model: Any = submission_model(parameters_model, include_allowed, takes)
    if isinstance(document, dict):
        if include and "include" not in document:
            queried.add(("include", 0))
        _check_count(document, takes, limits.max_points)
        document = _merged(document, asked, include, loc)
        document = _without_excess(document, model.model_fields)
        if isinstance(document.get("parameters"), dict):
            document["parameters"] = _without_excess(document["parameters"], parameters_model.model_fields)
    try:
        checked: Any = model.model_validate(document)
    except ValidationError as error:
        raise _invalid(error, queried, loc) from None
    data = checked.points if takes == "points" else checked.scans()
    return Submission(data, checked.parameters, frozenset(checked.include))


def _check_count(document: dict[str, Any], takes: Takes, limit: int) -> None:
    count = size_of(document) if takes == "scans" else _count(document.get("points"))
    if count > limit:
        raise refuse("too-many-points", f"{count} points are more than the {limit} allowed; thin them out")


def _count(points: Any) -> int:
    sized = isinstance(points, list) or (isinstance(points, np.ndarray) and points.ndim > 0)
    return len(points) if sized else 0


def _merged(
    document: dict[str, Any], asked: Mapping[str, Any], include: Iterable[str], loc: Place
) -> dict[str, Any]:
    """Add what the query string says; a parameter given in both places is an error."""
    merged = dict(document)
    given = merged.get("parameters", {})
    if asked and isinstance(given, dict):
        for name in asked.keys() & given.keys():
            detail = f"{name} is given both in the body and in the query"
            raise refuse("invalid-parameter", detail, (*loc, "parameters", name), "repeated")
        merged["parameters"] = {**given, **asked}
    listed = merged.get("include", [])
    if include and isinstance(listed, list):
        merged["include"] = [*listed, *include]
    return merged


def _without_excess(mapping: Mapping[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """Drop unknown names beyond those that an answer lists: a million of them need no million errors."""
    names = set(known)
    kept = names | set(islice((name for name in mapping if name not in names), MAX_LISTED))
    return {name: value for name, value in mapping.items() if name in kept}


def _invalid(error: ValidationError, queried: set[Place], loc: Place) -> IntakeError:
    """Translate pydantic's errors into ours, with places in the body or in the query."""
    found = error.errors(include_url=False, include_input=False, include_context=False)
    items: list[ErrorItem] = []
    for item in found:
        place = item["loc"]
        name = place[0] if place[:1] == ("include",) else place[1] if len(place) > 1 else ""
        where = ("query", name) if place[:2] in queried else (*loc, *place)
        items.append({"loc": list(where), "msg": item["msg"], "type": item["type"]})
    member = str(found[0]["loc"][0]) if found[0]["loc"] else ""
    return refuse(_KINDS.get(member, "invalid-input"), _sentence(items), errors=items)


def _sentence(items: list[ErrorItem]) -> str:
    """Put the first error in words, and say how many there are."""
    first = items[0]
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part[:40]}" for part in first["loc"])
    more = f" (and {len(items) - 1} more)" if len(items) > 1 else ""
    return f"{place[1:]}: {first['msg'][:300]}{more}"
