"""Bodies in NumPy's ``.npy`` format (NEP 1), read without ``pickle``.

The header is parsed here and not by ``numpy.load``: a request may name only
the plain numeric types, and may not make the reader allocate what the body
does not hold.
"""

from __future__ import annotations

import ast
import math
import re
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from service.intake.errors import IntakeError, refuse

__all__ = ["decode_npy"]

_MAGIC = b"\x93NUMPY"
_MAX_HEADER = 4096  # numpy writes 118 bytes for a plain array
_PLAIN_TYPE = re.compile(r"[<>=|]?[fiu]\d{1,2}")


def decode_npy(body: bytes) -> NDArray[Any]:
    """Read an array of integers or floats of any size, byte order and memory order.

    Returns
    -------
    array
        With the shape and type of the file, in memory of its own: compiled
        kernels then see one type of array, never a read-only one.

    Raises
    ------
    IntakeError
        400 for a body that is no ``.npy`` file or is cut off, 422 for elements that are not numbers.
    """
    header, start = _header(body)
    dtype, shape = _element_type(header), _shape(header)
    size = math.prod(shape) * dtype.itemsize
    if len(body) - start != size:
        raise _broken(f"its header announces {size} bytes of numbers, but {len(body) - start} follow")
    flat = np.frombuffer(body, dtype, offset=start)
    return flat.reshape(shape, order="F" if header.get("fortran_order") else "C").copy(order="C")


def _header(body: bytes) -> tuple[dict[str, Any], int]:
    """Parse the header; also return where the numbers begin."""
    if not body.startswith(_MAGIC) or len(body) < 10:
        raise _broken("it does not begin as one")
    wide = body[6] > 1  # version 1 has two bytes for the length of the header, later ones four
    start = 12 if wide else 10
    if len(body) < start:
        raise _broken("it is cut off")
    (length,) = struct.unpack_from("<I" if wide else "<H", body, 8)
    if length > min(_MAX_HEADER, len(body) - start):
        raise _broken("its header is cut off or too long")
    try:
        header = ast.literal_eval(body[start : start + length].decode("utf-8").strip())
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError) as error:
        raise _broken("its header cannot be read") from error
    if not isinstance(header, dict):
        raise _broken("its header cannot be read")
    return header, start + length


def _element_type(header: dict[str, Any]) -> np.dtype[Any]:
    description = header.get("descr")
    if isinstance(description, str) and _PLAIN_TYPE.fullmatch(description):
        try:
            return np.dtype(description)
        except TypeError:  # f3, or the extended floats of another machine
            pass
    detail = "the elements of the array must be plain integers or floats"
    raise refuse("invalid-points", detail, ("body", "points"), "array_type")


def _shape(header: dict[str, Any]) -> tuple[int, ...]:
    shape = header.get("shape")
    if (
        not isinstance(shape, tuple)
        or len(shape) > 8
        or not all(type(n) is int and 0 <= n < 2**48 for n in shape)
    ):
        raise _broken("its header names no sound shape")
    return shape


def _broken(reason: str) -> IntakeError:
    return refuse("unreadable-body", f"the body is not a sound .npy file: {reason}", ("body",), "npy_invalid")
