"""What the command line reads: files and options, and what it says of those that are wrong."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from service.processes import Process

if TYPE_CHECKING:
    from service.intake import ErrorItem, ScanFile, Submission

__all__ = ["UsageError", "given", "methods_with", "option_name", "read", "refusal", "source"]

_UNLIMITED = 2**60
_CONF = "text/x-bmesh"
_SCANS = (".ply", ".stl", ".obj", ".conf")
_GZIP = b"\x1f\x8b"
_JSON = (b"{", "application/json")
_MAGIC = {
    "points": ((b"\x93NUMPY", "application/x-npy"), _JSON, (b"", "text/csv")),
    "scans": ((b"ply", "application/x-ply"), _JSON, (b"", "model/stl")),
}


class UsageError(Exception):
    """What was asked for cannot be done; the message says why, in one line."""


def read(options: argparse.Namespace, process: Process) -> Submission:
    """Read the files and the parameters of a process.

    Raises
    ------
    UsageError
        For anything that is wrong with them.
    """
    _refuse_other_methods(options, process)
    query = [*given(options, process.parameters.model_fields).items()]
    query += [("include", name) for name in getattr(options, "include", None) or ()]
    return (_read_points if process.takes == "points" else _read_scans)(options, process, query)


def _read_points(options: argparse.Namespace, process: Process, query: list[tuple[str, str]]) -> Submission:
    from service.intake import IntakeError, Limits, decode, decompress, media_type_of_name  # noqa: PLC0415 # see above

    media_type, encoding = media_type_of_name(options.input)
    body = _bytes_of(options.input)
    try:
        plain = decompress(body, encoding or ("gzip" if body.startswith(_GZIP) else None), _UNLIMITED)
        media_type = media_type or next(name for magic, name in _MAGIC["points"] if plain.startswith(magic))
        limits = Limits(max_points=_UNLIMITED, max_bytes=_UNLIMITED)
        return decode(plain, media_type, None, query, process.parameters, process.include, limits)
    except IntakeError as error:
        raise refusal(error.errors, error.detail, options.input) from None


def _read_scans(options: argparse.Namespace, process: Process, query: list[tuple[str, str]]) -> Submission:
    from service.intake import IntakeError, Limits, check_document, decode_scans  # noqa: PLC0415 # see above

    limits = Limits(max_points=_UNLIMITED, max_bytes=_UNLIMITED)
    files = [_scan_file(name) for given in options.input for name in _within(given)]
    files += [_scan_file(name, _CONF) for name in options.conf]
    try:
        document = decode_scans(files, limits)
        return check_document(
            document, query, process.parameters, process.include, limits, takes=process.takes
        )
    except IntakeError as error:
        raise refusal(error.errors, error.detail, source(options)) from None


def _within(name: str) -> list[str]:
    """Return a file, or all scans in a folder and their poses."""
    folder = Path(name)
    if not folder.is_dir():
        return [name]
    found = sorted(str(path) for path in folder.iterdir() if path.name.removesuffix(".gz").endswith(_SCANS))
    if not found:
        raise UsageError(f"{name}: there is no scan in this folder (.ply, .stl or .obj)")
    return found


def _scan_file(name: str, kind: str | None = None) -> ScanFile:
    from service.intake import ScanFile, decompress  # noqa: PLC0415 # see above

    content = _bytes_of(name)
    if kind is not None:
        return ScanFile(f"{name}.conf" if not name.endswith((".conf", ".gz")) else name, content, kind)
    if name != "-":
        return ScanFile(name, content)
    content = decompress(content, "gzip" if content.startswith(_GZIP) else None, _UNLIMITED)
    kind = next(kind for magic, kind in _MAGIC["scans"] if content.startswith(magic))
    return ScanFile(name, content, kind)


def _refuse_other_methods(options: argparse.Namespace, process: Process) -> None:
    """Say which methods an option belongs to, when it is none of the one that is asked for."""
    every = {name for row in options.methods.values() for name in row.parameters.model_fields}
    for name in given(options, sorted(every - process.parameters.model_fields.keys() - {"method"})):
        owners = " or ".join(methods_with(name, options.methods))
        raise UsageError(f"{option_name(name)}: a parameter of another method; add --method {owners}")


def _bytes_of(name: str) -> bytes:
    try:
        return sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    except OSError as error:
        raise UsageError(f"{name}: {error.strerror}") from None


def given(options: argparse.Namespace, names: Iterable[str]) -> dict[str, str]:
    """Collect the options that were given, as text."""
    values = {name: getattr(options, name, None) for name in names}
    return {
        name: str(value).lower() if isinstance(value, bool) else value
        for name, value in values.items()
        if value is not None
    }


def methods_with(name: str, methods: dict[str, Process]) -> tuple[str, ...]:
    """Name the methods of a command that have a parameter."""
    return tuple(method for method, row in methods.items() if name in row.parameters.model_fields)


def source(options: argparse.Namespace) -> str:
    """Name the input: its first file, if there are several."""
    several: bool = isinstance(options.input, list)
    name: str = options.input[0] if several else options.input
    return f"{name} …" if several and len(options.input) > 1 else name


def refusal(errors: Sequence[ErrorItem], detail: str, name: str) -> UsageError:
    """Say in one line what is wrong and where: in which option, or in which row of which file."""
    if not errors:
        return UsageError(f"{name}: {detail}")
    loc, message = errors[0]["loc"], errors[0]["msg"]
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    if loc[1:2] == ["file"]:
        return UsageError(detail)  # which names the file
    if loc[0] == "query":
        return UsageError(f"{option_name(str(loc[1]))}: {message}{more}")
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc[1:])
    return UsageError(f"{name}: {place.removeprefix('.')}{': ' if place else ''}{message}{more}")


def option_name(name: str) -> str:
    """Write a parameter as the option that it is."""
    return f"{'-' if len(name) == 1 else '--'}{name.replace('_', '-')}"
