"""The forms of an answer, and which of them a client wants (RFC 9110 §12.5.1)."""

from __future__ import annotations

from collections.abc import Sequence

from service.intake import refuse

__all__ = ["FORMS", "decided", "negotiate"]

FORMS: dict[str, str] = {
    "json": "application/json",
    "geojson": "application/geo+json",
    "csv": "text/csv",
    "txt": "text/plain",
    "svg": "image/svg+xml",
    "png": "image/png",
    "dxf": "image/vnd.dxf",
    "stl": "model/stl",
    "obj": "model/obj",
    "ply": "application/x-ply",
    "glb": "model/gltf-binary",
}
"""Form, as in ``?format=`` and in file names, to media type."""


def negotiate(accept: str | None, form: str | None, offered: Sequence[str]) -> str:
    """Choose the form of an answer.

    Parameters
    ----------
    accept : str or None
        The ``Accept`` header. A browser, which asks for ``text/html`` first and
        for anything else as well, gets the preferred form.
    form : str or None
        ``?format=``; it wins over ``accept``.
    offered : sequence of str
        Keys of `FORMS`, the preferred one first.

    Returns
    -------
    str
        One of ``offered``.

    Raises
    ------
    IntakeError
        422 for a ``format`` that does not exist, 406 when what is wanted is not offered.
    """
    if form:
        return _named(form.strip().lower(), offered)
    if accept is None or not accept.strip():
        return offered[0]
    ranges = _ranges(accept)
    if ranges.get("text/html", 0.0) > 0 and _quality(FORMS[offered[0]], ranges) > 0:
        return offered[0]
    best = max(offered, key=lambda name: _quality(FORMS[name], ranges))  # of equals, max keeps the first
    if _quality(FORMS[best], ranges) <= 0:
        raise refuse("not-acceptable", f"offered are {_list(offered)}", ("header", "accept"))
    return best


def decided(accept: str | None, form: str | None) -> bool:
    """Say whether a client names any form at all; ``*/*`` names none."""
    return bool(form) or bool(accept and accept.strip() and _ranges(accept).keys() != {"*/*"})


def _named(form: str, offered: Sequence[str]) -> str:
    if form not in FORMS:
        detail = f"there is no such format; offered are {_list(offered)}"
        raise refuse("invalid-parameter", detail, ("query", "format"), "enum")
    if form not in offered:
        raise refuse("not-acceptable", f"offered are {_list(offered)}", ("query", "format"))
    return form


def _list(offered: Sequence[str]) -> str:
    return ", ".join(f"{FORMS[name]} (format={name})" for name in offered)


def _ranges(accept: str) -> dict[str, float]:
    """Media ranges with their weights; what cannot be read is passed over."""
    ranges: dict[str, float] = {}
    for item in accept.lower().split(","):
        name, *parameters = (part.strip() for part in item.split(";"))
        weight = next((part[2:] for part in parameters if part.startswith("q=")), "1")
        try:
            ranges[name] = min(max(float(weight), 0.0), 1.0)
        except ValueError:
            continue
    return ranges


def _quality(media_type: str, ranges: dict[str, float]) -> float:
    """Weight of a media type: that of the most specific range that covers it."""
    family = media_type.partition("/")[0] + "/*"
    return next((ranges[name] for name in (media_type, family, "*/*") if name in ranges), 0.0)
