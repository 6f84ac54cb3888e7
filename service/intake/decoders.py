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
from service.intake.scan_files import ScanFile, decode_scan, decode_scans
from service.intake.schema import Takes
from service.intake.submission import Limits, Submission, check_document

__all__ = ["MEDIA_TYPES", "decode", "enveloped"]

Options = dict[str, str]
Decoders = dict[str, Callable[[bytes, Options, Limits], Any]]


def decode(
    body: bytes,
    content_type: str | None,
    content_encoding: str | None,
    query: Query,
    parameters_model: type[BaseModel],
    include_allowed: frozenset[str],
    limits: Limits,
    envelope: str | None = None,
    takes: Takes = "points",
) -> Submission:
    """Read a point cloud or scans, with parameters, from the body of a request.

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
    takes : {"points", "scans"}
        What the process works on.

    Returns
    -------
    Submission

    Raises
    ------
    IntakeError
        400 unreadable, 413 too much, 415 media type or content encoding, 422 wrong values.
    """
    media_type, options = media.parse_media_type(content_type or "")
    decoders = _DECODERS[takes]
    if media_type not in decoders:
        raise refuse("unsupported-media-type", f"send the {takes} as one of {', '.join(decoders)}")
    plain = decompress(body, content_encoding, limits.max_bytes)
    check = partial(check_document, query=query, parameters_model=parameters_model, takes=takes)
    with paused_collector():
        document = decoders[media_type](plain, options, limits)
        if envelope is None:
            return check(document, include_allowed=include_allowed, limits=limits)
        document, reply = open_envelope(document, envelope, partial(_embedded, takes, limits))
        loc = ("body", envelope)
        checked = check(document, include_allowed=include_allowed, limits=limits, loc=loc)
        return replace(checked, reply=reply)


def enveloped(content_type: str | None) -> bool:
    """Say whether bodies of this media type can be envelopes: only JSON has room for one."""
    return media.parse_media_type(content_type or "")[0] == media.JSON


def _embedded(
    takes: Takes, limits: Limits, content: bytes, content_type: str, loc: tuple[str | int, ...]
) -> object:
    """Decode an input that lies as text or as bytes in a JSON body; the last of ``loc`` is its name."""
    media_type, options = media.parse_media_type(content_type)
    if media_type == media.JSON:
        return load_json(content, loc)
    decoders = _DECODERS[takes]
    if media_type not in decoders or media_type == media.MULTIPART:
        detail = f"{media_type[:40] or 'this'} is no media type of {takes} that is understood"
        raise refuse("unsupported-media-type", detail, loc)
    document = decoders[media_type](content, options, limits)
    if takes == "points":
        return document.get("points")
    return next((document[name] for name in document if name in loc), list(document.values()))


def _json(body: bytes, _options: Options, _limits: Limits) -> object:
    return load_json(body)


def _npy(body: bytes, _options: Options, _limits: Limits) -> object:
    return {"points": decode_npy(body)}


def _csv(body: bytes, options: Options, _limits: Limits) -> object:
    return {"points": decode_csv(body, options.get("charset"))}


def _scan(media_type: str, body: bytes, _options: Options, limits: Limits) -> object:
    return decode_scan(body, media_type, limits)


def _form(body: bytes, options: Options, limits: Limits) -> object:
    """Read the fields ``file`` and ``parameters``; a JSON file may bring parameters of its own."""
    (part,), parameters = _fields(body, options, several=False)
    return _with_parameters(_file(part, limits), parameters)


def _scan_form(body: bytes, options: Options, limits: Limits) -> object:
    """Read the fields ``file``, one for each scan, and ``parameters``."""
    parts, parameters = _fields(body, options, several=True)
    files = [
        ScanFile(part.filename, part.content, media.parse_media_type(part.content_type)[0]) for part in parts
    ]
    return _with_parameters(decode_scans(files, limits), parameters)


def _fields(body: bytes, options: Options, several: bool) -> tuple[list[Part], Part | None]:
    """Split a form into its files, at least one, and its parameters."""
    fields: dict[str, list[Part]] = {"file": [], "parameters": []}
    for part in split_form(body, options.get("boundary")):
        if part.name not in fields:
            raise refuse(
                "invalid-input",
                "a form has the fields file and parameters only",
                ("body", part.name),
                "extra_forbidden",
            )
        if fields[part.name] and not (several and part.name == "file"):
            raise refuse(
                "invalid-input", "this field of the form may come once", ("body", part.name), "repeated"
            )
        fields[part.name].append(part)
    if not fields["file"]:
        raise refuse("invalid-input", "the form has no field file", ("body", "file"), "missing")
    return fields["file"], fields["parameters"][0] if fields["parameters"] else None


def _with_parameters(document: object, parameters: Part | None) -> object:
    if parameters is not None and isinstance(document, dict):
        if "parameters" in document:
            detail = "parameters are given both in the file and in the form"
            raise refuse("invalid-parameter", detail, ("body", "parameters"), "repeated")
        document["parameters"] = load_json(parameters.content, ("body", "parameters"))
    return document


def _file(part: Part, limits: Limits) -> object:
    """Decode the file of a form by its own media type, or by the ending of its name."""
    named, encoding = media.media_type_of_name(part.filename)
    declared, options = media.parse_media_type(part.content_type)
    media_type = declared if declared in _OF_POINTS and encoding is None else named
    if media_type not in _OF_POINTS or media_type == media.MULTIPART:
        detail = "the file has neither a known media type nor a known ending (.csv, .txt, .xyz, .npy, .json)"
        raise refuse("unsupported-media-type", detail, ("body", "file"))
    return _OF_POINTS[media_type](decompress(part.content, encoding, limits.max_bytes), options, limits)


_OF_POINTS: Decoders = {
    media.JSON: _json,
    media.NPY: _npy,
    media.CSV: _csv,
    media.PLAIN: _csv,
    media.MULTIPART: _form,
}
_OF_SCANS: Decoders = {
    media.JSON: _json,
    media.MULTIPART: _scan_form,
    **{kind: partial(_scan, kind) for kind in (media.PLY, media.STL, media.OBJ)},
}
_DECODERS: dict[Takes, Decoders] = {"points": _OF_POINTS, "scans": _OF_SCANS}

MEDIA_TYPES: dict[Takes, tuple[str, ...]] = {takes: tuple(rows) for takes, rows in _DECODERS.items()}
"""The media types that `decode` reads, the preferred one first, by what a process takes."""
