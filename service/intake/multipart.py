"""Forms (``multipart/form-data``, RFC 7578), as browsers and ``curl -F`` send them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from service.intake.errors import refuse

if TYPE_CHECKING:
    from python_multipart.multipart import MultipartCallbacks

__all__ = ["Part", "split_form"]

_MAX_PARTS = 64


@dataclass(slots=True)
class Part:
    """One field of a form; ``filename`` and ``content_type`` are empty where the sender gave none."""

    name: str = ""
    filename: str = ""
    content_type: str = ""
    chunks: list[bytes] = field(default_factory=list)

    @property
    def content(self) -> bytes:
        """The field's bytes."""
        return b"".join(self.chunks)


def split_form(body: bytes, boundary: str | None) -> list[Part]:
    """Split a form into its fields, in the order of the body.

    Raises
    ------
    IntakeError
        400 for a body that is no form, or is cut off, or has more than 64 fields.
    """
    if not boundary:
        raise _unreadable("the Content-Type names no boundary")
    reader = _Reader()
    try:
        parser = MultipartParser(boundary.encode("latin-1"), reader.callbacks())
        parser.write(body)
        parser.finalize()
    except (FormParserError, ValueError) as error:
        raise _unreadable("its parts do not match the boundary or have broken headers") from error
    if not reader.ended:
        raise _unreadable("it ends before its closing boundary")
    return reader.parts


class _Reader:
    """Collects what the parser finds."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.ended = False
        self._name = b""
        self._value = b""

    def callbacks(self) -> MultipartCallbacks:
        return {
            "on_part_begin": self._begin,
            "on_part_data": self._data,
            "on_header_field": self._header_name,
            "on_header_value": self._header_value,
            "on_header_end": self._header_end,
            "on_end": self._end,
        }

    def _begin(self) -> None:
        if len(self.parts) >= _MAX_PARTS:
            raise _unreadable(f"it has more than {_MAX_PARTS} fields")
        self.parts.append(Part())

    def _data(self, data: bytes, start: int, end: int) -> None:
        self.parts[-1].chunks.append(data[start:end])

    def _header_name(self, data: bytes, start: int, end: int) -> None:
        self._name += data[start:end]

    def _header_value(self, data: bytes, start: int, end: int) -> None:
        self._value += data[start:end]

    def _header_end(self) -> None:
        part, name = self.parts[-1], self._name.lower()
        if name == b"content-disposition":
            _, options = parse_options_header(self._value)
            part.name = options.get(b"name", b"").decode("utf-8", "replace")
            part.filename = options.get(b"filename", b"").decode("utf-8", "replace")
        elif name == b"content-type":
            part.content_type = self._value.decode("latin-1")
        self._name = self._value = b""

    def _end(self) -> None:
        self.ended = True


def _unreadable(reason: str) -> Exception:
    return refuse(
        "unreadable-body", f"the body is not a sound form: {reason}", ("body",), "multipart_invalid"
    )
