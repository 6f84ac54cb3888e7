"""Names of what comes in: media types, and the endings of file names that stand for them."""

from __future__ import annotations

from pathlib import PurePath

from python_multipart.multipart import parse_options_header

from service.intake.errors import refuse

__all__ = [
    "CONF",
    "CSV",
    "JSON",
    "MULTIPART",
    "NPY",
    "OBJ",
    "PLAIN",
    "PLY",
    "STL",
    "media_type_of_name",
    "parse_media_type",
]

JSON = "application/json"
NPY = "application/x-npy"
CSV = "text/csv"
PLAIN = "text/plain"
MULTIPART = "multipart/form-data"
PLY = "application/x-ply"
STL = "model/stl"
OBJ = "model/obj"
CONF = "text/x-bmesh"  # nobody else's name: poses come beside their scans only

_ENDINGS = {
    ".json": JSON,
    ".npy": NPY,
    ".csv": CSV,
    ".tsv": CSV,
    ".txt": PLAIN,
    ".xyz": PLAIN,
    ".ply": PLY,
    ".stl": STL,
    ".obj": OBJ,
    ".conf": CONF,
}
_ENCODINGS = {".gz": "gzip", ".zst": "zstd"}


def parse_media_type(header: str) -> tuple[str, dict[str, str]]:
    """Split a ``Content-Type`` into the media type in lower case and its parameters."""
    try:
        media_type, parameters = parse_options_header(header)
        return (
            media_type.decode("latin-1").strip().lower(),
            {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in parameters.items()},
        )
    except (ValueError, LookupError) as error:  # non-Latin characters, broken continuations (RFC 2231)
        raise refuse("unsupported-media-type", "the Content-Type header cannot be read") from error


def media_type_of_name(name: str) -> tuple[str | None, str | None]:
    """Media type and content encoding that the endings of a file name stand for.

    >>> media_type_of_name("cloud.csv.gz")
    ('text/csv', 'gzip')
    """
    endings = [ending.lower() for ending in PurePath(name).suffixes[-2:]]
    encoding = _ENCODINGS.get(endings[-1]) if endings else None
    if encoding:
        endings.pop()
    return _ENDINGS.get(endings[-1]) if endings else None, encoding
