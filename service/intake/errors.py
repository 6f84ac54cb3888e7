"""The one error of intake: what a client sent cannot be read or used."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypedDict

__all__ = ["MAX_LISTED", "ErrorItem", "IntakeError", "refuse"]

MAX_LISTED = 20
"""How many single errors an answer lists at most: a million wrong rows need no million lines."""

_MAX_NAME = 80

# One row a kind of refusal: HTTP status, and the title of the problem.
_KINDS: dict[str, tuple[int, str]] = {
    "unreadable-body": (400, "The body cannot be read"),
    "not-acceptable": (406, "No offered form is acceptable"),
    "too-many-bytes": (413, "The body is too large"),
    "too-many-points": (413, "There are too many points"),
    "unsupported-media-type": (415, "The media type of the body is not supported"),
    "unsupported-content-encoding": (415, "The content encoding of the body is not supported"),
    "invalid-input": (422, "The input is not valid"),
    "invalid-points": (422, "The points are not valid"),
    "invalid-parameter": (422, "A parameter is not valid"),
}


class ErrorItem(TypedDict):
    """One error: the path to the offending value, a message for people, a type for programs."""

    loc: list[str | int]
    msg: str
    type: str


class IntakeError(Exception):
    """What a client sent cannot be read or used.

    Parameters
    ----------
    status : int
        HTTP status: 400 unreadable, 406, 413 too much, 415, 422 wrong values.
    kind : str
        A stable identifier in kebab-case for programs.
    title : str
        What a ``kind`` means, in words; the same for all errors of one kind.
    detail : str
        What is wrong this time, and what to do about it.
    errors : sequence of ErrorItem
        The single errors with their places, at most `MAX_LISTED`.
    """

    def __init__(
        self, status: int, kind: str, title: str, detail: str, errors: Sequence[ErrorItem] = ()
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.kind = kind
        self.title = title
        self.detail = detail
        self.errors = list(errors)

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle with all arguments: bodies are decoded in other processes."""
        return type(self), (self.status, self.kind, self.title, self.detail, self.errors)


def refuse(
    kind: str,
    detail: str,
    loc: Iterable[str | int] | None = None,
    code: str | None = None,
    errors: Sequence[ErrorItem] = (),
) -> IntakeError:
    """Make the error of a ``kind``, with one place ``loc`` of type ``code``, or with a list of ``errors``."""
    status, title = _KINDS[kind]
    if loc is not None:
        errors = [{"loc": list(loc), "msg": detail, "type": code or kind.replace("-", "_")}]
    listed: list[ErrorItem] = [{**item, "loc": _shortened(item["loc"])} for item in errors[:MAX_LISTED]]
    return IntakeError(status, kind, title, detail, listed)


def _shortened(loc: Iterable[str | int]) -> list[str | int]:
    """Cut names that the client made up: an answer does not echo its input at length."""
    return [part[:_MAX_NAME] if isinstance(part, str) else part for part in loc]
