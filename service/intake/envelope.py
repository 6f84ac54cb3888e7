"""Execute requests of OGC API – Processes 1.0 (18-062r2 §7.11): inputs in an envelope, and what to answer.

An input is a value, a value with its media type, or a link. Links are read
when they hold their content themselves (``data:``, RFC 2397); the service
fetches nothing from anywhere.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal
from urllib.parse import unquote_to_bytes

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from service.intake.errors import MAX_LISTED, ErrorItem, refuse
from service.intake.schema import Takes, submission_model

__all__ = ["Reply", "execute_model", "open_envelope"]

Place = tuple[str | int, ...]
Read = Callable[[bytes, str, Place], object]

_PLAIN = "application/json"
_LINK = {"href", "rel", "type", "hreflang", "title"}
_QUALIFIED = {"value", "mediaType", "encoding"}


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class OutputFormat(_Part):
    """The form of an output."""

    mediaType: str | None = Field(None, description="One of the media types in the description.")  # noqa: N815 # the standard's names


class OutputRequest(_Part):
    """How an output is wanted."""

    format: OutputFormat = Field(default_factory=OutputFormat)
    transmissionMode: Literal["value"] = "value"  # noqa: N815


class OutputsRequest(_Part):
    """The outputs that are wanted."""

    result: OutputRequest = Field(default_factory=OutputRequest)


class ExecuteRequest(_Part):
    """What an execute request says besides its inputs."""

    outputs: OutputsRequest = Field(default_factory=OutputsRequest)
    response: Literal["raw", "document"] = Field(
        "raw", description="The answer itself, or a JSON document that holds it as `result`."
    )


@dataclass(frozen=True, slots=True)
class Reply:
    """What an execute request says of the answer.

    Attributes
    ----------
    media_type : str or None
        That of the output, where the request names one.
    document : bool
        Whether the answer shall be a JSON document that holds the output.
    """

    media_type: str | None = None
    document: bool = False


@lru_cache(maxsize=64)
def execute_model(
    parameters_model: type[BaseModel], include_allowed: frozenset[str], takes: Takes = "points"
) -> type[BaseModel]:
    """Make the model of an execute request, for the OpenAPI document."""
    inputs = submission_model(parameters_model, include_allowed, takes)
    return create_model(
        parameters_model.__name__.removesuffix("Parameters") + "Execute",
        __base__=ExecuteRequest,
        __doc__="An execute request of OGC API – Processes.",
        inputs=(inputs, ...),
    )


def open_envelope(document: object, member: str, read: Read) -> tuple[object, Reply]:
    """Take the inputs out of an execute request.

    Parameters
    ----------
    document : object
        A parsed JSON value.
    member : str
        The name of what holds the inputs.
    read : callable
        ``read(content, media_type, loc)``: decodes an input that is not given as JSON.

    Returns
    -------
    inputs : object
        With plain values, still to be checked.
    reply : Reply

    Raises
    ------
    IntakeError
        422 for what is no execute request, and for links to other places.
    """
    if not isinstance(document, dict) or member not in document:
        detail = f"the body has no member {member}; it shall hold what else is the body itself"
        raise refuse("invalid-input", detail, ("body", member), "missing")
    if "subscriber" in document:
        detail = "nobody is called back; follow the job at /jobs/{jobID}/events"
        raise refuse("invalid-input", detail, ("body", "subscriber"), "unsupported")
    inputs = document[member]
    asked = _checked({name: value for name, value in document.items() if name != member})
    if isinstance(inputs, dict):
        inputs = {name: _plain(value, ("body", member, name), read) for name, value in inputs.items()}
    return inputs, Reply(asked.outputs.result.format.mediaType, asked.response == "document")


def _checked(document: dict[str, Any]) -> ExecuteRequest:
    try:
        return ExecuteRequest.model_validate(document)
    except ValidationError as error:
        if error.error_count() > MAX_LISTED:  # none of them is listed: making a list of a million takes long
            detail = "the body has many members that are unknown; known are inputs, outputs and response"
            raise refuse("invalid-input", detail, ("body",), "extra_forbidden") from None
        found = error.errors(include_url=False, include_input=False, include_context=False)
        items = [ErrorItem(loc=["body", *item["loc"]], msg=item["msg"], type=item["type"]) for item in found]
        where = ".".join(str(part)[:40] for part in items[0]["loc"][1:])
        raise refuse("invalid-input", f"{where}: {items[0]['msg']}", errors=items) from None


def _plain(value: object, loc: Place, read: Read) -> object:
    """Return an input as it would be without qualification or link."""
    if not isinstance(value, dict):
        return value
    if "href" in value and value.keys() <= _LINK:
        media_type, content = _linked(value["href"], loc)
        return read(content, media_type, loc)
    if "value" in value and value.keys() <= _QUALIFIED:
        return _qualified(value, loc, read)
    return value


def _qualified(value: dict[str, Any], loc: Place, read: Read) -> object:
    media_type, content, encoding = value.get("mediaType", _PLAIN), value["value"], value.get("encoding")
    if not isinstance(media_type, str):
        raise refuse("invalid-input", "a media type is a string", (*loc, "mediaType"), "string_type")
    if encoding is not None and encoding != "base64":
        raise refuse("invalid-input", "the encoding is base64, or left out", (*loc, "encoding"), "enum")
    if encoding is None and media_type == _PLAIN:
        return content
    if not isinstance(content, str):
        raise refuse("invalid-input", f"{media_type} comes as a string", (*loc, "value"), "string_type")
    encoded = _from_base64(content, (*loc, "value")) if encoding else content.encode("utf-8", "replace")
    return read(encoded, media_type, loc)


def _linked(href: object, loc: Place) -> tuple[str, bytes]:
    """Read a ``data:`` URL: its media type and its content."""
    head, comma, content = href.partition(",") if isinstance(href, str) else ("", "", "")
    scheme, _, media_type = head.partition(":")
    if scheme.lower() != "data" or not comma:
        detail = "the service fetches nothing; send the value itself, or a data: URL that holds it"
        raise refuse("invalid-input", detail, (*loc, "href"), "unsupported")
    plain = media_type.removesuffix(";base64")
    octets = unquote_to_bytes(content)
    if plain != media_type:
        octets = _from_base64(octets, (*loc, "href"))
    return plain or "text/plain", octets


def _from_base64(text: str | bytes, loc: Place) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise refuse("invalid-input", "this is not base64", loc, "base64") from None
