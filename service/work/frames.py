"""How the web process and a worker talk: frames of a length and a pickle, over two pipes."""

from __future__ import annotations

import pickle
import struct
from dataclasses import dataclass
from typing import Any, BinaryIO

__all__ = ["HEADER", "Failure", "dump", "load", "read", "write"]

HEADER = struct.Struct(">Q")
"""The length of the pickle that follows."""


@dataclass(frozen=True, slots=True)
class Failure:
    """What a call raised, as a traceback in text: the web process need not know the error's class."""

    text: str


def dump(value: object) -> bytes:
    """Make a frame."""
    content = pickle.dumps(value, protocol=5)
    return HEADER.pack(len(content)) + content


def load(content: bytes | bytearray) -> Any:
    """Read what follows the header; both ends of the pipes are ours, so that pickle is safe."""
    return pickle.loads(content)  # noqa: S301 # never bytes of a client


def read(stream: BinaryIO) -> Any:
    """Wait for a frame.

    Raises
    ------
    EOFError
        When the other end is closed.
    """
    (length,) = HEADER.unpack(_exactly(stream, HEADER.size))
    return load(_exactly(stream, length))


def write(stream: BinaryIO, value: object) -> None:
    """Send a frame."""
    content = pickle.dumps(value, protocol=5)
    stream.write(HEADER.pack(len(content)))
    stream.write(content)
    stream.flush()


def _exactly(stream: BinaryIO, size: int) -> bytes:
    content = stream.read(size)
    if len(content) < size:
        raise EOFError
    return content
