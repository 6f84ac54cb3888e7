"""``python -m service.openapi FILE``: write the OpenAPI document, as ``make openapi`` does."""

from __future__ import annotations

import sys
from pathlib import Path

import orjson

from service.app import create_app
from service.settings import Settings

__all__ = ["main", "write"]


def write() -> bytes:
    """Return the OpenAPI document as it lies in the repository: indented, with a line feed at the end."""
    app = create_app(Settings(_env_file=None))
    return orjson.dumps(app.openapi(), option=orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE)


def main(arguments: list[str]) -> None:
    """Write the document to the file named, or to the standard output."""
    if arguments:
        Path(arguments[0]).write_bytes(write())
    else:
        sys.stdout.buffer.write(write())


if __name__ == "__main__":
    main(sys.argv[1:])
