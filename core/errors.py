"""The errors of the core, on one screen.

::

    TapelineError
    └── InvalidInput            what was given cannot be used; says where and what to do
        ├── InvalidPoints       shape, type or value of the point set
        ├── InvalidParameter    a parameter that contradicts the data or another parameter
        └── DegenerateInput     sound numbers that determine no curve

Every error carries ``loc``, the path to the offending value in the style of
pydantic: ``("points", 17, 1)`` is the second coordinate of point 17.
"""

from __future__ import annotations

__all__ = ["DegenerateInput", "InvalidInput", "InvalidParameter", "InvalidPoints", "TapelineError"]


class TapelineError(Exception):
    """Root of all errors that the core raises on purpose."""


class InvalidInput(TapelineError):
    """What was given cannot be used.

    Parameters
    ----------
    message : str
        What is wrong, and what to do about it; one sentence for a person.
    loc : tuple of str or int
        Path to the offending value.
    kind : str
        A stable identifier in kebab-case for programs.
    """

    kind = "invalid-input"

    def __init__(self, message: str, loc: tuple[str | int, ...] = (), kind: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.loc = loc
        self.kind = kind or type(self).kind

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle with all arguments: errors cross process borders."""
        return type(self), (self.message, self.loc, self.kind)


class InvalidPoints(InvalidInput):
    """The point set has a wrong shape or type, or a value that is not finite."""

    kind = "invalid-points"


class InvalidParameter(InvalidInput):
    """A parameter contradicts the data or another parameter."""

    kind = "invalid-parameter"


class DegenerateInput(InvalidInput):
    """The numbers are sound, but they determine no curve (too few or coincident points)."""

    kind = "degenerate-input"
