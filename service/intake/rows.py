"""Arrays in JSON bodies: rows of numbers, and grids of points.

They are an ``ndarray`` to the program and arrays of arrays of numbers to the
reader of the OpenAPI document. They are converted by the C code of the standard
library; on any doubt pydantic's own list schema decides, and says where the
error is.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import GetCoreSchemaHandler, ValidationError, ValidatorFunctionWrapHandler
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from service.intake.errors import MAX_LISTED

__all__ = ["Grid", "Rows", "located"]

Floats = NDArray[np.float64]
_CHUNK = 4096  # rows that pydantic looks at before we ask whether there are errors enough
_LARGEST = 2**53  # integers up to here are floats too


@dataclass(frozen=True, slots=True)
class Rows:
    """For ``Annotated``: rows of numbers, all of one length, or an array of that shape.

    The result is a C-contiguous float64 array (int64 when ``whole``) of shape (N, width).

    Attributes
    ----------
    least_width, most_width : int
        How many numbers a row may have.
    least : int
        How many rows there must be.
    whole : bool
        Whether the numbers are indices: integers, at least 0.
    """

    least_width: int
    most_width: int
    least: int = 1
    whole: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Give the validator, and to the OpenAPI document the schema of a list of lists."""
        number: CoreSchema = core_schema.float_schema(strict=True, allow_inf_nan=False)
        if self.whole:
            number = core_schema.int_schema(strict=True, ge=0, le=_LARGEST)
        row = core_schema.list_schema(
            number, min_length=self.least_width, max_length=self.most_width, strict=True
        )
        rows = core_schema.list_schema(row, min_length=self.least, strict=True)
        return core_schema.no_info_wrap_validator_function(self._to_array, rows)

    def _to_array(self, value: object, handler: ValidatorFunctionWrapHandler) -> NDArray[Any]:
        if isinstance(value, np.ndarray):
            return self._checked(value)
        rows = self._from_rows(value) if isinstance(value, list) else None
        return self._checked(self._by_schema(value, handler) if rows is None else rows)

    def _from_rows(self, rows: list[Any]) -> NDArray[Any] | None:
        """Convert equally long rows of numbers; None when there is any doubt."""
        try:
            widths = set(map(len, rows))
            # refuses strings, nulls, lists and huge integers; as integers, all that has a point
            flat = array("q" if self.whole else "d", chain.from_iterable(rows))
        except (TypeError, OverflowError):
            return None
        if len(widths) != 1 or not self.least_width <= min(widths) <= self.most_width:
            return None
        found: NDArray[Any] = np.frombuffer(flat, flat.typecode).reshape(len(rows), widths.pop())
        if self.whole and (found.min() < 0 or found.max() > _LARGEST):
            return None
        return None if _has_boolean(found, rows) else found

    def _by_schema(self, rows: object, handler: ValidatorFunctionWrapHandler) -> NDArray[Any]:
        """Let pydantic's list schema say what is wrong, in chunks, until enough is known."""
        if not isinstance(rows, list) or not rows:
            handler(rows)  # raises, unless there may be none: not a list, or an empty one
            return np.zeros((0, self.least_width))
        errors = _errors(rows, handler, _CHUNK) or list(_mixed_lengths(rows))
        if errors:
            raise located(errors)
        return np.array(rows, dtype=np.int64 if self.whole else np.float64)

    def _checked(self, points: NDArray[Any]) -> NDArray[Any]:
        """Check type, shape and finiteness of an array, and give it the layout that the core wants."""
        if points.dtype.kind not in "fiu":
            message = "the array must hold integers or floats, not {dtype}"
            raise PydanticCustomError("array_type", message, {"dtype": points.dtype.name})
        if points.ndim != 2 or not self.least_width <= points.shape[1] <= self.most_width:
            message = "the array must have the shape (N, 2) or (N, 3), not {shape}"
            raise PydanticCustomError("array_shape", message, {"shape": str(points.shape)})
        if len(points) < self.least:
            raise PydanticCustomError("too_short", "there must be at least 1 point, not 0")
        if self.whole:
            return np.ascontiguousarray(points, dtype=np.int64)
        with np.errstate(over="ignore"):  # an extended float beyond the doubles becomes infinite: said below
            points = np.ascontiguousarray(points, dtype=np.float64)
        finite = np.isfinite(points)
        if not finite.all():
            places = np.argwhere(~finite)[:MAX_LISTED].tolist()
            message = "Input should be a finite number"
            raise located(_error("finite_number", message, tuple(at)) for at in places)
        return points


