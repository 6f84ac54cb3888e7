"""The header of PLY files, and the elements that its readers share."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from service.intake.errors import IntakeError, refuse

__all__ = ["Element", "Header", "Property", "broken", "read_header"]

_MAX_HEADER = 65_536  # bytes: real ones have at most a few thousand
_END = b"end_header"
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}


@dataclass(frozen=True, slots=True)
class Property:
    """A property of an element: its type, and for a list the type of its length."""

    name: str
    dtype: np.dtype[np.generic]
    length: np.dtype[np.generic] | None = None


@dataclass(frozen=True, slots=True)
class Element:
    """An element, so many of it, and what each has."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        """Whether its rows are of unequal length."""
        return any(one.length is not None for one in self.properties)

    @property
    def row(self) -> np.dtype[np.void]:
        """The type of a binary row without lists."""
        return np.dtype([(one.name, one.dtype) for one in self.properties])


@dataclass(frozen=True, slots=True)
class Header:
    """What a PLY file says of itself: order of bytes (empty: text), elements, ``obj_info``, start of data."""

    order: str
    elements: list[Element]
    info: dict[str, str]
    start: int

    @property
    def names(self) -> list[str]:
        """The names of the elements."""
        return [one.name for one in self.elements]


def read_header(body: bytes) -> Header:
    """Read the header of a PLY file; lines may end as on any system.

    Raises
    ------
    IntakeError
        400 when it is no sound PLY header, or announces more rows than the body has bytes.
    """
    end = body.find(_END, 0, _MAX_HEADER)
    if not body.startswith(b"ply") or end < 0:
        raise broken("it has no PLY header")
    start = body.find(b"\n", end) + 1
    if start == 0:
        raise broken("its header has no end")
    lines = body[:end].decode("ascii", "replace").splitlines()
    try:
        header = _parsed(lines, start)
    except (ValueError, KeyError, IndexError, TypeError):
        raise broken("its header cannot be read") from None
    if sum(one.count for one in header.elements) > len(body):
        raise broken("its header announces more rows than there are bytes")
    return header


def _parsed(lines: list[str], start: int) -> Header:
    """Read the lines of a header; anything unknown raises one of the errors of a failed look-up."""
    order: str | None = None
    elements: list[Element] = []
    info: dict[str, str] = {}
    for words in (line.split() for line in lines[1:]):
        match words:
            case ["format", name, _]:
                order = _ORDERS[name]
            case ["element", name, count]:
                elements.append(Element(name, _count(count)))
            case ["property", "list", length, kind, name]:
                elements[-1].properties.append(Property(name, _type(kind, order), _type(length, order)))
            case ["property", kind, name]:
                elements[-1].properties.append(Property(name, _type(kind, order)))
            case ["obj_info", name, value]:
                info[name] = value
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(words)
    if order is None:
        raise ValueError("format")
    return Header(order, elements, info, start)


def _count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 15):
        raise ValueError(text)
    return int(text)


def _type(name: str, order: str | None) -> np.dtype[np.generic]:
    if order is None:
        raise ValueError("format comes first")
    return np.dtype((order or "=") + _TYPES[name])


def broken(reason: str) -> IntakeError:
    """Return the error for a body that is not what it says it is."""
    return refuse("unreadable-body", f"the body is not a sound PLY file: {reason}", ("body",), "ply_invalid")
