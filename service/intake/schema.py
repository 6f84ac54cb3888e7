"""The one declaration of a point set: how it is checked, and how OpenAPI describes it.

`Points` is an ``ndarray`` to the program and an array of arrays of numbers to
the reader of the OpenAPI document. Rows of numbers are converted by the C code
of the standard library; on any doubt pydantic's own list schema decides, and
says where the error is.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
    create_model,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from service.intake.errors import MAX_LISTED

__all__ = ["Points", "submission_model"]

Floats = NDArray[np.float64]
_CHUNK = 4096  # rows that pydantic looks at before we ask whether there are errors enough


def _to_array(value: object, handler: ValidatorFunctionWrapHandler) -> Floats:
    """Turn rows of numbers, or an array, into a C-contiguous float64 array of shape (N, 2) or (N, 3)."""
    if isinstance(value, np.ndarray):
        return _checked(value)
    points = _from_rows(value) if isinstance(value, list) else None
    return _checked(_by_schema(value, handler) if points is None else points)


def _from_rows(rows: list[Any]) -> Floats | None:
    """Convert equally long rows of numbers; None when there is any doubt."""
    try:
        widths = set(map(len, rows))
        flat = array("d", chain.from_iterable(rows))  # refuses strings, nulls, lists and huge integers
    except (TypeError, OverflowError):
        return None
    if len(widths) != 1 or not widths <= {2, 3}:
        return None
    points = np.frombuffer(flat).reshape(len(rows), widths.pop())
    # array("d") takes True for 1.0: look at the rows with a zero or a one, and only at those
    doubtful = np.flatnonzero(((points == 0.0) | (points == 1.0)).any(axis=1))
    if bool in set(map(type, chain.from_iterable(map(rows.__getitem__, doubtful.tolist())))):
        return None
    return points


def _by_schema(rows: object, handler: ValidatorFunctionWrapHandler) -> Floats:
    """Let pydantic's list schema say what is wrong, in chunks, until enough is known."""
    if not isinstance(rows, list) or not rows:
        return np.array(handler(rows), dtype=np.float64)  # raises: not a list, or an empty one
    errors: list[InitErrorDetails] = []
    for start in range(0, len(rows), _CHUNK):
        try:
            handler(rows[start : start + _CHUNK])
        except ValidationError as error:
            errors += _moved(error, start)
            if len(errors) >= MAX_LISTED:
                break
    if not errors:
        errors = list(_mixed_lengths(rows))
    if errors:
        raise _invalid(errors)
    return np.array(rows, dtype=np.float64)


def _moved(error: ValidationError, start: int) -> Iterator[InitErrorDetails]:
    """Errors of a chunk, with the row numbers that they have in the whole list."""
    for item in error.errors(include_url=False):
        row, *rest = item["loc"]
        moved = InitErrorDetails(type=item["type"], loc=(int(row) + start, *rest), input=None)
        if "ctx" in item:
            moved["ctx"] = item["ctx"]
        yield moved


def _mixed_lengths(rows: list[list[float]]) -> Iterator[InitErrorDetails]:
    width = len(rows[0])
    for number, row in enumerate(rows):
        if len(row) != width:
            context = {"row": number, "length": len(row), "first": width}
            message = "row {row} has {length} numbers, row 0 has {first}"
            yield _error("mixed_lengths", message, (number,), context)


def _checked(points: NDArray[Any]) -> Floats:
    """Check type, shape and finiteness of an array, and give it the layout that the core wants."""
    if points.dtype.kind not in "fiu":
        message = "the array must hold integers or floats, not {dtype}"
        raise PydanticCustomError("array_type", message, {"dtype": points.dtype.name})
    if points.ndim != 2 or points.shape[1] not in {2, 3}:
        message = "the array must have the shape (N, 2) or (N, 3), not {shape}"
        raise PydanticCustomError("array_shape", message, {"shape": str(points.shape)})
    if not len(points):
        raise PydanticCustomError("too_short", "there must be at least 1 point, not 0")
    with np.errstate(over="ignore"):  # an extended float beyond the doubles becomes infinite: said below
        points = np.ascontiguousarray(points, dtype=np.float64)
    finite = np.isfinite(points)
    if not finite.all():
        places = np.argwhere(~finite)[:MAX_LISTED].tolist()
        raise _invalid(_error("finite_number", "Input should be a finite number", tuple(at)) for at in places)
    return points


def _error(
    code: Any, message: Any, loc: tuple[int | str, ...], context: dict[str, Any] | None = None
) -> InitErrorDetails:
    return InitErrorDetails(type=PydanticCustomError(code, message, context), loc=loc, input=None)


def _invalid(errors: Iterable[InitErrorDetails]) -> ValidationError:
    return ValidationError.from_exception_data("points", list(errors), hide_input=True)


class _PointsSchema:
    """Gives `Points` its validator, and the schema of a list of lists to the OpenAPI document."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        number = core_schema.float_schema(strict=True, allow_inf_nan=False)
        row = core_schema.list_schema(number, min_length=2, max_length=3, strict=True)
        rows = core_schema.list_schema(row, min_length=1, strict=True)
        return core_schema.no_info_wrap_validator_function(_to_array, rows)


Points = Annotated[
    Floats,
    _PointsSchema,
    Field(
        description="The samples, one row a point: [x, y] or [x, y, z]; all rows of one length, all finite."
    ),
]


@lru_cache(maxsize=64)
def submission_model(parameters_model: type[BaseModel], include_allowed: frozenset[str]) -> type[BaseModel]:
    """Make the model of a body ``{"points": …, "parameters": …, "include": …}``.

    The same model checks every media type and describes the JSON one in the
    OpenAPI document; its name is that of the parameters with ``Submission``.
    """
    names = tuple(sorted(include_allowed))
    # list[Literal[()]] is no type: where nothing can be asked for, the list must be empty
    include: Any = list[Literal[names]] if names else Annotated[list[str], Field(max_length=0)]  # type: ignore[valid-type] # the names are data
    return create_model(
        parameters_model.__name__.removesuffix("Parameters") + "Submission",
        __config__=ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True),
        points=(Points, ...),
        parameters=(parameters_model, Field(default_factory=parameters_model)),
        include=(
            Annotated[include, Field(fail_fast=True)],
            Field(default_factory=list, description="Extra parts that the answer shall contain."),
        ),
    )