@dataclass(frozen=True, slots=True)
class Grid:
    """For ``Annotated``: rows of points [x, y, z], all of one length, with null or nulls for holes.

    The result is a float64 array of shape (I, J, 3), NaN in holes.
    """

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Give the validator, and to the OpenAPI document the schema of a list of lists of lists."""
        number = core_schema.nullable_schema(core_schema.float_schema(strict=True, allow_inf_nan=False))
        pixel = core_schema.list_schema(number, min_length=3, max_length=3, strict=True)
        row = core_schema.list_schema(core_schema.nullable_schema(pixel), min_length=1, strict=True)
        grid = core_schema.list_schema(row, min_length=1, strict=True)
        return core_schema.no_info_wrap_validator_function(self._to_array, grid)

    def _to_array(self, value: object, handler: ValidatorFunctionWrapHandler) -> Floats:
        found = self._from_rows(value) if isinstance(value, list) else None
        return self._by_schema(value, handler) if found is None else found

    def _from_rows(self, rows: list[Any]) -> Floats | None:
        """Convert equally long rows of points; None when there is any doubt."""
        try:
            widths = set(map(len, rows))
            if len(widths) != 1 or not all(type(row) is list for row in rows):
                return None
            pixels = [
                _HOLE if pixel is None or pixel == _NULLS else pixel for pixel in chain.from_iterable(rows)
            ]
            if set(map(len, pixels)) != {3}:
                return None
            flat = array("d", chain.from_iterable(pixels))
        except (TypeError, OverflowError):
            return None
        found = np.frombuffer(flat)
        if _has_boolean(found.reshape(-1, 3), pixels):
            return None
        return found.reshape(len(rows), widths.pop(), 3)

    def _by_schema(self, rows: object, handler: ValidatorFunctionWrapHandler) -> Floats:
        """Let pydantic's list schema say what is wrong, a few rows at a time."""
        if not isinstance(rows, list) or not rows:
            handler(rows)  # raises: not a list, or an empty one
            return np.zeros((0, 0, 3))
        widest = max((len(row) for row in rows if isinstance(row, list)), default=1)
        chunk = max(1, _CHUNK // max(widest, 1))
        errors = _errors(rows, handler, chunk) or list(_mixed_lengths(rows)) or list(_half_holes(rows))
        if errors:
            raise located(errors)
        pixels = [[_NULLS if pixel is None else pixel for pixel in row] for row in rows]
        return np.array(pixels, np.float64)


_NULLS = [None, None, None]
_HOLE = [np.nan, np.nan, np.nan]


def _has_boolean(found: NDArray[Any], rows: list[Any]) -> bool:
    """Tell whether a row has True or False, which arrays take for 1 and 0: only such rows are looked at."""
    doubtful = np.flatnonzero(((found == 0) | (found == 1)).any(axis=1))
    return bool in set(map(type, chain.from_iterable(map(rows.__getitem__, doubtful.tolist()))))


def _errors(rows: list[Any], handler: ValidatorFunctionWrapHandler, chunk: int) -> list[InitErrorDetails]:
    """Errors that the schema finds in the rows, in chunks, until there are enough."""
    errors: list[InitErrorDetails] = []
    for start in range(0, len(rows), chunk):
        try:
            handler(rows[start : start + chunk])
        except ValidationError as error:
            errors += _moved(error, start)
            if len(errors) >= MAX_LISTED:
                break
    return errors


def _moved(error: ValidationError, start: int) -> Iterator[InitErrorDetails]:
    """Errors of a chunk, with the row numbers that they have in the whole list."""
    for item in error.errors(include_url=False):
        row, *rest = item["loc"]
        moved = InitErrorDetails(type=item["type"], loc=(int(row) + start, *rest), input=None)
        if "ctx" in item:
            moved["ctx"] = item["ctx"]
        yield moved


def _mixed_lengths(rows: list[list[Any]]) -> Iterator[InitErrorDetails]:
    width = len(rows[0])
    for number, row in enumerate(rows):
        if len(row) != width:
            context = {"row": number, "length": len(row), "first": width}
            message = "row {row} has {length} numbers, row 0 has {first}"
            yield _error("mixed_lengths", message, (number,), context)


def _half_holes(rows: list[list[Any]]) -> Iterator[InitErrorDetails]:
    """Pixels with a null that are not null altogether."""
    for i, row in enumerate(rows):
        for j, pixel in enumerate(row):
            if pixel is not None and None in pixel and pixel != _NULLS:
                yield _error("half_hole", "a hole is null, or has three nulls", (i, j))


def _error(
    code: Any, message: Any, loc: tuple[int | str, ...], context: dict[str, Any] | None = None
) -> InitErrorDetails:
    return InitErrorDetails(type=PydanticCustomError(code, message, context), loc=loc, input=None)


def located(errors: Iterable[InitErrorDetails]) -> ValidationError:
    """Make pydantic's error of several ones with their places, relative to the value that is validated."""
    return ValidationError.from_exception_data("points", list(errors), hide_input=True)
