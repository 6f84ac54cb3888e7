"""What the command line writes: results in the form that is wished, and how far a computation has come."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from service.cli_input import UsageError

__all__ = ["add_output", "form_of", "progress", "write"]

_BINARY = {"png", "npy", "stl", "ply", "glb"}
_ERASE = "\r\x1b[K"  # to the start of the line, and clear it (ECMA-48)


def add_output(parser: argparse.ArgumentParser, forms: Sequence[str], default: str) -> None:
    """Add the options that say where the output goes, and in which form."""
    parser.add_argument("-o", "--output", metavar="FILE", help="file to write; default: standard output")
    parser.add_argument(
        "--format", choices=forms, help=f"form of the output; default: by the name of the file, or {default}"
    )
    if "json" in forms and default != "json":
        parser.add_argument(
            "--json", action="store_const", const="json", dest="format", help="the same as --format json"
        )
    parser.set_defaults(forms=forms, default_form=default)


def form_of(options: argparse.Namespace) -> str:
    """Form of the output: as asked for, or by the ending of the file's name."""
    if options.format or options.output is None:
        return options.format or options.default_form  # type: ignore[no-any-return] # a Namespace has no types
    form = Path(options.output).suffix.lower().removeprefix(".")
    if form not in options.forms:
        raise UsageError(
            f"{options.output}: choose a name that ends in .{', .'.join(options.forms)}, or --format"
        )
    return form


def write(content: bytes, output: str | None, form: str) -> None:
    """Write to a file, or to the standard output.

    Raises
    ------
    UsageError
        When it cannot be written, or is not for terminals.
    """
    if output is None:
        if form in _BINARY and sys.stdout.isatty():
            raise UsageError(f"{form} is not for terminals; name a file with -o")
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    try:
        Path(output).write_bytes(content)
    except OSError as error:
        raise UsageError(f"{output}: {error.strerror}") from None


@contextmanager
def progress() -> Iterator[Callable[[float, str], None] | None]:
    """Tell on one line of a terminal how far a computation has come; elsewhere nobody listens."""
    if not sys.stderr.isatty():
        yield None
        return

    def told(fraction: float, what: str) -> None:
        sys.stderr.write(f"{_ERASE}{fraction:4.0%} {what}")
        sys.stderr.flush()

    try:
        yield told
    finally:
        sys.stderr.write(_ERASE)
        sys.stderr.flush()
