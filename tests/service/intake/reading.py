"""What the tests of intake share: read a body, or catch its refusal."""

from __future__ import annotations

from typing import Any

import orjson

from core.parameters import PcaParameters
from service.intake import IntakeError, Limits, Submission, decode

JSON, CSV, NPY = "application/json", "text/csv", "application/x-npy"
LIMITS = Limits(max_points=10_000, max_bytes=1_000_000)


def read(body: bytes, content_type: str | None = JSON, **options: Any) -> Submission:
    return decode(
        body,
        content_type,
        options.get("encoding"),
        options.get("query", {}),
        PcaParameters,
        options.get("include", frozenset({"stages"})),
        options.get("limits", LIMITS),
    )


def refusal(body: bytes, content_type: str | None = JSON, **options: Any) -> IntakeError:
    try:
        read(body, content_type, **options)
    except IntakeError as error:
        return error
    raise AssertionError("the body was accepted")


def places(error: IntakeError) -> list[list[str | int]]:
    return [item["loc"] for item in error.errors]


def dumped(**document: object) -> bytes:
    return orjson.dumps(document, option=orjson.OPT_SERIALIZE_NUMPY)
