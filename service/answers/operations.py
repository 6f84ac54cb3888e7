"""The answers of what is not computed: health, links and problems."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from service.answers.base import Answer, Link

__all__ = ["ErrorItem", "Health", "Landing", "ProblemDocument", "Readiness"]


class Health(Answer):
    """The process answers."""

    status: Literal["ok"] = "ok"


class Readiness(Answer):
    """The workers are warm."""

    status: Literal["ready"] = "ready"
    workers: int = Field(description="Warm workers now.")


class Landing(Answer):
    """Where everything is."""

    title: str
    description: str
    version: str
    links: list[Link]


class ErrorItem(Answer):
    """One thing that is wrong, and where."""

    loc: list[str | int] = Field(description='Path to it, such as ["body", "points", 17, 1].')
    msg: str
    type: str = Field(description="Stable name, for programs.")


class ProblemDocument(Answer):
    """A problem document (RFC 9457)."""

    type: str = Field(description="Stable name of the kind of problem, for programs.")
    title: str
    status: int
    detail: str = Field(description="What is wrong here, and what to do about it.")
    instance: str = Field(description="This one occurrence; the same as in the log.")
    errors: list[ErrorItem] = Field(default_factory=list)
