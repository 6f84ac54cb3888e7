"""The body of a request on its way to a worker: counted while it arrives, large ones kept on disk."""

from __future__ import annotations

import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from anyio import to_thread

from service.intake import IntakeError, refuse

__all__ = ["Body", "receive"]

IN_MEMORY = 1024 * 1024
"""Bytes of a body that the web process holds; more go to a file, so that many large uploads at once fit."""


@dataclass(frozen=True, slots=True)
class Body:
    """A whole body: in memory, or in a file that lives as long as the request."""

    content: bytes
    path: Path | None = None

    def read(self) -> bytes:
        """Return the bytes (in a worker: a file is read at one go)."""
        return self.content if self.path is None else self.path.read_bytes()


@asynccontextmanager
async def receive(chunks: AsyncIterator[bytes], announced: int | None, max_bytes: int) -> AsyncIterator[Body]:
    """Read a body to its end; the file that it may be in is removed with the block.

    Parameters
    ----------
    chunks : async iterator of bytes
    announced : int or None
        The ``Content-Length``, which saves reading what is too large anyway.
    max_bytes : int

    Raises
    ------
    IntakeError
        413, as soon as it is known, also of a body in chunks that announces no length.
    """
    if announced is not None and announced > max_bytes:
        raise _too_large(max_bytes)
    held = bytearray()
    total = 0
    file: IO[bytes] | None = None
    try:
        async for chunk in chunks:
            total += len(chunk)
            if total > max_bytes:
                raise _too_large(max_bytes)
            held += chunk
            if len(held) > IN_MEMORY:
                file = file or tempfile.NamedTemporaryFile(prefix="tapeline-")  # noqa: SIM115 # closed below
                await to_thread.run_sync(file.write, held)
                held = bytearray()
        if file is None:
            yield Body(bytes(held))
            return
        file.write(held)
        file.flush()
        yield Body(b"", Path(file.name))
    finally:
        if file is not None:
            file.close()


def _too_large(max_bytes: int) -> IntakeError:
    return refuse("too-many-bytes", f"the body has more than the {max_bytes} bytes allowed")
