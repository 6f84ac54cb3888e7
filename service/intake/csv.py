"""Tables of numbers: ``text/csv`` (RFC 4180), and the space-separated ``.xyz`` and ``.txt``.

Columns are x, y[, z] in this order, or in the order that a header names them.
Comma, semicolon, tab or spaces separate; ``#`` begins a comment; blank lines
do not count. With semicolons a comma may be the decimal sign. numpy's parser
reads regular files; any other is read line by line, so that errors name the
line and the column.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.intake.errors import MAX_LISTED, ErrorItem, refuse

__all__ = ["decode_csv"]

_CHARSETS = {"utf-8", "ascii", "iso8859-1", "cp1252", "utf-16", "utf-16-le", "utf-16-be"}
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE)
_AXES = ("x", "y", "z")
_NO_POINT = "there must be at least 1 point, not 0"


@dataclass(frozen=True, slots=True)
class _Layout:
    """How a table is written: separator (None: white space), columns of x, y[, z], first line of data."""

    separator: str | None
    columns: tuple[int, ...]
    start: int
    named: bool


def decode_csv(body: bytes, charset: str | None = None) -> NDArray[np.float64]:
    """Read a table of points.

    Parameters
    ----------
    body : bytes
    charset : str, optional
        Of the ``Content-Type``; UTF-8 when none is given. A byte order mark is skipped.

    Returns
    -------
    (N, 2) or (N, 3) array

    Raises
    ------
    IntakeError
        400 for text in another charset, 415 for a charset that is not supported,
        422 with point, column and line for anything but finite numbers.
    """
    text = _text(body, charset)
    first = next(filter(_content, text.splitlines()), "")
    if ";" in _content(first):
        text = text.replace(",", ".")  # a decimal comma, as spreadsheets in half of Europe write it
    lines = text.splitlines()
    layout = _layout(lines)
    points = _read_fast(lines[layout.start :], layout)
    return _read_lines(lines, layout) if points is None else points


def _content(line: str) -> str:
    """Return what a line says, without its comment."""
    return line.partition("#")[0].strip()


def _fields(content: str, separator: str | None) -> list[str]:
    return [field.strip().strip('"') for field in content.split(separator)]


def _text(body: bytes, charset: str | None) -> str:
    try:
        name = codecs.lookup(charset or "utf-8").name
    except LookupError:
        name = ""
    if name not in _CHARSETS:
        raise refuse("unsupported-media-type", "this charset is not supported; send the text in UTF-8")
    try:
        return body.decode(name).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        detail = f"the body is not text in {name} (offset {error.start})"
        raise refuse("unreadable-body", detail, ("body", error.start), "charset_invalid") from None


def _layout(lines: Sequence[str]) -> _Layout:
    """Read the layout off the first line that says something."""
    number, content = next(((n, text) for n, line in enumerate(lines) if (text := _content(line))), (0, ""))
    if not content:
        raise refuse("invalid-points", _NO_POINT, ("body", "points"), "too_short")
    separator = next((mark for mark in ";," if mark in content), None)
    fields = _fields(content, separator)
    if all(_NUMBER.fullmatch(field) or _NOT_FINITE.fullmatch(field) for field in fields):
        return _Layout(separator, tuple(range(len(fields))), number, named=False)
    names = [field.lower() for field in fields]
    if names.count("x") != 1 or names.count("y") != 1 or names.count("z") > 1:
        detail = (
            f"line {number + 1} is neither a row of numbers nor a header that names the columns x and y once"
        )
        raise refuse("invalid-points", detail, ("body", "points", 0), "header_invalid")
    return _Layout(
        separator, tuple(names.index(axis) for axis in _AXES if axis in names), number + 1, named=True
    )


def _read_fast(lines: Sequence[str], layout: _Layout) -> NDArray[np.float64] | None:
    """Read a regular table with numpy's parser; None when it is not regular, or not all finite."""
    if not 2 <= len(layout.columns) <= 3 or not any(map(_content, lines)):  # numpy warns of empty tables
        return None
    try:
        points = np.loadtxt(
            lines,
            comments="#",
            delimiter=layout.separator,
            usecols=layout.columns if layout.named else None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError:
        return None
    return points if np.isfinite(points).all() else None


def _has_data(lines: Sequence[str]) -> bool:
    """Tell whether a line below the header says something: numpy warns where none does."""
    return any(line.partition("#")[0].strip() for line in lines)


def _read_lines(lines: Sequence[str], layout: _Layout) -> NDArray[np.float64]:
    """Read line by line; collect errors with their places."""
    rows: list[list[float]] = []
    errors: list[ErrorItem] = []
    for number in range(layout.start, len(lines)):
        content = _content(lines[number])
        if content and len(errors) < MAX_LISTED:
            row: list[float] = []
            errors += _read_line(_fields(content, layout.separator), layout, number + 1, len(rows), row)
            rows.append(row)
    if errors:
        raise refuse("invalid-points", errors[0]["msg"], errors=errors)
    if not rows:
        raise refuse("invalid-points", _NO_POINT, ("body", "points"), "too_short")
    return np.array(rows)


def _read_line(
    fields: Sequence[str], layout: _Layout, line: int, index: int, row: list[float]
) -> Iterator[ErrorItem]:
    """Append the coordinates of point ``index`` to ``row``; yield what is wrong with them."""
    width = len(layout.columns)
    if not layout.named and not 2 <= width <= 3:
        message = (
            f"line {line} has {width} values; a point has 2 or 3 (name the columns in a header to pick some)"
        )
        yield _item(message, index, "row_length")
        return
    if len(fields) <= max(layout.columns) or (not layout.named and len(fields) != width):
        yield _item(
            f"line {line} has {len(fields)} values, the first one promises {width}", index, "row_length"
        )
        return
    for axis, column in enumerate(layout.columns):
        if _NUMBER.fullmatch(fields[column]) and np.isfinite(value := float(fields[column])):
            row.append(value)
        else:
            message = f"line {line}, column {column + 1}: not a finite number"
            yield _item(message, index, "float_parsing", axis)


def _item(message: str, index: int, code: str, *axis: int) -> ErrorItem:
    return {"loc": ["body", "points", index, *axis], "msg": message, "type": code}
