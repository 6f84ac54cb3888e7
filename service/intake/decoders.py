"""From bytes to a submission: one row a media type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from pydantic import BaseModel

from service.intake import media
from service.intake.compression import decompress
from service.intake.csv import decode_csv
from service.intake.envelope import open_envelope
from service.intake.errors import refuse
from service.intake.json import load_json, paused_collector
from service.intake.multipart import Part, split_form
from service.intake.npy import decode_npy
from service.intake.query import Query
from service.intake.submission import Limits, Submission, check_document

__all__ = ["MEDIA_TYPES", "decode", "enveloped"]

Options = dict[str, str]


def decode(
    body: bytes,
    content_type: str | None,
    content_encoding: str | None,
    query: Query,
    parameters_model: type[BaseModel],
    include_allowed: frozenset[str],
    limits: Limits,
    envelope: str | None = None,
) -> Submission:
    """Read a point cloud with its parameters from the body of a request.

    Parameters
    ----------
    body : bytes
        As it came, still compressed.
    content_type, content_encoding : str or None
        The headers' values.
    query : mapping or pairs of str
        Parameters by name, and ``include``; ``format`` is passed over.
    parameters_model : type of BaseModel
        What parameters there are.
    include_allowed : frozenset of str
        What may be asked for in ``include``.
    limits : Limits
    envelope : str, optional
        Member of a JSON body that holds what else is the body itself, such as ``inputs``;
        for bodies that are `enveloped`.

    Returns
    -------
    Submission

    Raises
    ------
    IntakeError
        400 unreadable, 413 too much, 415 media type or content encoding, 422 wrong values.
    """
    media_type, options = media.parse_media_type(content_type or "")
    if media_type not in _DECODERS:
        raise refuse("unsupported-media-type", f"send the points as one of {', '.join(MEDIA_TYPES)}")
    plain = decompress(body, content_encoding, limits.max_bytes)
    with paused_collector():
        document = _DECODERS[media_type](plain, options, limits)
        if envelope is None:
            return check_document(document, query, parameters_model, include_allowed, limits)
        document, reply = open_envelope(document, envelope, partial(_embedded, limits))
        loc = ("body", envelope)
        checked = check_document(document, query, parameters_model, include_allowed, limits, loc)
        return replace(checked, reply=reply)


def enveloped(content_type: str | None) -> bool:
    """Say whether bodies of this media type can be envelopes: only JSON has room for one."""
    return media.parse_media_type(content_type or "")[0] == media.JSON


def _embedded(limits: Limits, content: bytes, content_type: str, loc: tuple[str | int, ...]) -> object:
    """Decode an input that lies as text or as bytes in a JSON body."""
    media_type, options = media.parse_media_type(content_type)
    if media_type == media.JSON:
        return load_json(content, loc)
    if media_type not in _DECODERS or media_type == media.MULTIPART:
        detail = f"{media_type[:40] or 'this'} is no media type of points that is understood"
        raise refuse("unsupported-media-type", detail, loc)
    document = _DECODERS[media_type](content, options, limits)
    return document.get("points") if isinstance(document, dict) else document


def _json(body: bytes, _options: Options, _limits: Limits) -> object:
    return load_json(body)


def _npy(body: bytes, _options: Options, _limits: Limits) -> object:
    return {"points": decode_npy(body)}


def _csv(body: bytes, options: Options, _limits: Limits) -> object:
    return {"points": decode_csv(body, options.get("charset"))}


def _form(body: bytes, options: Options, limits: Limits) -> object:
    """Read the fields ``file`` and ``parameters``; a JSON file may bring parameters of its own."""
    fields: dict[str, Part] = {}
    for part in split_form(body, options.get("boundary")):
        if part.name not in {"file", "parameters"}:
            raise refuse(
                "invalid-input",
                "a form has the fields file and parameters only",
                ("body", part.name),
                "extra_forbidden",
            )
        if part.name in fields:
            raise refuse(
                "invalid-input", "each field of the form may come once", ("body", part.name), "repeated"
            )
        fields[part.name] = part
    if "file" not in fields:
        raise refuse("invalid-input", "the form has no field file", ("body", "file"), "missing")
    document = _file(fields["file"], limits)
    if "parameters" in fields and isinstance(document, dict):
        if "parameters" in document:
            detail = "parameters are given both in the file and in the form"
            raise refuse("invalid-parameter", detail, ("body", "parameters"), "repeated")
        document["parameters"] = load_json(fields["parameters"].content, ("body", "parameters"))
    return document


def _file(part: Part, limits: Limits) -> object:
    """Decode the file of a form by its own media type, or by the ending of its name."""
    named, encoding = media.media_type_of_name(part.filename)
    declared, options = media.parse_media_type(part.content_type)
    media_type = declared if declared in _DECODERS and encoding is None else named
    if media_type is None or media_type == media.MULTIPART:
        detail = "the file has neither a known media type nor a known ending (.csv, .txt, .xyz, .npy, .json)"
        raise refuse("unsupported-media-type", detail, ("body", "file"))
    return _DECODERS[media_type](decompress(part.content, encoding, limits.max_bytes), options, limits)


_DECODERS: dict[str, Callable[[bytes, Options, Limits], Any]] = {
    media.JSON: _json,
    media.NPY: _npy,
    media.CSV: _csv,
    media.PLAIN: _csv,
    media.MULTIPART: _form,
}

MEDIA_TYPES = tuple(_DECODERS)
"""The media types that `decode` reads, the preferred one first."""
