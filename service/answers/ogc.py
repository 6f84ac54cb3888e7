"""Processes and what they conform to, as OGC API – Processes 1.0 (18-062r2) describes them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from service.answers.base import Answer, Link

__all__ = [
    "Conformance",
    "InputDescription",
    "OutputDescription",
    "ProcessDescription",
    "ProcessList",
    "ProcessSummary",
    "ResultDocument",
]

Schema = Annotated[
    dict[str, Any],
    Field(alias="schema", description="Holds as JSON Schema 2020-12 and as a schema of OpenAPI 3.0 alike."),
]


class Conformance(Answer):
    """The conformance classes that are met (confClasses)."""

    conformsTo: list[str]  # noqa: N815 # the standard's names, here and below


class InputDescription(Answer):
    """What may be given to a process (inputDescription)."""

    title: str
    description: str
    minOccurs: int = Field(1, description="0: may be left out.")  # noqa: N815
    maxOccurs: int = 1  # noqa: N815
    schema_: Schema


class OutputDescription(Answer):
    """What a process answers (outputDescription)."""

    title: str
    description: str
    schema_: Schema


class ProcessSummary(Answer):
    """A process in a list (processSummary)."""

    id: str
    title: str
    description: str
    version: str
    jobControlOptions: list[Literal["sync-execute", "async-execute", "dismiss"]]  # noqa: N815
    outputTransmission: list[Literal["value"]]  # noqa: N815
    links: list[Link]


class ProcessDescription(ProcessSummary):
    """A process with all that can be given to it and got from it (process)."""

    inputs: dict[str, InputDescription]
    outputs: dict[str, OutputDescription]


class ProcessList(Answer):
    """Processes (processList)."""

    processes: list[ProcessSummary]
    links: list[Link]


class Qualified(Answer):
    """A value with its media type (qualifiedInputValue)."""

    value: Any = Field(description="JSON as it is, text as a string, octets in base64.")
    mediaType: str  # noqa: N815
    encoding: Literal["base64"] | None = None


class ResultDocument(Answer):
    """The answer to an execute request with the response `document` (results)."""

    result: Qualified
