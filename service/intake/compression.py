"""Content encodings: gzip always, zstd where the standard library has it (Python 3.14).

Decompression stops at the limit of bytes, so that a small body that unpacks
to a huge one costs no more than the limit.
"""

from __future__ import annotations

import importlib
import zlib
from collections.abc import Callable
from typing import Any

from service.intake.errors import refuse

__all__ = ["decompress"]

_GZIP_WINDOW = 16 + zlib.MAX_WBITS  # zlib's code for "a gzip header is expected"


def decompress(body: bytes, encoding: str | None, max_bytes: int) -> bytes:
    """Undo the ``Content-Encoding`` of a body.

    Parameters
    ----------
    body : bytes
    encoding : str or None
        The header's value; None, an empty one and ``identity`` change nothing.
    max_bytes : int
        Limit before and after decompression.

    Raises
    ------
    IntakeError
        400 for broken data, 413 above the limit, 415 for another encoding.
    """
    _check_size(len(body), max_bytes)
    name = (encoding or "").strip().lower()
    if name in {"", "identity"}:
        return body
    decoder = _DECODERS.get(name)
    if decoder is None:
        raise refuse(
            "unsupported-content-encoding",
            f"this Content-Encoding is not supported; send {' or '.join(supported())}, or the plain body",
        )
    return decoder(body, max_bytes)


def supported() -> list[str]:
    """Names of the content encodings that work here."""
    return ["gzip"] + (["zstd"] if _zstd() else [])


def _check_size(size: int, max_bytes: int) -> None:
    if size > max_bytes:
        raise refuse("too-many-bytes", f"the body has more than the {max_bytes} bytes allowed")


def _gunzip(body: bytes, max_bytes: int) -> bytes:
    return _unpack(body, max_bytes, lambda: zlib.decompressobj(_GZIP_WINDOW), (zlib.error,), "gzip")


def _unzstd(body: bytes, max_bytes: int) -> bytes:
    zstd = _zstd()
    if zstd is None:
        raise refuse(
            "unsupported-content-encoding",
            "Content-Encoding zstd needs a server on Python 3.14 or newer; send gzip, or the plain body",
        )
    return _unpack(body, max_bytes, zstd.ZstdDecompressor, (zstd.ZstdError,), "zstd")


def _zstd() -> Any:
    """Return the standard library's module, or None where there is none yet."""
    try:
        return importlib.import_module("compression.zstd")
    except ImportError:
        return None


def _unpack(
    body: bytes, max_bytes: int, new: Callable[[], Any], broken: tuple[type[Exception], ...], name: str
) -> bytes:
    """Decompress all members (RFC 1952 §2.2 allows several), never more than one byte above the limit."""
    parts: list[bytes] = []
    room = max_bytes + 1
    rest = body
    while rest:
        member = new()
        try:
            part = member.decompress(rest, room)
        except broken as error:
            raise refuse("unreadable-body", f"the body is not valid {name} data") from error
        parts.append(part)
        room -= len(part)
        if room == 0:
            _check_size(max_bytes + 1, max_bytes)
        if not member.eof:
            raise refuse("unreadable-body", f"the {name} data of the body end too early")
        rest = member.unused_data
    return parts[0] if len(parts) == 1 else b"".join(parts)


_DECODERS: dict[str, Callable[[bytes, int], bytes]] = {"gzip": _gunzip, "x-gzip": _gunzip, "zstd": _unzstd}
