"""The body of a request on its way to a worker: counted while it arrives, large ones kept on disk."""

from __future__ import annotations

import hashlib
import tempfile
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from anyio import to_thread

from service.intake import IntakeError, refuse

__all__ = ["Body", "receive"]

IN_MEMORY = 1024 * 1024
"""Bytes of a body that the web process holds; more go to a file, so that many large uploads at once fit."""


@dataclass(frozen=True, slots=True)
class Body:
    """A whole body: in memory, or in a file that lives as long as the request, unless it is moved away.

    ``digest`` is that of the body and of what else was asked to be part of it.
    """

    content: bytes
    path: Path | None = None
    size: int = 0
    digest: str = ""

    def read(self) -> bytes:
        """Return the bytes (in a worker: a file is read at one go)."""
        return self.content if self.path is None else self.path.read_bytes()


@asynccontextmanager
async def receive(
    chunks: AsyncIterator[bytes],
    announced: int | None,
    max_bytes: int,
    directory: Path | None = None,
    told: bytes | None = None,
) -> AsyncIterator[Body]:
    """Read a body to its end; the file that it may be in is removed with the block.

    Parameters
    ----------
    chunks : async iterator of bytes
    announced : int or None
        The ``Content-Length``, which saves reading what is too large anyway.
    max_bytes : int
    directory : Path, optional
        Where large bodies wait; the system's directory for temporary files by default.
    told : bytes, optional
        What the client has said besides; with it, a digest is made of both.

    Raises
    ------
    IntakeError
        413, as soon as it is known, also of a body in chunks that announces no length.
    """
    if announced is not None and announced > max_bytes:
        raise _too_large(max_bytes)
    path = (directory or Path(tempfile.gettempdir())) / f"tapeline-{uuid.uuid4().hex}"
    digest = None if told is None else hashlib.sha256(told)
    held = bytearray()
    total = 0
    file: BinaryIO | None = None
    try:
        async for chunk in chunks:
            total += len(chunk)
            if total > max_bytes:
                raise _too_large(max_bytes)
            if digest is not None:
                digest.update(chunk)
            held += chunk
            if len(held) > IN_MEMORY:
                if file is None:
                    file = await to_thread.run_sync(path.open, "wb")
                await to_thread.run_sync(file.write, held)
                held = bytearray()
        hexadecimal = "" if digest is None else digest.hexdigest()
        if file is None:
            yield Body(bytes(held), None, total, hexadecimal)
            return
        file.write(held)
        file.close()
        yield Body(b"", path, total, hexadecimal)
    finally:
        if file is not None:
            file.close()
            path.unlink(missing_ok=True)  # unless it was moved into the store


def _too_large(max_bytes: int) -> IntakeError:
    return refuse("too-many-bytes", f"the body has more than the {max_bytes} bytes allowed")
